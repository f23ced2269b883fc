"""What a conversion and the checks tell, as text and as JSON."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from .conversion import Converted
from .findings import CAUSES, NONSENSE, Finding


def print_conversion(console: Console, done: Converted, out: Path) -> None:
    r, facts = done.raster, done.facts
    seconds = (r.frames + r.lost) / r.rate
    since = f" from {facts.utc_start}" if facts.utc_start else ""
    say(console, f"{out}: {r.frames} frames at {r.rate:g}/s, {seconds:.3f} s{since}; {r.lost} lost")
    for count, what in (
        (done.unusable, "frames with a time have no usable values: lost"),
        (done.broken, "rows could not be read: left out"),
        (r.untimed, "rows have no time that can be read: left out"),
        (r.repeated, "frames come a second time: left out"),
        (r.backward, "frames are older than one before them: left out"),
    ):
        if count:
            say(console, f"  {count} {what}")
    if not r.snap:
        say(console, "  the stamps are not on a raster: t_frame keeps them as they are")
    for start, length in r.gaps[:3]:
        if length > 1:
            say(console, f"  a gap of {length:.3f} s at {start:.3f} s")


def print_findings(console: Console, findings: Sequence[Finding]) -> None:
    if not findings:
        say(console, "checks: nothing speaks against this record")
    for finding in findings:
        mark = "[bold red]nonsense[/]" if finding.grade == NONSENSE else "[yellow]doubtful[/]"
        console.print(f"{mark} {finding.check}: ", end="")
        say(console, finding.measured)
        for number, line in enumerate(finding.lines):
            say(console, f"    {'or ' if number else ''}{line}")


def say(console: Console, text: str) -> None:
    console.print(text, highlight=False, markup=False, soft_wrap=True)


def as_json(findings: Sequence[Finding]) -> list[dict[str, Any]]:
    return [
        {
            "check": finding.check,
            "grade": finding.grade,
            "measured": finding.measured,
            "causes": [{"cause": CAUSES[c].name, "mends": CAUSES[c].mends} for c in finding.causes],
        }
        for finding in findings
    ]


def print_data(console: Console, findings: Sequence[Finding]) -> None:
    """Of machine data alone."""
    for finding in findings:
        say(console, f"{finding.grade}: {finding.measured} ({finding.lines[0]})")
