"""The observer FMU over a record, from its file to an estimate's files."""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

from ..errors import UserError
from ..fmu import Fmu
from ..machines.table import Machine
from ..records import checks, streaming
from ..records.digits import table_text
from ..records.findings import Finding
from ..records.standard import RecordError
from . import cosimulation, figure, report
from .estimate import KEPT, MEASURED, Estimate, outputs_of, settings

DECIMALS = {"time": 9, "status": 0}
VALUE_DECIMALS = 9


@dataclass
class Observed:
    estimate: Estimate
    parameters: dict[str, float]
    findings: list[Finding]
    seconds: float
    """Of the record."""
    wall: float


def given_values(pairs: list[str]) -> dict[str, str]:
    """`["tve=0.003"]`, from the command line. Raises UserError."""
    found = {}
    for pair in pairs:
        name, equals, value = pair.partition("=")
        if not (name and equals and value):
            raise UserError(f'--set {pair}: write NAME=VALUE, for instance "tve=0.003"')
        found[name.strip()] = value.strip()
    return found


def observe(
    fmu: Fmu,
    path: Path,
    machine: Machine,
    given: Mapping[str, str],
    folder: Path,
    progress: Callable[[float], None] = lambda done: None,
) -> Observed:
    """Run, and write estimate.csv, estimate.png and summary.json into `folder`. Raises UserError."""
    begin = perf_counter()
    pieces = streaming.pieces(path)
    first, done = next(pieces, (None, 1.0))
    if first is None or len(first) < 2:
        raise RecordError(f"{path} holds no frames to observe")
    if not first.frame_valid.any():
        raise RecordError(f"{path}: none of the first {len(first)} frames is usable")
    facts, rate = first.facts, first.rate
    findings = checks.check(first, machine)
    parameters = settings(fmu, machine, facts, rate, first, given)
    outputs = outputs_of(fmu, parameters)
    estimate = Estimate({name: fmu.variables[name].unit for name in outputs})
    every = max(1, round(len(first) / done / KEPT))
    P_m, E_f = (parameters[name] == MEASURED for name in ("mechanical_power", "field_voltage"))
    folder.mkdir(parents=True, exist_ok=True)
    part = folder / "estimate.csv.part"
    start = float(first.time[0]) - 1 / rate
    try:
        with part.open("wb") as file, cosimulation.observer(fmu, parameters, outputs, start) as running:
            file.write(head(path, facts.utc_start, outputs, estimate.units).encode())
            record = first
            while True:
                shown = running.run(record, P_m, E_f)
                columns = [record.time, *[shown[name] for name in outputs]]
                file.write(table_text(columns, [DECIMALS.get(n, VALUE_DECIMALS) for n in ("time", *outputs)]))
                estimate.add(record, shown, every)
                last = float(record.time[-1])
                progress(done)
                record, done = next(pieces, (None, 1.0))
                if record is None:
                    break
        part.replace(folder / "estimate.csv")
    finally:
        part.unlink(missing_ok=True)
    wall = perf_counter() - begin
    seconds = last - start
    title = f"{machine.unit}: {path.name}"
    figure.draw(estimate, title, facts.utc_start, folder / "estimate.png")
    about = {"record": str(path), "utc_start": facts.utc_start, "seconds": seconds, "wall_s": round(wall, 3)}
    summary = report.summary(estimate, machine, parameters, findings, about)
    (folder / "summary.json").write_text(json.dumps(summary, indent=2) + "\n", encoding="utf-8")
    return Observed(estimate, parameters, findings, seconds, wall)


def head(path: Path, utc_start: str | None, outputs: list[str], units: Mapping[str, Any]) -> str:
    lines = [f"# estimate from {path.name}: each row at the time of a frame; status 2 is an estimate"]
    if utc_start:
        lines.append(f"# utc_start = {utc_start}")
    lines.append("# units: s," + ",".join(units[name] for name in outputs))
    return "\n".join([*lines, ",".join(["time", *outputs])]) + "\n"
