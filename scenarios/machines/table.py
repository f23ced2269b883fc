"""machines.csv: the data of machines, one a row, under the names of the observer's parameters.

    unit,machine_model,S_n,omega_s,H,D,xd,xd1,xq,xq1,Td10,Tq10,Ra
    G6,two_axis,1000,376.991,3.48,0,2.54,0.5,2.41,0.5,7.3,0.4,0

Lines that begin with # are comments. A cell may be empty where the model does not need it. How to use it:

    machine = table.read_machine("machines.csv", "G6")   # without a name: the only one of the file
    machine.parameters                                   # {"machine_model": "two_axis", "H": 3.48, ...}: as the FMU
                                                         # takes them, on the machine's base S_n
    machine.V_n                                          # kV line-line, or None
"""

import csv
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from ..errors import UserError, alternatives

PARAMETERS: dict[str, str] = {
    "S_n": "MVA",
    "omega_s": "rad/s",
    "H": "s",
    "D": "s/rad",
    "xd": "pu",
    "xd1": "pu",
    "xd2": "pu",
    "xq": "pu",
    "xq1": "pu",
    "xq2": "pu",
    "xl": "pu",
    "Td10": "s",
    "Tq10": "s",
    "Td20": "s",
    "Tq20": "s",
    "S10": "1",
    "S12": "1",
    "Kis": "1",
    "Ra": "pu",
    "x_T": "pu",
    "r_T": "pu",
    "tap": "1",
    "shift": "rad",
}
"""Numbers, and their units; per unit on the machine's own S_n. The names are the observer's."""

TEXTS = ("unit", "machine_model", "bus", "id", "comment")
V_N = "V_n"
"""kV line-line; not of the observer, but it tells a wrong base of the voltage."""

TWO_AXIS = ("S_n", "omega_s", "H", "xd", "xd1", "xq", "xq1", "Td10", "Tq10")
NEEDED: dict[str, tuple[str, ...]] = {
    "two_axis": TWO_AXIS,
    "genrou": (*TWO_AXIS, "xd2", "xl", "Td20", "Tq20"),
    "gentpj": (*TWO_AXIS, "xd2", "xq2", "xl", "Td20", "Tq20"),
    "gensal": ("S_n", "omega_s", "H", "xd", "xd1", "xd2", "xq", "xl", "Td10", "Td20", "Tq20"),
    "gensae": ("S_n", "omega_s", "H", "xd", "xd1", "xd2", "xq", "xl", "Td10", "Td20", "Tq20"),
}
"""What each machine model cannot do without: no value of another machine may stand in silently."""


class MachineError(UserError):
    """What is wrong with machine data, and what to do about it."""


@dataclass(frozen=True)
class Machine:
    """One machine. `parameters` are the observer's, on its base S_n."""

    unit: str
    parameters: dict[str, float | str]
    V_n: float | None = None
    """Rated voltage, kV line-line."""
    bus: str = ""
    id: str = ""
    comment: str = ""
    model: str = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "model", str(self.parameters["machine_model"]))

    def __getitem__(self, name: str) -> float:
        """A number among the parameters."""
        return float(self.parameters[name])


def read_machines(path: Path | str) -> dict[str, Machine]:
    """All machines of a file, by name. Raises MachineError, naming the file, the machine and what to do."""
    path = Path(path)
    if not path.is_file():
        raise MachineError(f"there is no file {path}")
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except UnicodeDecodeError:
        raise MachineError(f"{path} is no text; python -m scenarios machine makes a machines.csv of a .dyr") from None
    rows = list(csv.reader(line for line in lines if line.strip() and not line.startswith("#")))
    if len(rows) < 2:
        raise MachineError(f"{path} has no machine: write a header and a row for each machine")
    names = [name.strip() for name in rows[0]]
    known = [*TEXTS, V_N, *PARAMETERS]
    for name in names:
        if name not in known:
            raise MachineError(f'{path}: column "{name}" is not known; {alternatives(name, known)}')
        if names.count(name) > 1:
            raise MachineError(f'{path}: column "{name}" stands twice')
    if "unit" not in names:
        raise MachineError(f'{path}: there is no column "unit", the name of each machine')
    machines: dict[str, Machine] = {}
    for row in rows[1:]:
        if len(row) != len(names):
            raise MachineError(f"{path}: the row {','.join(row)} has {len(row)} cells, the header has {len(names)}")
        cells = {name: cell.strip() for name, cell in zip(names, row, strict=True) if cell.strip()}
        where = f"{path}: {cells.get('unit', 'a machine without a name')}"
        machine = machine_of(cells, where)
        if machine.unit in machines:
            raise MachineError(f"{where} stands twice; give each unit its own name")
        machines[machine.unit] = machine
    return machines


def read_machine(path: Path | str, unit: str | None = None) -> Machine:
    """The machine of that name; without a name, the only one of the file. Raises MachineError."""
    machines = read_machines(path)
    if unit is None:
        if len(machines) > 1:
            raise MachineError(f"{path} holds {len(machines)} machines; choose one with --unit: {', '.join(machines)}")
        return next(iter(machines.values()))
    if unit not in machines:
        raise MachineError(f'{path} has no unit "{unit}"; {alternatives(unit, list(machines))}')
    return machines[unit]


def machine_of(cells: Mapping[str, str], where: str) -> Machine:
    """A machine from the cells of its row; empty ones are left out."""
    if "unit" not in cells:
        raise MachineError(f"{where}: give it one in the column unit")
    model = cells.get("machine_model", "two_axis")
    if model not in NEEDED:
        raise MachineError(f'{where}: machine_model "{model}" is not known; {alternatives(model, list(NEEDED))}')
    numbers = {name: number(cells[name], name, where) for name in (V_N, *PARAMETERS) if name in cells}
    missing = [name for name in NEEDED[model] if name not in numbers]
    if missing:
        raise MachineError(f"{where}: {model} needs {', '.join(missing)}; fill in the column")
    parameters: dict[str, float | str] = {"machine_model": model}
    given = {**dict.fromkeys(("D", "Ra"), 0.0), **numbers}
    parameters.update({name: given[name] for name in PARAMETERS if name in given})
    texts = {name: cells.get(name, "") for name in ("bus", "id", "comment")}
    return Machine(cells["unit"], parameters, numbers.get(V_N), **texts)


def number(text: str, name: str, where: str) -> float:
    try:
        value = float(text)
    except ValueError:
        raise MachineError(f'{where}: {name} = "{text}" is no number') from None
    if not abs(value) < 1e9:
        raise MachineError(f"{where}: {name} = {text} is not a finite number")
    return value


def write_machines(machines: Mapping[str, Machine], path: Path | str) -> None:
    """A machines.csv that `read_machines` gives back; numbers with all their digits."""
    columns = ["unit", *TEXTS[1:], V_N, *PARAMETERS]
    rows = [row_of(machine) for machine in machines.values()]
    used = [name for name in columns if any(row.get(name, "") != "" for row in rows)]
    with Path(path).open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(used)
        writer.writerows([[row.get(name, "") for name in used] for row in rows])


def row_of(machine: Machine) -> dict[str, str]:
    row = {name: value if isinstance(value, str) else repr(value) for name, value in machine.parameters.items()}
    row.update(unit=machine.unit, bus=machine.bus, id=machine.id, comment=machine.comment)
    return row | ({} if machine.V_n is None else {V_N: repr(machine.V_n)})
