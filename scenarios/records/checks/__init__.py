"""Does a record fulfil what that of a generator fulfils? Each check names the likely mistake and what mends it.

    findings = check(record, machine)        # a standard record, and machines.csv's machine where there is one
    is_nonsense(findings)

What no single record can show: both phasors of one wrong phase (delta is off by 120 deg), a transformer's shift
forgotten on both (30 deg: only the difference between machines shows it), a current one frame late, H, D and x'd.
Ambiguous: a wrong sign of Q reads as a shift of 30 deg where 2 phi is about that.
"""

from collections.abc import Callable, Iterable, Iterator

from ...machines.table import Machine
from ..angles import AngleRange
from ..findings import NONSENSE, Finding
from ..raster import Raster
from ..standard import StandardRecord
from . import machine as of_machine
from . import sampling, signals
from .case import Case

Check = Callable[[Case], Iterator[Finding]]
CHECKS: dict[str, Check] = {
    "machine": of_machine.machine_data,
    "raster": sampling.raster,
    "angle unit": signals.angle_unit,
    "voltage": signals.voltage,
    "current": signals.current,
    "speed": signals.speed,
    "power": signals.power,
    "sign": signals.sign,
    "P_m": of_machine.mechanical,
    "load angle": of_machine.load_angle,
    "E_f": of_machine.field_voltage,
    "held": sampling.held,
}
"""In the order of what rests on what. A new check is a function and its line here."""


def check(
    record: StandardRecord,
    machine: Machine | None = None,
    raster: Raster | None = None,
    angles: AngleRange | None = None,
) -> list[Finding]:
    """All findings, the gravest first."""
    case = Case(record, machine, raster, angles)
    if not record.frame_valid.any():
        return [Finding("voltage", NONSENSE, "no frame is usable", ("offline",))]
    for function in CHECKS.values():
        case.reported.extend(function(case))
    return sorted(case.reported, key=lambda finding: finding.grade != NONSENSE)


def is_nonsense(findings: Iterable[Finding]) -> bool:
    return any(finding.grade == NONSENSE for finding in findings)
