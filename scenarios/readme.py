"""The results and figures that READMEs show, from what the runs have written into results/."""

import json
import shutil
from math import prod
from pathlib import Path

from fmu_src.runtime import readme

from . import loader
from .errors import ScenarioError
from .plan import sweep_text, value_text

FOLDER = Path(__file__).parent
GALLERY = FOLDER / "gallery"

FIGURES = {
    "paper_drem": "states",
    "record_g6": "states",
    "smib_fault": "states",
    "noise_smib_fault": "bands",
    "ieee39_all": "load_angles",
    "compare": "capture",
}
"""Run and figure: those that the README shows, as gallery/<run>.png."""


def update(results: Path) -> None:
    """Write the tables and copy the figures. ScenarioError for what has not been run."""
    rows = ["| scenario | of | when | expected | measured |", "|---|---|---|---|---|"]
    for name in loader.names():
        rows += rows_of(summary(results, name, f"run {name}"))
    readme.write(FOLDER / "README.md", "results", "\n".join(rows))
    readme.write(
        FOLDER / "compare" / "README.md",
        "compare",
        "\n".join(rows_of_comparison(summary(results, "compare", "compare"))),
    )
    for name, figure in FIGURES.items():
        shutil.copy(results / name / f"{figure}.png", GALLERY / f"{name}.png")


def summary(results: Path, name: str, command: str) -> dict:
    path = results / name / "summary.json"
    if not path.exists():
        raise ScenarioError(f"{name} has not been run; python -m scenarios {command}")
    return json.loads(path.read_text(encoding="utf-8"))


def rows_of_comparison(summary: dict) -> list[str]:
    """`robust` beside the best EKF or UKF, quantity by quantity."""
    rows = [f"| median or RMS of {summary['seeds']} noise seeds | robust | best peer | ratio |", "|---|---|---|---|"]
    for v in summary["verdicts"]:
        own, peer, ratio = (f"{v[key]:.2g}" if v[key] else "" for key in ("robust", "peer", "ratio"))
        rows.append(
            f"| {v['quantity']} | {own} {v['unit']} | {peer} {v['unit'] if peer else ''} ({v['of']}) | {ratio} |"
        )
    return rows


def rows_of(summary: dict) -> list[str]:
    """One row for what is expected alike: of each quantity, the smallest and the largest value over the sweep."""
    groups: dict[tuple[str, str], list[dict]] = {}
    for verdict in summary["expectations"]:
        groups.setdefault((verdict["when"], verdict["wanted"]), []).append(verdict)
    rows = []
    for (when, wanted), verdicts in groups.items():
        swept = sweeps_text([verdict["each"] for verdict in verdicts])
        names = dict.fromkeys(verdict["name"] for verdict in verdicts)
        measured = "<br>".join(measured_of([v for v in verdicts if v["name"] == name]) for name in names)
        mark = "" if all(verdict["holds"] for verdict in verdicts) else " **fails**"
        cells = (summary["scenario"], swept, when, wanted.replace("|", "\\|") + mark, measured)
        rows.append("| " + " | ".join(cells) + " |")
    return rows


def sweeps_text(sweeps: list[dict]) -> str:
    """`seed = 1, 2; E_f = measured, estimated` for all four combinations; a line each where some are missing."""
    lines = list(dict.fromkeys(sweep_text(sweep) for sweep in sweeps))
    if all(sweep.keys() == sweeps[0].keys() for sweep in sweeps):
        values = {key: list(dict.fromkeys(sweep[key] for sweep in sweeps)) for key in sweeps[0]}
        if len(lines) == prod(map(len, values.values())):
            return "; ".join(f"{key} = {series_text(series)}" for key, series in values.items())
    return "<br>".join(lines)


def series_text(series: list) -> str:
    """`1 to 10` for whole numbers without a gap."""
    whole = all(isinstance(value, int) for value in series)
    if whole and len(series) > 2 and series == list(range(series[0], series[0] + len(series))):
        return f"{series[0]} to {series[-1]}"
    return ", ".join(map(value_text, series))


def measured_of(verdicts: list[dict]) -> str:
    low, high = (f"{bound(v['measured'] for v in verdicts):.3g}" for bound in (min, max))
    unit = verdicts[0]["unit"]
    return f"`{verdicts[0]['name']}` {low if low == high else f'{low} to {high}'}{'' if unit == '1' else ' ' + unit}"
