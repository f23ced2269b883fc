"""Dropouts, gross errors and gaps on the record of generator 6: error of (E'd, E'q) against that of clean frames."""

import argparse

import numpy as np
from rich.console import Console
from rich.table import Table

from fmu_src.pmu_observer.observer import HOLDING

from ..bench import frames
from ..bench.frames import rms

GAP = 6.0, 8.0
"""s"""

SHARE, SIZE = 0.01, 0.2
"""Of gross errors: among the frames, and relative to the phasor."""

AFTER_GAP = (0.25, 0.5, 1.0, 2.0)
"""s"""


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="python -m scenarios.studies.bad_frames",
        description=__doc__,
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    parser.add_argument("--seeds", type=int, default=100, help="noise seeds")
    parser.add_argument("--estimated", action="store_true", help="E_f is estimated, not measured")
    arguments = parser.parse_args()
    truth = frames.record(frames.RECORD_G6)
    field_voltage = 2 if arguments.estimated else 1

    table = Table(title=f"RMS error from 2 s on, in that of clean frames; {arguments.seeds} seeds")
    for column in (
        "TVE",
        "clean, pu",
        "10 % dropouts",
        "1 % gross errors of 20 %",
        "gross errors held",
        "good frames held",
    ):
        table.add_column(column)
    gaps = Table(title=f"a gap of {GAP[1] - GAP[0]:g} s: RMS and median error after it, in those of clean frames")
    for column in ("TVE", *[f"+{t:g} s" for t in AFTER_GAP]):
        gaps.add_column(column)
    for tve in (0.001, 0.003, 0.01):
        options = {"tve": tve, "field_voltage": field_voltage, "mechanical_power": 2}
        marks: list[np.ndarray] = []
        clean, dropped, wrong, gap = [
            frames.series(truth, channel, arguments.seeds, **options)
            for channel in (
                frames.noise(tve),
                frames.noise(tve, dropout=0.1),
                gross_errors(tve, marks),
                gaping(tve),
            )
        ]
        late = clean.t > 2
        held, marked = wrong.status == HOLDING, np.array(marks)
        table.add_row(
            f"{tve:.1%}",
            f"{rms(clean.e1[late]):.5f}",
            *[f"{rms(s.e1[late]) / rms(clean.e1[late]):.2f}" for s in (dropped, wrong)],
            f"{held[marked & late[:, None]].mean():.3f}",
            f"{held[~marked & late[:, None]].mean():.5f}",
        )
        rows = [np.abs(clean.t - GAP[1] - t) < 0.05 for t in AFTER_GAP]
        gaps.add_row(
            f"{tve:.1%}",
            *[
                f"{rms(gap.e1[k]) / rms(clean.e1[k]):.2f} / {np.median(gap.e1[k]) / np.median(clean.e1[k]):.2f}"
                for k in rows
            ],
        )
    console = Console(width=140)
    console.print(table)
    console.print(gaps)


def gaping(tve: float) -> frames.Channel:
    noisy = frames.noise(tve)

    def channel(k, streams, V, I):  # noqa: E741 - the paper's name
        return noisy(k, streams, V, I)._replace(valid=1.0 * (not GAP[0] <= k * frames.PERIOD < GAP[1]))

    return channel


def gross_errors(tve: float, marks: list) -> frames.Channel:
    """Unmarked frames with V or I off by SIZE in a random direction; `marks` gets which: noise is far below SIZE/2."""
    noisy = frames.noise(tve, gross_error_probability=SHARE, gross_error=SIZE)

    def channel(k, streams, V, I):  # noqa: E741 - the paper's name
        received = noisy(k, streams, V, I)
        marks.append(np.maximum(abs(received.V / V - 1), abs(received.I / I - 1)) > SIZE / 2)
        return received

    return channel


if __name__ == "__main__":
    main()
