"""Machine parameters wrong by 10 %, and the assumed noise by factors: the errors that result, next to an EKF's.

The EKF is that of `python -m scenarios compare`: given P_m and E_f, the best of its grid, tuned on another record with
the right parameters, from a good start. All get the same frames and the same wrong parameters.
"""

import argparse
from typing import NamedTuple

import numpy as np
from rich.console import Console
from rich.table import Table

from fmu_src.pmu_observer import tree
from fmu_src.pmu_observer.machines.data import Machine

from ..bench import frames
from ..bench.frames import rms
from . import batch, runs, tuning

STEADY_FROM = 5.0
"""s"""


class Case(NamedTuple):
    name: str
    machine: Machine
    tve: float


def cases(m: Machine, tve: float) -> list[Case]:
    found = [Case("all right", m, tve), Case("tve / 3", m, tve / 3), Case("tve x 3", m, tve * 3)]
    for names in (("xd",), ("xq",), ("Td10",), ("Tq10",), ("xd1", "xq1")):
        for factor in (0.9, 1.1):
            wrong = m._replace(**{name: factor * getattr(m, name) for name in names})
            found.append(Case(f"{' and '.join(names)} {factor - 1:+.0%}", wrong, tve))
    return found


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="python -m scenarios.compare.wrong_parameters",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--seeds", type=int, default=30, help="noise seeds (default: %(default)s)")
    parser.add_argument("--tve", type=float, default=0.003, help="noise of the phasors (default: %(default)s)")
    arguments = parser.parse_args()
    truth = frames.record(frames.RECORD_G6)
    tried = cases(truth.machine, arguments.tve)
    errors = run(truth, tried, arguments.tve, arguments.seeds)

    table = Table(title=f"RMS errors from {STEADY_FROM:g} s on, {arguments.seeds} seeds, TVE {arguments.tve:.1%}")
    for column in ("", *[f"{name}\n{q}" for name in errors for q in ("delta, rad", "E'd, pu", "E'q, pu")]):
        table.add_column(column)
    steady = frames.PERIOD * np.arange(1, len(truth.V)) > STEADY_FROM - 1e-9
    for i, case in enumerate(tried):
        values = [v[steady, i] for e in errors.values() for v in (e.delta, e.e1d, e.e1q)]
        table.add_row(case.name, *[f"{rms(v):.5f}" for v in values])
    Console(width=140).print(table)


def run(truth: frames.Truth, tried: list[Case], tve: float, seeds: int) -> dict[str, runs.Errors]:
    """By who makes them: the errors, shape (frames - 1, cases, 1, seeds)."""
    right = runs.noisy(truth, (tve,), seeds, 1)
    machine = tree.map(lambda *values: np.array(values)[:, None, None], *[case.machine for case in tried])
    assumed = np.array([case.tve for case in tried])[:, None, None]
    wrong = right._replace(truth=truth._replace(machine=machine), tve=assumed)

    def tick() -> None:
        pass

    q, _ = tuning.tuned(batch.ekf_step, runs.noisy(tuning.record_to_tune_on(), (tve,), 3, 2), tick)
    return {
        "robust": runs.run_observer("robust", wrong, tick),
        "no P_m, no E_f": runs.run_observer("robust", wrong, tick, mechanical_power=2, field_voltage=2),
        "EKF": runs.run_peer(batch.ekf_step, wrong, runs.good_start(wrong), tuning.P_of(tuning.P_GOOD), q, tick),
    }


if __name__ == "__main__":
    main()
