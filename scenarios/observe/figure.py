"""The figure of an estimate: states with their bands, marks where frames were held or innovations out of band."""

from math import pi
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("agg")  # figures are written to files; no display is needed

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from .estimate import HOLDING, OUT_OF_BAND, STD, TRACKING, Estimate

PANELS = {
    "load_angle": ("load angle", "deg", 180 / pi),
    "omega": ("speed deviation", "mHz", 1e3 / (2 * pi)),
    "e1q": ("E'q", "pu", 1.0),
    "e1d": ("E'd", "pu", 1.0),
    "E_f_hat": ("field voltage E_f", "pu", 1.0),
    "P_m_hat": ("mechanical power P_m", "pu", 1.0),
}
"""Title, unit, and what one of the FMU's unit is in it."""

BLUE, ORANGE, GREY = "#0072B2", "#D55E00", "#999999"
"""Okabe and Ito: told apart by the colour-blind too."""


def draw(estimate: Estimate, title: str, since: str | None, path: Path) -> None:
    series = estimate.series
    time, status = series["time"], series["status"]
    tracked = (status == TRACKING) | (status == HOLDING)
    shown = [name for name in PANELS if name in series]
    rows = -(-len(shown) // 2) + 1
    with plt.style.context("seaborn-v0_8-whitegrid"):
        figure, axes = plt.subplots(rows, 2, figsize=(11, 2.6 * rows), sharex=True, squeeze=False, layout="constrained")
        for name, ax in zip(shown, axes.flat, strict=False):
            text, unit, scale = PANELS[name]
            value = np.where(tracked, series[name], np.nan) * scale
            band = 2 * series[STD[name]] * scale
            ax.fill_between(time, value - band, value + band, color=BLUE, alpha=0.25, lw=0)
            ax.plot(time, value, color=BLUE, lw=1.2)
            ax.set_ylabel(f"{text} [{unit}]")
            frame(ax, value, band)
            mark(ax, time, status == HOLDING, series["marks"])
        for ax in axes.flat[len(shown) : 2 * (rows - 1)]:
            ax.remove()
        judge(axes[-1, 0], time, series, "innovation", "innovation of |E'| [std]", tracked)
        judge(axes[-1, 1], time, series, "angle_innovation", "innovation of the angle [std]", tracked)
        for ax in axes[-1]:
            ax.set_xlabel("time [s]" + (f" from {since.rstrip('Z').rstrip('0').rstrip('.')} UTC" if since else ""))
        handles: list[Any] = [
            Line2D([], [], color=BLUE, label="estimate, 2 standard deviations"),
            Rectangle((0, 0), 1, 1, color=GREY, alpha=0.35, label="held: no usable frame"),
            Line2D([], [], color=ORANGE, marker="|", ls="", label=f"innovation beyond {OUT_OF_BAND:g}"),
        ]
        figure.legend(handles=handles, loc="outside lower center", ncols=3)
        figure.suptitle(title)
        figure.savefig(path, dpi=120)
        plt.close(figure)


def frame(ax: Any, value: np.ndarray, band: np.ndarray) -> None:
    """The range of what tracks and of its usual band, not of one that begins wide."""
    finite = np.isfinite(value)
    if finite.any():
        low, high = np.quantile(value[finite], [0.005, 0.995])
        margin = 0.1 * (high - low) + max(1.3 * np.median(band[finite]), 1e-3 * max(abs(high), abs(low)), 1e-6)
        ax.set_ylim(low - margin, high + margin)


def mark(ax: Any, time: np.ndarray, held: np.ndarray, out: np.ndarray) -> None:
    edges = np.flatnonzero(np.diff(np.concatenate([[0], held.astype(int), [0]])))
    for start, stop in zip(edges[::2], edges[1::2], strict=True):
        ax.axvspan(time[start], time[min(stop, len(time) - 1)], color=GREY, alpha=0.35, lw=0)
    where = time[out]
    ax.plot(where, np.zeros(len(where)), "|", color=ORANGE, ms=8, transform=ax.get_xaxis_transform())


def judge(ax: Any, time: np.ndarray, series: dict, name: str, text: str, tracked: np.ndarray) -> None:
    if name not in series:
        ax.remove()
        return
    ax.axhspan(-OUT_OF_BAND, OUT_OF_BAND, color=GREY, alpha=0.2, lw=0)
    ax.plot(time, np.where(tracked, series[name], np.nan), ".", color=BLUE, ms=2)
    largest = np.nanmax(np.abs(np.where(tracked, series[name], np.nan)), initial=OUT_OF_BAND)
    ax.set_ylim(-min(1.1 * largest, 12), min(1.1 * largest, 12))
    ax.set_ylabel(text)
