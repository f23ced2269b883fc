"""The units that records come in: a table of about twenty, with the spellings that exporters use.

`pint` reads "pu" as a pico-atomic-mass-unit and knows no Mvar; and nothing else is asked of units here than a factor.
"""

import re
from collections.abc import Iterable
from math import pi
from typing import NamedTuple

from ..errors import alternatives


class Unit(NamedTuple):
    symbol: str
    """As it is written here."""
    quantity: str
    factor: float
    """Of one in the quantity's first unit: V, A, W, var, VA, rad, s, Hz, pu, 1."""


TABLE = [
    Unit("V", "voltage", 1.0),
    Unit("kV", "voltage", 1e3),
    Unit("A", "current", 1.0),
    Unit("kA", "current", 1e3),
    Unit("W", "active power", 1.0),
    Unit("kW", "active power", 1e3),
    Unit("MW", "active power", 1e6),
    Unit("var", "reactive power", 1.0),
    Unit("kvar", "reactive power", 1e3),
    Unit("Mvar", "reactive power", 1e6),
    Unit("VA", "apparent power", 1.0),
    Unit("kVA", "apparent power", 1e3),
    Unit("MVA", "apparent power", 1e6),
    Unit("rad", "angle", 1.0),
    Unit("mrad", "angle", 1e-3),
    Unit("deg", "angle", pi / 180),
    Unit("Hz", "frequency", 1.0),
    Unit("mHz", "frequency", 1e-3),
    Unit("s", "time", 1.0),
    Unit("ms", "time", 1e-3),
    Unit("us", "time", 1e-6),
    Unit("ns", "time", 1e-9),
    Unit("pu", "per unit", 1.0),
    Unit("%", "per unit", 1e-2),
    Unit("1", "number", 1.0),
]

SPELLINGS = {
    "volt": "V",
    "volts": "V",
    "kilovolts": "kV",
    "amp": "A",
    "amps": "A",
    "ampere": "A",
    "amperes": "A",
    "kamp": "kA",
    "watt": "W",
    "watts": "W",
    "mwatt": "MW",
    "vars": "var",
    "mvars": "Mvar",
    "mvr": "Mvar",
    "degree": "deg",
    "degrees": "deg",
    "°": "deg",
    "radian": "rad",
    "radians": "rad",
    "hertz": "Hz",
    "sec": "s",
    "second": "s",
    "seconds": "s",
    "msec": "ms",
    "µs": "us",
    "usec": "us",
    "p.u.": "pu",
    "p.u": "pu",
    "per unit": "pu",
    "percent": "%",
    "": "1",
}
"""In small letters."""

SYMBOLS = {unit.symbol: unit for unit in TABLE}
SMALL = {unit.symbol.lower(): unit for unit in TABLE}
"""No two units of the table differ in capitals only: "MW", "Mw" and "mw" are one, as exporters mean it."""


def unit(text: str) -> Unit:
    """The unit of that symbol or spelling, capitals or not. Raises ValueError with what could have been meant."""
    text = text.strip()
    if text in SYMBOLS:
        return SYMBOLS[text]
    small = text.lower()
    small = SPELLINGS.get(small, small).lower()
    if small in SMALL:
        return SMALL[small]
    raise ValueError(f'"{text}" is no unit; {alternatives(text, list(SYMBOLS))}')


def unit_of(text: str, *quantities: str) -> Unit:
    """A unit of one of the quantities. Raises ValueError."""
    found = unit(text)
    if found.quantity not in quantities:
        raise ValueError(f'"{text}" is a unit of {found.quantity}; {wanted(quantities)}')
    return found


def wanted(quantities: Iterable[str]) -> str:
    """`write kV, V or pu`."""
    symbols = [u.symbol for quantity in quantities for u in TABLE if u.quantity == quantity]
    return f"write {', '.join(symbols[:-1])} or {symbols[-1]}" if len(symbols) > 1 else f"write {symbols[0]}"


QUANTITY = re.compile(r"\s*(?P<number>[-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?)\s*(?P<unit>\S*)\s*(?P<rest>.*?)\s*")


def amount(text: str, *quantities: str) -> tuple[float, str]:
    """`22 kV line-line` as its value in the quantity's first unit, and what stands behind the unit.

    Raises ValueError, saying how it is written.
    """
    match = QUANTITY.fullmatch(text)
    if match is None:
        raise ValueError(f'"{text}" is not a number with a unit')
    try:
        value = float(match["number"])
    except ValueError:
        raise ValueError(f'"{match["number"]}" is no number') from None
    return value * unit_of(match["unit"], *quantities).factor, match["rest"]
