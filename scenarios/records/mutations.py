"""Right records with one thing wrong: does a check name the cause, and is all silent where nothing is wrong?

    python -m scenarios.records.mutations            the table: every mutation, and what was found on ten machines
    python -m scenarios.records.mutations --readme   writes it into the README of this folder

A mutation is what a wrong map, a wrong export or wrong machine data make of a right record; see `right` for these.
"""

import argparse
from collections.abc import Callable
from dataclasses import dataclass, replace
from math import radians, sqrt
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from fmu_src.runtime import readme

from ..machines.table import Machine
from ..progress import progress_bar
from .angles import AngleRange
from .checks import check
from .findings import CAUSES, Finding
from .right import EVENTS, right_records
from .standard import VALUES, StandardRecord

README = Path(__file__).parent / "README.md"


@dataclass(frozen=True)
class Sample:
    """A record as it is checked."""

    record: StandardRecord
    machine: Machine
    angles: AngleRange | None = None

    def findings(self) -> list[Finding]:
        return check(self.record, self.machine, angles=self.angles)


Mutate = Callable[[Sample], Sample]
MUTATIONS: dict[str, tuple[str, Mutate]] = {}
"""What is wrong, the cause that is to be named, and the function that makes it so."""


def mutation(what: str, cause: str) -> Callable[[Mutate], Mutate]:
    def register(function: Mutate) -> Mutate:
        MUTATIONS[what] = (cause, function)
        return function

    return register


def altered(s: Sample, **columns: np.ndarray) -> Sample:
    """Other columns; V and I as complex phasors."""
    r = s.record
    for name, (size, angle) in {"V": ("V_t", "theta_t"), "I": ("I_t", "phi_t")}.items():
        if name in columns:
            z = columns.pop(name)
            columns |= {size: np.abs(z), angle: np.angle(z)}
    return replace(s, record=replace(r, **columns))


def phasors_only(s: Sample) -> Sample:
    """P and Q follow from the phasors."""
    S = s.record.V * np.conj(s.record.I)
    return altered(s, P_t=np.real(S), Q_t=np.imag(S))


def scaled(**factors: float) -> Mutate:
    return lambda s: altered(s, **{name: getattr(s.record, name) * factor for name, factor in factors.items()})


def with_phasors(mutate: Mutate) -> Mutate:
    """P and Q are not in the file."""
    return lambda s: phasors_only(mutate(s))


def without_f(mutate: Mutate) -> Mutate:
    return lambda s: altered(mutate(s), f=np.full(len(s.record), np.nan))


for what, cause, mutate in (
    ("V line-to-neutral on a line-line base", "neutral on line base", scaled(V=1 / sqrt(3))),
    ("V line-line on a line-to-neutral base", "line on neutral base", scaled(V=sqrt(3))),
    ("V in kV read as V", "V in kV", scaled(V=1e-3)),
    ("V in V read as kV", "V in V", scaled(V=1e3)),
    ("V peak read as RMS", "V peak", scaled(V=sqrt(2))),
    ("V RMS read as peak", "V rms", scaled(V=1 / sqrt(2))),
    ("V in % read as pu", "V per cent", scaled(V=100.0)),
    ("V on a base 20 % too small", "V base", scaled(V=1.25)),
    ("I in kA read as A", "I in kA", scaled(I=1e-3)),
    ("I in A read as kA", "I in A", scaled(I=1e3)),
    ("I peak read as RMS", "I peak", scaled(I=sqrt(2))),
    ("I of a delta winding", "I phase to phase", scaled(I=sqrt(3))),
    ("current transformer +20 %", "I ratio", scaled(I=1.2)),
    ("I in A read as kA, no P and Q", "I in A", with_phasors(scaled(I=1e3))),
    ("I in kA read as A, no P and Q", "I in kA", with_phasors(scaled(I=1e-3))),
    ("V line-to-neutral on a line-line base, no P and Q", "neutral on line base", with_phasors(scaled(V=1 / sqrt(3)))),
    ("current transformer +20 %, no P and Q", "I ratio", with_phasors(scaled(I=1.2))),
    ("P and Q in kW read as MW", "P in MW", scaled(P_t=1e3, Q_t=1e3)),
    ("P and Q of one phase", "P per phase", scaled(P_t=1 / 3, Q_t=1 / 3)),
    ("P and Q in MW read as pu", "P base", scaled(P_t=100.0, Q_t=100.0)),
    ("load convention, all", "load all", scaled(I=-1.0, P_t=-1.0, Q_t=-1.0)),
    ("load convention, no P and Q", "load all", with_phasors(scaled(I=-1.0))),
    ("load convention of I", "load I", scaled(I=-1.0)),
    ("load convention of P and Q", "load P Q", scaled(P_t=-1.0, Q_t=-1.0)),
    ("Q with the other sign", "Q sign", scaled(Q_t=-1.0)),
    ("P with the other sign", "P sign", scaled(P_t=-1.0)),
    ("P_m in MW read as pu", "P_m in MW", scaled(P_m=100.0)),
    ("P_m in kW read as MW", "P_m in kW", scaled(P_m=1e3)),
    ("P_m +10 %", "P_m scale", scaled(P_m=1.1)),
    ("P_m +30 %", "P_m scale", scaled(P_m=1.3)),
    ("P_m with the other sign", "P_m sign", scaled(P_m=-1.0)),
    ("E_f in volts", "E_f in volts", scaled(E_f=92.0)),
    ("E_f with the other sign", "E_f sign", scaled(E_f=-1.0)),
    ("E_f 1.6 times too large", "E_f scale", scaled(E_f=1.6)),
):
    mutation(what, cause)(mutate)


@mutation("P_m in pu of the machine's rating", "P_m base")
def own_base(s: Sample) -> Sample:
    return altered(s, P_m=s.record.P_m * s.record.S_base / s.machine["S_n"])


@mutation("P and Q in pu of the machine's rating", "P base")
def own_base_of_P(s: Sample) -> Sample:
    up = s.record.S_base / s.machine["S_n"]
    return altered(s, P_t=s.record.P_t * up, Q_t=s.record.Q_t * up)


@mutation("E_f = 1 at rated load", "E_f base at rated load")
def at_rated_load(s: Sample) -> Sample:
    return altered(s, E_f=s.record.E_f / 2.5)


@mutation("angles in degrees read as rad", "degrees")
def in_degrees(s: Sample) -> Sample:
    theta, phi = (np.degrees(np.angle(np.exp(1j * getattr(s.record, n)))) for n in ("theta_t", "phi_t"))
    ranges = AngleRange().widened([theta, phi])
    return replace(altered(s, theta_t=theta, phi_t=phi), angles=ranges)


@mutation("angles in degrees read as rad, no P and Q", "degrees")
def in_degrees_phasors(s: Sample) -> Sample:
    return phasors_only(in_degrees(s))


@mutation("angles in rad read as degrees", "radians")
def in_radians(s: Sample) -> Sample:
    theta, phi = (radians(1) * np.angle(np.exp(1j * getattr(s.record, n))) for n in ("theta_t", "phi_t"))
    return replace(altered(s, theta_t=theta, phi_t=phi), angles=AngleRange().widened([theta, phi]))


@mutation("angles in rad read as degrees, no P and Q", "radians")
def in_radians_phasors(s: Sample) -> Sample:
    return phasors_only(in_radians(s))


@mutation("angles counted the other way round", "conjugate")
def conjugated(s: Sample) -> Sample:
    return altered(s, V=np.conj(s.record.V), I=np.conj(s.record.I))


@mutation("angles counted the other way round, no P and Q", "conjugate")
def conjugated_phasors(s: Sample) -> Sample:
    return phasors_only(conjugated(s))


@mutation("theta and phi exchanged", "theta and phi exchanged")
def angles_exchanged(s: Sample) -> Sample:
    return altered(s, theta_t=s.record.phi_t, phi_t=s.record.theta_t)


@mutation("V and I exchanged", "V and I exchanged")
def phasors_exchanged(s: Sample) -> Sample:
    return altered(s, V=s.record.I, I=s.record.V)


@mutation("P and Q exchanged", "P and Q exchanged")
def powers_exchanged(s: Sample) -> Sample:
    return altered(s, P_t=s.record.Q_t, Q_t=s.record.P_t)


def turned(angle: float) -> Mutate:
    return lambda s: altered(s, V=s.record.V * np.exp(1j * radians(angle)))


mutation("V of two lines, 30 deg ahead", "30 degrees")(turned(30))
mutation("V on the other side of a Yd transformer, 30 deg behind", "30 degrees")(turned(-30))
mutation("V of phase B, I of phase A", "120 degrees")(turned(-120))
mutation("V of phase C, I of phase A", "120 degrees")(turned(120))
mutation("V shifted by 12 deg", "shift")(turned(12))
mutation("V of phase B, I of phase A, no P and Q", "120 degrees")(with_phasors(turned(-120)))


@mutation("frames of 50/s read as 60/s", "rate")
def wrong_rate(s: Sample) -> Sample:
    return replace(s, record=replace(s.record, facts=replace(s.record.facts, rate=1.2 * s.record.rate)))


@mutation("times in ms read as s", "time unit")
def milliseconds(s: Sample) -> Sample:
    r = s.record
    return replace(s, record=replace(r, time=1e3 * r.time, t_frame=1e3 * r.t_frame, facts=replace(r.facts, rate=None)))


@mutation("stamps of arrival, spread by half a period", "time off raster")
def arrival(s: Sample) -> Sample:
    late = np.random.default_rng(1).uniform(-0.45, 0.45, len(s.record)) / s.record.rate
    return replace(s, record=replace(s.record, t_frame=s.record.t_frame + late))


@mutation("every second frame held", "held")
def every_second(s: Sample) -> Sample:
    take = np.arange(len(s.record)) // 2 * 2
    return altered(s, **{name: getattr(s.record, name)[take] for name in VALUES})


@mutation("60 Hz of a 50 Hz machine", "omega_s")
def other_frequency(s: Sample) -> Sample:
    return replace(s, record=replace(s.record, facts=replace(s.record.facts, f0=50.0), f=s.record.f - 10))


@mutation("f as the deviation", "f deviation")
def deviation(s: Sample) -> Sample:
    return altered(s, f=s.record.f - 60)


@mutation("half of the frames lost", "lost")
def losses(s: Sample) -> Sample:
    lost = np.random.default_rng(2).random(len(s.record)) < 0.5
    values = {name: np.where(lost, np.nan, getattr(s.record, name)) for name in VALUES}
    return altered(s, frame_valid=s.record.frame_valid & ~lost, **values)


def of_machine(**factors: float) -> Mutate:
    def mutate(s: Sample) -> Sample:
        parameters = {
            n: v * factors.get(n, 1.0) if isinstance(v, float) else v for n, v in s.machine.parameters.items()
        }
        return replace(s, machine=replace(s.machine, parameters=parameters))

    return mutate


REACTANCES = ("xd", "xd1", "xq", "xq1")
mutation("reactances in pu of 100 MVA", "reactances on another base")(
    lambda s: of_machine(**dict.fromkeys(REACTANCES, 100 / s.machine["S_n"]))(s)
)
mutation("reactances in %", "reactances on another base")(of_machine(**dict.fromkeys(REACTANCES, 100.0)))


@mutation("D left at the FMU's default, 2 s/rad", "D in pu")
def default_D(s: Sample) -> Sample:
    return replace(s, machine=replace(s.machine, parameters={**s.machine.parameters, "D": 2.0}))


@mutation("x'd and xd exchanged", "machine data")
def transient_exchanged(s: Sample) -> Sample:
    p = s.machine.parameters
    return replace(s, machine=replace(s.machine, parameters={**p, "xd": p["xd1"], "xd1": p["xd"]}))


def outcome(findings: list[Finding], cause: str) -> str:
    """How a cause is named: "first" of the gravest finding, "named" among others, or "other" is, or it is "silent"."""
    if not findings:
        return "silent"
    if findings[0].causes[:1] == (cause,):
        return "first"
    return "named" if any(cause in finding.causes for finding in findings) else "other"


OUTCOMES = ("first", "named", "other", "silent")


def study(samples: list[Sample], progress: Callable[[float], None]) -> list[tuple[str, str, dict[str, int]]]:
    """Each mutation of each sample: what is wrong, the cause, and how often each outcome."""
    rows = []
    for i, (what, (cause, mutate)) in enumerate(MUTATIONS.items()):
        found = [outcome(mutate(sample).findings(), cause) for sample in samples]
        rows.append((what, cause, {kind: found.count(kind) for kind in OUTCOMES}))
        progress((i + 1) / len(MUTATIONS))
    return rows


def markdown(rows: list[tuple[str, str, dict[str, int]]], samples: int, right: int, alarms: int) -> str:
    lines = [
        f"{len(rows)} mutations of {samples} right records each (ten machines of the IEEE 39-bus system; "
        f"{', '.join(EVENTS)}; 25 to 120 frames/s; TVE 0 to 1 %). On {right} right records: {alarms} false alarms.",
        "",
        "| what is wrong | what is named | first | among the causes | another cause | silent |",
        "|---|---|---|---|---|---|",
    ]
    for what, cause, found in rows:
        lines.append(f"| {what} | {CAUSES[cause].name} | {' | '.join(str(found[kind] or '') for kind in OUTCOMES)} |")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="python -m scenarios.records.mutations",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--readme", action="store_true", help="write the table into the README of this folder")
    chosen = parser.parse_args()
    console = Console(width=140)
    with progress_bar(console) as progress:
        right = [Sample(record, machine) for record, machine in right_records(lambda done: progress(done / 2))]
        alarms = [sample for sample in right if sample.findings()]
        samples = right[::11]  # another machine each time
        rows = study(samples, lambda done: progress(0.5 + done / 2))
    table = Table("what is wrong", "what is to be named", *OUTCOMES)
    for what, cause, found in rows:
        table.add_row(what, CAUSES[cause].name, *[str(found[kind] or "") for kind in OUTCOMES])
    console.print(table)
    console.print(f"{len(right)} right records: {len(alarms)} false alarms")
    for sample in alarms:
        console.print(sample.machine.unit, sample.record.facts.source, [f.measured for f in sample.findings()])
    if chosen.readme:
        readme.write(README, "mutations", markdown(rows, len(samples), len(right), len(alarms)))


if __name__ == "__main__":
    main()
