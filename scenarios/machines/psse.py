"""From PSS/E's machine models to the observer's: which there are, what their constants are, and what cannot be used.

All constants are per unit on MBASE. D there is pu torque per pu speed, so that the observer's is D/omega_s.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi
from pathlib import Path

from . import dyr, raw
from .table import NEEDED, Machine, MachineError

ROUND = ("Td10", "Td20", "Tq10", "Tq20", "H", "D", "xd", "xq", "xd1", "xq1", "xd2", "xl", "S10", "S12")
SALIENT = ("Td10", "Td20", "Tq20", "H", "D", "xd", "xq", "xd1", "xd2", "xl", "S10", "S12")
SALIENT_SUBTRANSIENT = (
    "Td10",
    "Td20",
    "Tq10",
    "Tq20",
    "H",
    "D",
    "xd",
    "xq",
    "xd1",
    "xq1",
    "xd2",
    "xq2",
    "xl",
    "S10",
    "S12",
)


@dataclass(frozen=True)
class Model:
    machine_model: str
    constants: tuple[str, ...]
    """In the order of the record."""
    note: str = ""


MODELS: dict[str, Model] = {
    "GENROU": Model("genrou", ROUND),
    "GENROE": Model("genrou", ROUND, "exponential saturation of GENROE, here quadratic through the same two points"),
    "GENSAL": Model("gensal", SALIENT),
    "GENSAE": Model("gensae", SALIENT),
    "GENTPF": Model("gentpj", SALIENT_SUBTRANSIENT),
    "GENTPFU1": Model("gentpj", SALIENT_SUBTRANSIENT),
    "GENTPJ": Model("gentpj", (*SALIENT_SUBTRANSIENT, "Kis")),
    "GENTPJU1": Model("gentpj", (*SALIENT_SUBTRANSIENT, "Kis")),
}
"""A new one is a line here."""

REFUSED: dict[str, str] = {
    "GENCLS": "it is a constant voltage behind a reactance: there is no E'd, E'q to observe",
    "GENTRA": "it has no q-axis winding and no subtransient data",
    "GENDCO": "its stator transients and dc torque have no counterpart here",
    "CGEN1": "a cross-compound machine model with stator data of its own",
    "CIMTR": "an induction machine has no field",
    "REGC": "a converter has no rotor angle",
    "WT": "a wind turbine's converter or induction machine has no rotor angle",
    "GEWT": "a wind turbine's converter or induction machine has no rotor angle",
    "PVGU": "a converter has no rotor angle",
    "WECC": "a converter has no rotor angle",
}
"""By the beginning of a model's name, what the observer cannot use and why."""


@dataclass(frozen=True)
class Refused:
    bus: int
    id: str
    model: str
    reason: str


def read(
    dyr_file: Path, raw_file: Path | None, S_n: float | None = None, frequency: float | None = None
) -> tuple[list[Machine], list[Refused]]:
    """The machines of a case, and those that cannot be used. S_n and the frequency are taken where no .raw says them.

    Raises MachineError for a broken file, or where something is missing that must not be guessed.
    """
    records = dyr.read(dyr_file)
    case = raw.read(raw_file) if raw_file else None
    f = (case.frequency if case else None) or frequency
    machines, refused = [], []
    for record in records:
        reason = next((why for name, why in REFUSED.items() if record.model.startswith(name)), None)
        if record.model in MODELS:
            at = case.generators.get((record.bus, record.id)) if case else None
            if case is not None and at is None:
                reason = f"{raw_file} has no generator {record.id} at bus {record.bus}"
                refused.append(Refused(record.bus, record.id, record.model, reason))
                continue
            if f is None:
                raise MachineError(f"the nominal frequency is not known ({raw_file or 'no .raw'}): give --frequency 60")
            if at is None and S_n is None:
                raise MachineError("the .raw tells each machine's MBASE: give --raw FILE.raw, or --S-n for one machine")
            found = machine(dyr_file, record, at, S_n, f)
            (refused if isinstance(found, Refused) else machines).append(found)  # type: ignore[arg-type]
        elif reason or dyr.is_machine(record.model):
            why = reason or f"the model is not known here; known: {', '.join(MODELS)}"
            refused.append(Refused(record.bus, record.id, record.model, why))
    if not machines and not refused:
        raise MachineError(f"{dyr_file} has no machine: {len(records)} records of other models")
    return machines, refused


def machine(
    path: Path, record: dyr.DyrRecord, at: raw.Generator | None, S_n: float | None, f: float
) -> Machine | Refused:
    """The observer's parameters of a record."""
    model = MODELS[record.model]
    where = f"{path}, line {record.line}: the {record.model} at bus {record.bus}, id {record.id}"
    if len(record.constants) < len(model.constants) - model.constants.count("Kis"):
        raise MachineError(f"{where} has {len(record.constants)} constants; {record.model} has {len(model.constants)}")
    given = dict(zip(model.constants, record.constants, strict=False))
    omega_s = 2 * pi * f
    values: dict[str, float] = {name: value or 0.0 for name, value in given.items()}
    zero = [name for name in NEEDED[model.machine_model] if name in given and not values[name] > 0]
    if zero:
        return Refused(record.bus, record.id, record.model, f"line {record.line}: {', '.join(zero)} is not above 0")
    values["D"] /= omega_s
    if at is None:
        assert S_n is not None  # else `read` refuses
        values |= {"S_n": S_n, "Ra": 0.0}
    else:
        values |= {"S_n": at.S_n, "Ra": at.Ra}
        if at.x_T or at.r_T:
            values |= {"x_T": at.x_T, "r_T": at.r_T, "tap": 1 / at.tap}
    values["omega_s"] = omega_s
    name = unit_name(record, at)
    V_n = at.V_bus if at is not None and not at.x_T else None  # behind a transformer the bus's is not the machine's
    parameters: dict[str, float | str] = {"machine_model": model.machine_model}
    return Machine(name, parameters | values, V_n, str(record.bus), record.id, model.note)


def unit_name(record: dyr.DyrRecord, at: raw.Generator | None) -> str:
    """`35_1`: bus and id, as they are unique; with the name of the bus where there is one."""
    plain = f"{record.bus}_{record.id}"
    name = "".join(c if c.isalnum() else "_" for c in at.name.strip()) if at else ""
    return f"{name}_{plain}" if name and not name.isdigit() else plain


def chosen(machines: Sequence[Machine], bus: str | None, id: str | None) -> list[Machine]:
    """Those at a bus, of an id. Raises MachineError if there is none."""
    found = [m for m in machines if (bus is None or m.bus == bus) and (id is None or m.id == id)]
    if not found:
        known = ", ".join(f"{m.bus} id {m.id}" for m in machines[:20]) + (" ..." if len(machines) > 20 else "")
        raise MachineError(f"there is no usable machine at bus {bus}, id {id or 'any'}; known: {known or 'none'}")
    return found
