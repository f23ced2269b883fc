"""The short table of an estimate, and its JSON."""

from collections.abc import Mapping, Sequence
from math import pi
from typing import Any

from rich.console import Console
from rich.table import Column, Table

from ..machines.table import Machine
from ..records.findings import Finding
from ..records.report import as_json, say
from ..report import PLAIN
from .estimate import CAPTURING, HOLDING, JUDGES, OUT_OF_BAND, Estimate

SHOWN = {
    "load_angle": ("load angle", "deg", 180 / pi),
    "omega": ("speed deviation", "mHz", 1e3 / (2 * pi)),
    "e1d": ("E'd", "pu", 1.0),
    "e1q": ("E'q", "pu", 1.0),
    "E_f_hat": ("E_f", "pu", 1.0),
    "P_m_hat": ("P_m", "pu", 1.0),
}
JUDGED = {
    "innovation": "innovation of |E'|, RMS",
    "angle_innovation": "innovation of the angle, RMS",
    "power_mismatch": "P + jQ against V I*, RMS",
}

QUIET = 0.5
"""RMS of the innovations, where 1 is what was assumed."""

LARGE = 0.2
"""Share of innovations out of band from which on the table says so; a right model has 0.3 %."""


def print_estimate(console: Console, estimate: Estimate, seconds: float, wall: float) -> None:
    table = Table(Column("what", no_wrap=True), **PLAIN)
    table.add_column("value", no_wrap=True)
    when = "never" if estimate.captured is None else f"after {estimate.captured:.2f} s"
    table.add_row("captured (status 2)", when)
    for name, (value, std) in estimate.medians().items():
        if name in SHOWN:
            text, unit, scale = SHOWN[name]
            table.add_row(
                f"{text}, median and its standard deviation", f"{value * scale:.5g} +- {std * scale:.2g} {unit}"
            )
    for name in JUDGES:
        if name in estimate.squares:
            share = estimate.beyond[name] / max(estimate.by_status[2], 1)
            beyond = "" if name == "power_mismatch" else f"; {share:.2%} beyond {OUT_OF_BAND:g}"
            table.add_row(JUDGED[name], f"{estimate.rms(name):.3g}{beyond}")
    table.add_row("frames held (lost, repeated, gross)", f"{estimate.share(HOLDING):.2%}")
    table.add_row("frames before capture", f"{estimate.share(CAPTURING) + estimate.share(0):.2%}")
    console.print(table, highlight=False)
    speed = f"{seconds / wall:.0f} times real time"
    say(console, f"{estimate.frames} frames, {seconds:.1f} s of record, in {wall:.1f} s: {speed}")
    for line in warnings(estimate):
        say(console, line)


def warnings(estimate: Estimate) -> list[str]:
    found = []
    if estimate.captured is None:
        found.append("never captured: a quiet record tells too little, or V, I and the machine do not belong together")
    if estimate.captured is not None and 0 < estimate.rms("innovation") < QUIET:
        found.append("the frames are less noisy than assumed: --set tve=0 learns their noise, and narrows the bands")
    for name, what in (
        ("innovation", "xd, xq, x'd, x'q, E_f or S_base"),
        ("angle_innovation", "P_m, D, H or the times"),
    ):
        share = estimate.beyond.get(name, 0) / max(estimate.by_status[2], 1)
        if share > LARGE:
            found.append(f"{share:.0%} of {name} is out of band: look at {what}")
    return found


def summary(
    estimate: Estimate,
    machine: Machine,
    parameters: Mapping[str, float],
    findings: Sequence[Finding],
    about: Mapping[str, Any],
) -> dict[str, Any]:
    return {
        **about,
        "unit": machine.unit,
        "parameters": dict(parameters),
        "frames": estimate.frames,
        "captured_s": estimate.captured,
        "share_held": estimate.share(HOLDING),
        "share_capturing": estimate.share(CAPTURING),
        "median": {
            name: {"value": value, "std": std, "unit": estimate.units[name]}
            for name, (value, std) in estimate.medians().items()
        },
        "rms": {name: estimate.rms(name) for name in JUDGES if name in estimate.squares},
        "share_out_of_band": {
            name: count / max(int(estimate.by_status[2]), 1) for name, count in estimate.beyond.items()
        },
        "findings": as_json(findings),
        "warnings": warnings(estimate),
    }
