"""The figures of a run: [[figure]] in its scenario."""

from pathlib import Path
from textwrap import fill
from typing import Any

import matplotlib

matplotlib.use("agg")  # figures are written to files; no display is needed

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from .master import Results
from .plan import agree, sweep_text
from .scenario import Figure, Panel

PANEL = (5.2, 2.9)
"""inches, width and height"""

STYLES = ("-", "--", ":", "-.")

LABEL = 30
"""Characters that a line beside an axis holds."""

COLOURS = ["#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00", "#F0E442", "#7f7f7f"]
"""Of Okabe and Ito, told apart with any colour vision; the truth is black."""


def draw(results: Results, figure: Figure, path: Path) -> None:
    panels = [(panel, sweep) for sweep in facets(results, figure) for panel in figure.panel]
    columns = 1 if len(panels) < 4 else 2
    rows = -(-len(panels) // columns)
    size = (PANEL[0] * (2 if columns == 2 else 1.6), PANEL[1] * rows)
    with plt.style.context("seaborn-v0_8-whitegrid"):
        canvas, axes = plt.subplots(rows, columns, figsize=size, sharex=True, squeeze=False, layout="constrained")
        drawn = [
            draw_panel(results, figure, panel, sweep, ax) for ax, (panel, sweep) in zip(axes.flat, panels, strict=False)
        ]
        for ax in axes.flat[len(panels) :]:
            ax.remove()
        for ax in axes[-1]:
            ax.set_xlabel("time [s]")
        if all(legend(lines) == legend(drawn[0]) for lines in drawn):
            length = sum(len(label) + 8 for label, *_ in legend(drawn[0]))  # 8: the line before it
            needed = -(-length // round(11 * size[0]))  # rows, of 11 characters an inch
            canvas.legend(handles=drawn[0], loc="outside lower center", ncols=-(-len(drawn[0]) // needed))
        else:
            for ax in axes.flat[: len(panels)]:
                ax.legend(frameon=True, fontsize="small")
        canvas.suptitle(figure.title)
        canvas.savefig(path, dpi=120)
        canvas.savefig(path.with_suffix(".svg"))
        plt.close(canvas)


def facets(results: Results, figure: Figure) -> list[dict[str, Any]]:
    """What the panels of a figure are drawn for, one after the other."""
    if figure.facet is None:
        return [{}]
    sweeps = [instance.sweep for instance in results.plan.instances]
    values = dict.fromkeys(sweep[figure.facet] for sweep in sweeps if figure.facet in sweep)
    return [{figure.facet: value} for value in values]


def draw_panel(results: Results, figure: Figure, panel: Panel, chosen: dict[str, Any], ax: Axes) -> list[Line2D]:
    """The first curve in black, if it is not swept; a colour for each value of a sweep, a style for each further curve.

    Two standard deviations on either side of a curve with a band. Only what agrees with the `chosen` facet is drawn.
    """
    scenario = results.plan.scenario
    shown = slice(scenario.index(figure.after), scenario.index(figure.until or scenario.stop) + 1)
    quantities = {quantity(name) for name in panel.curves}
    colours: dict[str, str] = {}
    units: dict[str, None] = {}
    lines = []
    for number, name in enumerate(panel.curves):
        signals = [signal for signal in results.plan.signals[name] if agree(chosen, signal.sweep)]
        # later ones are thinner: what lies on top of each other is seen
        for signal, width in zip(signals, np.linspace(1.4 + 1.2 * (len(signals) > 1), 1.4, len(signals)), strict=True):
            key = sweep_text({k: value for k, value in signal.sweep.items() if k not in chosen})
            # what is not swept is black, but for the curves beside it: the first one is the truth
            coloured = key or number
            colour = colours.setdefault(key, COLOURS[len(colours) % len(COLOURS)]) if coloured else "black"
            # what the axis says already is not repeated: "observer, gamma = 1e15"
            named = signal.name if len(quantities) > 1 else name.partition(".")[0] if "." in name else ""
            lines += ax.plot(
                results.time[shown],
                np.abs(results.of(signal)[shown]) if panel.log else results.of(signal)[shown],
                STYLES[number % len(STYLES)],
                color=colour,
                label=", ".join(part for part in (named, key) if part) or name,
                linewidth=width,
            )
            units[signal.unit] = None
            for deviation in results.plan.signals.get(panel.band.get(name, ""), []):
                if deviation.sweep == signal.sweep:
                    middle, half = results.of(signal)[shown], 2 * results.of(deviation)[shown]
                    ax.fill_between(results.time[shown], middle - half, middle + half, color=colour, alpha=0.2, lw=0)
    text = panel.title.format(**chosen)
    unit = "" if list(units) == ["1"] else f"[{', '.join(units)}]"
    ax.set_ylabel(fill(f"{f'|{text}|' if panel.log else text} {unit}".strip(), LABEL))
    if panel.log:
        ax.set_yscale("log")
    if panel.range:
        ax.set_ylim(*panel.range)
    return lines


def quantity(name: str) -> str:
    """`delta` of `plant.delta` and of `plant.G{unit}.delta`; an error is its own."""
    return name.partition(".")[2].rpartition("}.")[2] or name


def legend(lines: list[Line2D]) -> list[tuple]:
    return [(str(line.get_label()), line.get_color(), line.get_linestyle()) for line in lines]
