"""The table, the figures and the files of a comparison."""

import json
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib

matplotlib.use("agg")  # figures are written to files; no display is needed

import matplotlib.pyplot as plt
import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from .comparison import CLOSE, RIGHT, SHOWN, STEADY_FROM, TVES, Comparison, Summary

MILLI = 1e3

NARROWEST = 100
"""Characters; a table that is wider than the terminal is better than one that leaves out figures."""

QUANTITIES = {"e1": "E'd, E'q\n10⁻³ pu", "delta": "delta\nmrad", "omega": "omega\nmrad/s"}

UNITS = {"e1": "pu", "delta": "rad", "omega": "rad/s"}


def label(s: Summary) -> str:
    return s.name if s.start == "none" else f"{s.name}, {s.start}"


def cost_of(s: Summary, costs: dict[str, float]) -> float:
    return costs[s.name.partition(",")[0]]


def print_table(console: Console, comparison: Comparison, costs: dict[str, float], seeds: int) -> None:
    console.width = max(console.width, NARROWEST)
    tves = " and ".join(f"{TVES[i]:.1%}" for i in SHOWN)
    console.print(
        f"{comparison.title}, 60 frames/s, {seeds} noise seeds, TVE {tves}. RMS error from {STEADY_FROM:g} s on; "
        f"median time until the error of (E'd, E'q) stays below {RIGHT:g} pu (and the estimator says so) and below "
        f"{CLOSE:g} pu; time of one step in Python. * is the best of its column.\n",
        highlight=False,
    )
    table = Table(box=SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=(0, 1, 0, 0))
    table.add_column("estimator,\nits start", no_wrap=True)
    for name in [*QUANTITIES.values(), f"< {RIGHT:g} pu\ns", f"< {CLOSE:g} pu\ns", "step\nµs"]:
        table.add_column(name, justify="right", no_wrap=True)
    shown = comparison.summaries
    columns = [both([MILLI * getattr(s, q) for s in shown], "{:.2g}") for q in QUANTITIES]
    for q in ("captured", "settled"):
        times = [getattr(s, q) if s.start not in ("good", "hindsight") else np.full(len(TVES), np.nan) for s in shown]
        columns.append(both(times, "{:.2f}"))
    columns.append(marked([1e6 * cost_of(s, costs) for s in shown], "{:.0f}"))
    for s, *cells in zip(shown, *columns, strict=True):
        table.add_row(label(s), *cells)
    console.print(table, "", highlight=False)


def both(values: list[np.ndarray], form: str) -> list[str]:
    """The values at the two TVEs that are shown."""
    first, second = (marked([value[i] for value in values], form) for i in SHOWN)
    return [f"{a} / {b}" for a, b in zip(first, second, strict=True)]


def marked(values: list[float], form: str) -> list[str]:
    """As text, the smallest ones with a star, as far as the text shows; nan as a dash."""
    texts = [(form if value < 100 else "{:.0f}").format(value) if np.isfinite(value) else "-" for value in values]
    best = form.format(np.nanmin(values))
    return [f"*{text}" if text == best else text for text in texts]


class Verdict(NamedTuple):
    quantity: str
    unit: str
    robust: float
    peer: float
    """The best EKF or UKF."""
    of: str
    ratio: float
    """robust to peer"""
    winner: str


def verdicts(comparison: Comparison, costs: dict[str, float]) -> list[Verdict]:
    """`robust` with P_m measured and no start, against the best EKF or UKF in every quantity."""
    ours = comparison.summaries[0]
    peers = [s for s in comparison.summaries if s.name in ("EKF", "UKF")]
    found = []
    for q, name in QUANTITIES.items():
        for i in SHOWN:
            values = {label(s): getattr(s, q)[i] for s in peers}
            found.append(
                verdict(f"RMS of {name.split(chr(10))[0]}, TVE {TVES[i]:.1%}", UNITS[q], getattr(ours, q)[i], values)
            )
    for start in ("flat", "bad"):
        for q, limit in (("captured", RIGHT), ("settled", CLOSE)):
            for i in SHOWN:
                values = {label(s): getattr(s, q)[i] for s in peers if s.start == start}
                found.append(
                    verdict(f"below {limit:g} pu, {start} start, TVE {TVES[i]:.1%}", "s", getattr(ours, q)[i], values)
                )
    found.append(verdict("one step in Python", "s", costs["robust"], {name: costs[name] for name in ("EKF", "UKF")}))
    return found


def verdict(quantity: str, unit: str, own: float, peers: dict[str, float]) -> Verdict:
    finite = {name: value for name, value in peers.items() if np.isfinite(value)}
    if not finite:
        return Verdict(quantity, unit, own, np.nan, "none ever", np.nan, "robust")
    best = min(finite, key=lambda name: finite[name])
    return Verdict(
        quantity, unit, own, finite[best], best, own / finite[best], "robust" if own < finite[best] else best
    )


def print_verdicts(console: Console, found: list[Verdict]) -> None:
    table = Table("robust against the best EKF or UKF", "unit", box=SIMPLE_HEAD, show_edge=False, pad_edge=False)
    for name in ("robust", "peer", "ratio"):
        table.add_column(name, justify="right")
    table.add_column("winner")
    for v in found:
        numbers = [f"{value:.2g}" if np.isfinite(value) else "-" for value in (v.robust, v.peer, v.ratio)]
        table.add_row(v.quantity, v.unit, *numbers, v.winner if v.winner == "robust" else f"[bold]{v.winner}[/]")
    console.print(table, "", highlight=False)
    console.print()


def print_costs(console: Console, costs: dict[str, float]) -> None:
    table = Table("one step", box=SIMPLE_HEAD, show_edge=False, pad_edge=False)
    for name in ("µs", "in that of the EKF"):
        table.add_column(name, justify="right")
    for name, seconds in costs.items():
        table.add_row(name, f"{1e6 * seconds:.1f}", f"{seconds / costs['EKF']:.2f}")
    console.print(table, "(The FMUs through FMPy, the EKF and the UKF on FilterPy.)\n", highlight=False)


def write(comparison: Comparison, costs: dict[str, float], seeds: int, folder: Path) -> None:
    """table.csv, summary.json and the figures."""
    folder.mkdir(parents=True, exist_ok=True)
    fields = ("e1", "delta", "omega", "captured", "settled", "share")
    with (folder / "table.csv").open("w", encoding="utf-8") as file:
        file.write("# units: 1,1,1,pu,rad,rad/s,s,s,1\nestimator,start,TVE," + ",".join(fields) + "\n")
        for s in comparison.summaries:
            for i, tve in enumerate(TVES):
                values = ",".join(f"{getattr(s, field)[i]:.6g}" for field in fields)
                file.write(f'"{s.name}","{s.start}",{tve:g},{values}\n')
    summary = {
        "seeds": seeds,
        "steady_from_s": STEADY_FROM,
        "tves": TVES,
        "tuned": {name: {"q": q[:, 0].tolist(), "P_flat": P.tolist()} for name, (q, P) in comparison.tunings.items()},
        "step_s": costs,
        "verdicts": [
            {key: value if value == value else None for key, value in v._asdict().items()}
            for v in verdicts(comparison, costs)
        ],
    }
    (folder / "summary.json").write_text(json.dumps(summary, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
    draw_courses(comparison, folder / "capture.png")
    draw_steady(comparison, folder / "steady.png")


WIDTHS = {"EKF": 3.5, "drem": 3.5}
"""inches/72; what lies under another line is seen."""

COLOURS = {"robust": "C0", "EKF": "C1", "UKF": "C2", "gradient": "C3", "drem": "C4", "open_loop": "C5"}
DASHES = {"flat": "--", "bad": ":", "robust, no P_m": "--", "robust, no P_m, no E_f": ":"}


def style(s: Summary) -> dict[str, Any]:
    family = s.name.partition(",")[0]
    return {
        "color": COLOURS[family],
        "linewidth": WIDTHS.get(family, 1.4),
        "linestyle": DASHES.get(s.start, DASHES.get(s.name, "-")),
        "label": label(s),
    }


def draw_courses(comparison: Comparison, path: Path) -> None:
    shown = [s for s in comparison.summaries if s.start != "hindsight"]
    with plt.style.context("seaborn-v0_8-whitegrid"):
        canvas, axes = plt.subplots(1, len(SHOWN), figsize=(11, 5.5), sharey=True, layout="constrained")
        for ax, i in zip(axes, SHOWN, strict=True):
            for s in shown:
                ax.loglog(comparison.t, s.course[:, i], **style(s))
            ax.set_title(f"TVE {TVES[i]:.1%}", fontsize="medium")
            ax.set_xlabel("time [s]")
        axes[0].set_ylabel("|error of (E'd, E'q)|, median over the seeds [pu]")
        finish(canvas, axes[0], f"{comparison.title}: error against time", path)


def draw_steady(comparison: Comparison, path: Path) -> None:
    shown = [s for s in comparison.summaries if s.start in ("none", "good")]
    with plt.style.context("seaborn-v0_8-whitegrid"):
        canvas, axes = plt.subplots(1, 3, figsize=(13, 5), layout="constrained")
        for ax, (q, unit) in zip(axes, UNITS.items(), strict=True):
            for s in shown:
                ax.loglog(100 * np.array(TVES), getattr(s, q), marker=".", **style(s))
            ax.set_title(QUANTITIES[q].split("\n")[0], fontsize="medium")
            ax.set_xlabel("TVE [%]")
            ax.set_ylabel(f"RMS error from {STEADY_FROM:g} s on [{unit}]")
        finish(canvas, axes[0], f"{comparison.title}: steady error against noise", path)


def finish(canvas, ax, title: str, path: Path) -> None:
    handles, labels = ax.get_legend_handles_labels()
    canvas.legend(handles, labels, loc="outside lower center", ncols=4)
    canvas.suptitle(title)
    canvas.savefig(path, dpi=120)
    plt.close(canvas)
