"""PSS/E's power flow data, .raw: of each generator MBASE, ZR and the step-up transformer; of its bus the voltage; f.

    generator: I, ID, PG, QG, QT, QB, VS, IREG, [NREG from 35 on,] MBASE, ZR, ZX, RT, XT, GTAP, STAT, ...
    bus:       I, 'NAME', BASKV, ...

Sections end with a record that begins with 0, which names the next one in a comment; else the order tells.
Siemens PTI, "PSS/E Program Operation Manual", power flow raw data file.
"""

import csv
from dataclasses import dataclass
from pathlib import Path

from .dyr import before_slash
from .table import MachineError

HEAD = 3
"""Lines before the first section."""

WITHOUT_SHUNTS = ("BUS", "LOAD", "GENERATOR")
SECTIONS: tuple[str, ...] = ("BUS", "LOAD", "FIXED SHUNT", "GENERATOR")
"""From version 31 on."""

SYSTEM_WIDE = 34
NREG = 35
"""Versions from which on there is a section before the buses, and a field more."""


@dataclass(frozen=True)
class Generator:
    S_n: float
    """MVA, MBASE."""
    Ra: float
    """pu of S_n, ZR."""
    r_T: float
    x_T: float
    """pu of S_n, RT and XT: a step-up transformer between the machine and its bus; 0: none."""
    tap: float
    """GTAP, turns at the bus over turns at the machine, off nominal."""
    V_bus: float | None
    """kV line-line, BASKV of the bus."""
    name: str
    """Of the bus."""


@dataclass(frozen=True)
class Raw:
    frequency: float | None
    """Hz; versions before 31 do not say."""
    generators: dict[tuple[int, str], Generator]
    """By bus and id."""


def read(path: Path) -> Raw:
    """Raises MachineError with file, line and record for what is broken."""
    if not path.is_file():
        raise MachineError(f"there is no file {path}")
    text = path.read_bytes()
    if b"\0" in text:
        raise MachineError(f"{path} is no text; save the case as .raw, not as .sav")
    lines = [(number, line) for number, line in enumerate(text.decode("utf-8-sig", "replace").splitlines(), 1)]
    lines = [(number, line) for number, line in lines if not line.lstrip().startswith("@!")]
    if len(lines) <= HEAD:
        raise MachineError(f"{path} has {len(lines)} lines: no power flow case")
    head = cells(lines[0][1])
    try:
        int(head[0])
        version = int(float(head[2])) if len(head) > 2 and head[2] else 0
        frequency = float(head[5]) if len(head) > 5 and head[5] else None
    except (ValueError, IndexError):
        raise MachineError(f'{path}, line 1: "{lines[0][1].strip()}" is not IC, SBASE, REV, ...') from None
    buses: dict[int, tuple[str, float | None]] = {}
    generators: dict[tuple[int, str], Generator] = {}
    for section, number, line in in_sections(lines[HEAD:], version):
        row = cells(line)
        try:
            if section == "BUS":
                buses[int(row[0])] = row[1], float(row[2]) if row[2] else None
            elif section == "GENERATOR":
                generators[int(row[0]), row[1] or "1"] = generator(row, version, buses)
        except (ValueError, IndexError):
            kind = section.lower()
            raise MachineError(f'{path}, line {number}: "{line.strip()[:60]}" is no record of a {kind}') from None
    if not generators:
        raise MachineError(f"{path} has no generator: no section of generators was found")
    return Raw(frequency, generators)


def in_sections(lines: list[tuple[int, str]], version: int):
    """(section, line number, line) of each record of a bus, a load, a shunt and a generator."""
    order = list(SECTIONS if version >= 31 else WITHOUT_SHUNTS)
    if version >= SYSTEM_WIDE:
        order.insert(0, "SYSTEM-WIDE")
    place = 0
    for number, line in lines:
        content, _, comment = before_slash(line)
        if content.strip().upper() == "Q":
            return
        if content.strip().split(",")[0].split()[:1] == ["0"]:
            named = [k for k, name in enumerate(order) if f"BEGIN {name}" in comment.upper()]
            place = named[0] if named else place + 1
            if place >= len(order):
                return
        elif content.strip():
            yield order[place], number, line


def cells(line: str) -> list[str]:
    content, _, _ = before_slash(line)
    return [
        cell.strip().strip("'\"").strip() for cell in next(csv.reader([content], quotechar="'", skipinitialspace=True))
    ]


def generator(row: list[str], version: int, buses: dict[int, tuple[str, float | None]]) -> Generator:
    first = 9 if version >= NREG else 8

    def value(place: int, default: float) -> float:
        return float(row[first + place]) if len(row) > first + place and row[first + place] else default

    name, V_bus = buses.get(int(row[0]), ("", None))
    S_n = float(row[first])
    if not S_n > 0:
        raise ValueError("MBASE")
    return Generator(S_n, value(1, 0.0), value(3, 0.0), value(4, 0.0), value(5, 1.0), V_bus or None, name)
