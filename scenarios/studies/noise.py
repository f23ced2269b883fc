"""Capture and steady error on the record of generator 6, over noise seeds."""

import argparse

import numpy as np
from rich.console import Console
from rich.table import Table

from ..bench import frames
from ..bench.frames import rms

CASES = {
    "E_f, P_m measured": {},
    "P_m estimated": {"mechanical_power": 2},
    "E_f, P_m estimated": {"mechanical_power": 2, "field_voltage": 2},
}


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="python -m scenarios.studies.noise",
        description=__doc__,
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    parser.add_argument("--seeds", type=int, default=100, help="noise seeds")
    parser.add_argument("--record", default=frames.RECORD_G6, help="file in scenarios/data")
    arguments = parser.parse_args()
    truth = frames.record(arguments.record)
    table = Table(title=f"{arguments.record}: |error of (E'd, E'q)|, pu, median / worst of {arguments.seeds} seeds")
    for column in ("TVE", "tve", "", "0.25 s", "0.5 s", "from 2 s", "from 5 s", "delta RMS", "omega RMS", "E_f RMS"):
        table.add_column(column, no_wrap=True)
    for TVE, tve in ((0.001, 0.001), (0.001, 0.01), (0.001, 0.0), (0.01, 0.01), (0.01, 0.0)):
        for name, parameters in CASES.items():
            s = frames.series(truth, frames.noise(TVE), arguments.seeds, tve=tve, **parameters)
            table.add_row(
                f"{TVE:.1%}",
                f"{tve:.1%}" if tve else "estimated",
                name,
                *[at(s, t) for t in (0.25, 0.5)],
                *[since(s, t) for t in (2.0, 5.0)],
                *[f"{rms(v[s.t > 2]):.5f}" for v in (s.delta, s.omega)],
                f"{rms(s.E_f[s.t > 5]):.3f}",
            )
    Console(width=160).print(table)


def at(s: frames.Series, t: float) -> str:
    return both(s.e1[np.argmin(abs(s.t - t))])


def since(s: frames.Series, t: float) -> str:
    """The median over time and seeds, and the worst of all."""
    return both(s.e1[s.t > t - 1e-9])


def both(values) -> str:
    return f"{np.median(values):.5f} / {np.max(values):.4f}"


if __name__ == "__main__":
    main()
