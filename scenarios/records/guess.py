"""A first MAP from a file's header, for a person to mend: names, units and magnitudes tell what is likely which."""

import re
from collections.abc import Mapping, Sequence

import numpy as np

from . import units
from .readers import Table

WORDS = {
    "V": {"v", "u", "volt", "voltage", "vm", "va", "vp", "kv", "v1", "u1", "v_t", "vt", "theta"},
    "I": {"i", "curr", "current", "im", "ia", "ip", "i1", "amp", "phi"},
    "angle": {"a", "ang", "angle", "phase", "theta", "phi", "deg", "va", "ia", "ph"},
    "P": {"p", "mw", "active", "watt", "watts", "p_t"},
    "Q": {"q", "mvar", "var", "vars", "reactive"},
    "P_m": {"pm", "pmech", "mech", "mechanical", "turbine", "shaft"},
    "E_f": {"ef", "efd", "vfd", "ifd", "field", "exciter", "exc", "ufd"},
    "f": {"f", "freq", "frequency", "hz"},
    "valid": {"stat", "status", "quality", "flag", "valid"},
}
"""What names are made of, in small letters and without the digits behind them."""

TIME = r"time|stamp|date|^t$|^ts$|utc|soc"


def guessed(table: Table, source: str) -> str:
    """The text of a map; lines with a ? are guesses that a person has to answer."""
    found = columns(table.names, table.hints.types, table.units)
    samples = sample(table, found)
    lines = [f"# a first map of {source}: mend what is marked with ?", time_line(table, samples)]
    lines.append(phasor_line("V", found, table, samples, ', base = "22 kV line-line", is = "line-neutral"'))
    lines.append(phasor_line("I", found, table, samples, ', direction = "out of the generator"'))
    for name, default in (("P", "MW"), ("Q", "Mvar"), ("P_m", "MW"), ("E_f", "pu"), ("f", "Hz")):
        if name in found:
            unit = table.units.get(found[name])
            known = f'unit = "{unit}"' if unit else f'unit = "{default}"'
            lines.append(f'{name} = {{ column = "{found[name]}", {known} }}' + ("" if unit else "  # ? unit"))
    if "valid" in found:
        lines.append(f'# valid = {{ column = "{found["valid"]}", bad_bits = 0xF000 }}  # ? a STAT word of IEEE C37.118')
    if not table.hints.frequency:
        lines.append("frequency = 60  # ? Hz, nominal")
    taken = set(found.values())
    left = [name for name in table.names if name not in taken]
    lines.append(f"# columns that are not used: {', '.join(left) or 'none'}")
    return "\n".join(lines) + "\n"


def columns(names: Sequence[str], types: Mapping[str, str], stated: Mapping[str, str]) -> dict[str, str]:
    """Columns by kind (VM, VA, IM, IA, P, Q, P_m, E_f, f, valid): the first of each."""
    found: dict[str, str] = {}
    for name in names:
        kind = types.get(name) or kind_of(name, stated.get(name))
        if kind is not None and fits(kind, stated.get(name)):
            found.setdefault(kind, name)
    return found


def kind_of(name: str, unit: str | None) -> str | None:
    """By the words of a name: `v_g6_va1_m`, `G6 Pos. Voltage Angle`, `VA_M`."""
    plain = re.sub(r"[(\[].*?[)\]]", "", name).lower().replace("p_m", "pm").replace("e_f", "ef")
    words = [re.sub(r"\d+$", "", word) or word for word in re.split(r"[^a-z0-9]+", plain) if word]
    if not words or re.search(TIME, plain):
        return None
    for kind in ("P_m", "E_f", "valid"):
        if any(word in WORDS[kind] for word in words):
            return kind
    of_angle = unit is not None and is_of(unit, "angle")
    for kind in ("V", "I"):
        if words[0] in WORDS[kind] or any(word in WORDS[kind] - WORDS["angle"] for word in words):
            last_is_angle = words[-1] in WORDS["angle"] and (len(words) > 1 or len(words[0]) > 1)
            return kind + ("A" if of_angle or last_is_angle else "M")
    return next((kind for kind in ("P", "Q", "f") if any(word in WORDS[kind] for word in words)), None)


def is_of(unit: str, quantity: str) -> bool:
    try:
        return units.unit(unit).quantity == quantity
    except ValueError:
        return False


def fits(kind: str, unit: str | None) -> bool:
    """Whether a stated unit is one of that kind."""
    if not unit:
        return True
    quantities = {
        "VM": ("voltage", "per unit"),
        "VA": ("angle",),
        "IM": ("current", "per unit"),
        "IA": ("angle",),
        "P": ("active power", "per unit"),
        "Q": ("reactive power", "per unit"),
        "P_m": ("active power", "per unit"),
        "E_f": ("per unit", "voltage", "current"),
        "f": ("frequency",),
    }.get(kind)
    return quantities is None or units.unit(unit).quantity in quantities


def sample(table: Table, found: dict[str, str]) -> dict[str, np.ndarray]:
    """The first block of what was found, and of the time as text."""
    numbers = [name for kind, name in found.items() if kind != "valid"]
    time = time_column(table)
    block = next(iter(table.blocks(numbers, [time] if time else [])), None)
    return dict(block.columns) if block else {}


def time_column(table: Table) -> str | None:
    hinted = (table.hints.time or {}).get("column")
    if hinted:
        return None
    return next((name for name in table.names if re.search(TIME, name.lower())), table.names[0])


def time_line(table: Table, samples: dict[str, np.ndarray]) -> str:
    if table.hints.time:
        return "# time: the file tells it itself"
    name = time_column(table)
    first = samples[name][0].decode("utf-8", "replace").strip() if name in samples and len(samples[name]) else ""
    if re.match(r"\d{4}[-/]\d{1,2}[-/]\d{1,2}[T ]", first):
        return f'time = {{ column = "{name}", format = "iso", zone = "UTC" }}'
    if re.match(r"\d{1,2}\.\d{1,2}\.\d{4}", first):
        return f'time = {{ column = "{name}", format = "%d.%m.%Y %H:%M:%S.%f", zone = "UTC" }}  # ? zone'
    if re.match(r"\d{1,2}/\d{1,2}/\d{4}", first):
        return f'time = {{ column = "{name}", format = "%m/%d/%Y %H:%M:%S.%f", zone = "UTC" }}  # ? day and month, zone'
    try:
        value = float(first.replace(",", "."))
    except ValueError:
        return f'time = {{ column = "{name}", format = "iso" }}  # ? the first stamp is "{first}"'
    if value > 1e12:
        return f'time = {{ column = "{name}", format = "epoch", unit = "ms" }}'
    return f'time = {{ column = "{name}", format = "{"epoch" if value > 1e9 else "seconds"}" }}'


def phasor_line(kind: str, found: dict, table: Table, samples: dict, rest: str) -> str:
    first, second = found.get(f"{kind}M"), found.get(f"{kind}A")
    size, angle = table.units.get(first or ""), table.units.get(second or "")
    mark = " ? columns" if not (first and second) else ""
    if not size and first in samples:
        size, mark = size_of(kind, samples[first]), mark + " ? unit"
    if not angle and second in samples:
        angle = "rad" if np.nanmax(np.abs(samples[second]), initial=0) < 3.1416 else "deg"
        mark += " ? unit of the angle"
    mark += " ? base, is" if kind == "V" and size != "pu" else ""
    rest = "" if kind == "V" and size == "pu" else rest
    parts = f'magnitude = "{first or "?"}", angle = "{second or "?"}", unit = ["{size or "?"}", "{angle or "?"}"]'
    line = f"{kind} = {{ {parts}{rest} }}"
    return line + (f"  #{mark}" if mark else "")


def size_of(kind: str, values: np.ndarray) -> str:
    """By the magnitude: a generator has 0.4 to 30 kV, and a current of some hundred A to kA."""
    size = float(np.nanmedian(np.abs(values)))
    if kind == "V":
        return "pu" if size < 2 else "kV" if size < 1000 else "V"
    return "pu" if size < 1.5 else "kA" if size < 40 else "A"
