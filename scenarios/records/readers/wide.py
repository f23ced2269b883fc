"""Wide CSV: a row a frame, a column a signal, as SynchroWAVe, PhasorPoint, PI and other historians export it.

Any separator, decimal comma, quoted names, a row of units under the names, units in the names: `V1 Mag (kV)`.
"""

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from .. import units
from . import delimited
from .table import Block, Hints

IN_NAME = re.compile(r".*[(\[]\s*([^()\[\]]+?)\s*[)\]]\s*")
"""A unit in brackets at the end of a name."""


class WideTable:
    def __init__(self, path: Path, form: delimited.Form):
        self.path, self.form = path, form
        self.names = distinct(form.header[0])
        self.units = units_of(self.names, form.header[1:])
        self.hints = Hints()

    def blocks(self, numbers: Sequence[str], texts: Sequence[str]) -> Iterator[Block]:
        return delimited.blocks(self.path, self.form, self.names, numbers, texts)


def recognises(path: Path, form: delimited.Form | None) -> bool:
    return form is not None


def open_table(path: Path, form: delimited.Form) -> WideTable:
    return WideTable(path, form)


def distinct(names: Sequence[str]) -> list[str]:
    """A name that stands twice gets a number."""
    found: list[str] = []
    for name in names:
        name, count = name.strip(), 2
        plain = name
        while name in found:
            name, count = f"{plain} ({count})", count + 1
        found.append(name)
    return found


def units_of(names: Sequence[str], rows: Sequence[Sequence[str]]) -> dict[str, str]:
    """Units by column: of the first row below the names in which most cells are units, or of the names' brackets."""
    for row in rows:
        filled = [cell for cell in row if cell.strip()]
        if filled and 2 * sum(map(is_unit, filled)) > len(filled):
            return {name: bare(cell) for name, cell in zip(names, row, strict=True) if cell and is_unit(cell)}
    brackets = {name: match[1] for name in names if (match := IN_NAME.fullmatch(name))}
    return {name: unit for name, unit in brackets.items() if is_unit(unit)}


def bare(cell: str) -> str:
    return cell.strip().strip("[]()").strip()


def is_unit(cell: str) -> bool:
    try:
        return bool(bare(cell)) and bool(units.unit(bare(cell)))
    except ValueError:
        return False
