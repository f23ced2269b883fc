"""How good any estimator can be: the Cramer-Rao bound along a record, beside the errors of `robust`.

    python -m scenarios.compare.bound [RECORD ...] --help

The recursion of the Fisher information of Tichavsky, Muravchik and Nehorai (IEEE Trans. Signal Processing 46 (1998)
1386-1396), for the trajectory of the record and states that follow their equations exactly (Taylor, IEEE Trans.
Automatic Control 24 (1979) 343-344): the machine, P_m and E_f are known, of the start nothing is, and the voltage at
each frame is one more unknown that its own noisy phasor tells of. What is left to Monte Carlo are the errors.

    s = (x, Re V, Im V),  x+ = f(x, (V + V+)/2),  seen are V and I = (j V - z)/x',  z = e^{j delta} (E'd + j E'q)

Without a prior the information is proportional to 1/tve^2 and the bound to tve. It is one of the prediction for the
next frame from the frames so far, with the last one held, as the observer's outputs are. Where the voltage changes
meanwhile, every estimator is wrong by more: the 0.5 s after events do not count.
"""

import argparse

import numpy as np
from rich.console import Console
from rich.table import Table

from fmu_src.pmu_observer.machines.two_axis import Constants, constants

from ..bench.frames import PERIOD, Truth, rms
from ..progress import progress_bar
from . import comparison, model, runs

STATES = {"delta": "rad", "omega": "rad/s", "e1d": "pu", "e1q": "pu"}

DIFFERENCE = 1e-6
"""Step of the central differences, rad, rad/s and pu: their error, about 1e-12, and rounding, 1e-10, are no matter."""


def bounds(truth: Truth) -> np.ndarray:
    """The least RMS error of the prediction for frame k + 1, per unit of tve, shape (frames - 1, 4); inf at first."""
    c = constants(truth.machine)
    J = information(c, truth, 0)
    rows = []
    for k in range(len(truth.V) - 1):
        rows.append(prediction(c, truth, k, J))
        J = moved(c, truth, k, J) + information(c, truth, k + 1)
    return np.array(rows)


def information(c: Constants, truth: Truth, k: int) -> np.ndarray:
    """Of frame k alone about s, (6, 6), for tve = 1: H^T R^-1 H."""
    H = np.zeros((4, 6))
    H[:2, 4:] = np.eye(2)
    H[2:, :4] = -model.h_jacobian(state(truth, k)) / c.x
    H[2:, 4:] = np.array([[0, -1], [1, 0]]) / c.x
    R = np.repeat(np.abs([truth.V[k], truth.I[k]]) ** 2 / 2, 2)
    return H.T / R @ H


def moved(c: Constants, truth: Truth, k: int, J: np.ndarray) -> np.ndarray:
    """The information about s at frame k + 1 from frames up to k: V at frame k is eliminated."""
    F, G = linearised(c, truth, k, ahead=1)
    back = np.linalg.inv(F)
    T = np.zeros((6, 8))  # s at frame k from (x, V) at frame k + 1 and V at frame k
    T[:4, :4], T[:4, 4:6], T[:4, 6:] = back, -back @ G / 2, -back @ G / 2
    T[4:, 6:] = np.eye(2)
    A = T.T @ J @ T
    return A[:6, :6] - A[:6, 6:] @ np.linalg.solve(A[6:, 6:], A[6:, :6])


def prediction(c: Constants, truth: Truth, k: int, J: np.ndarray) -> np.ndarray:
    """The standard deviations of x at frame k + 1, (4,), with V held; inf while the frames do not tell all of s."""
    if np.linalg.cond(scaled(J)) > 1e12:
        return np.full(4, np.inf)
    M = np.hstack(linearised(c, truth, k, ahead=0))
    return np.sqrt(np.diag(M @ np.linalg.inv(J) @ M.T))


def scaled(J: np.ndarray) -> np.ndarray:
    """With ones on the diagonal."""
    size = np.sqrt(np.diag(J) + 1e-300)
    return J / np.outer(size, size)


def linearised(c: Constants, truth: Truth, k: int, ahead: int):
    """F = df/dx (4, 4) and G = df/d(Re V, Im V) (4, 2) over the interval from frame k, at the mean of V there.

    `ahead` = 0: V of frame k is held.
    """
    V = (truth.V[k] + truth.V[k + ahead]) / 2
    steps = DIFFERENCE * np.vstack([np.eye(6), -np.eye(6)])
    x = state(truth, k)[:, None] + steps.T[:4]
    V = V + steps[:, 4] + 1j * steps[:, 5]
    u = model.Inputs(truth.P_m[k], truth.E_f[k], np.abs(V), np.angle(V))
    after = np.array(model.f(np, c, x, u, PERIOD))
    slopes = (after[:, :6] - after[:, 6:]) / (2 * DIFFERENCE)
    return slopes[:, :4], slopes[:, 4:]


def state(truth: Truth, k: int) -> np.ndarray:
    return np.array([truth.delta[k], truth.omega[k], truth.e1d[k], truth.e1q[k]])


AFTER_EVENTS = 0.5
"""s that do not count after a jump of the voltage."""

JUMP = 0.005
"""pu between two frames, of the voltage phasor less its change before; an event, on these records."""


def quiet(truth: Truth) -> np.ndarray:
    """Of the predictions for frame k + 1: from 5 s on, and not in the AFTER_EVENTS after a jump."""
    t = PERIOD * np.arange(1, len(truth.V))
    bend = np.abs(np.diff(truth.V, 2, prepend=truth.V[0], append=truth.V[-1]))[1:]
    since = t.copy()
    for k in np.flatnonzero(bend > JUMP):
        since[k:] = np.minimum(since[k:], t[k:] - t[k])
    return (t > comparison.STEADY_FROM - 1e-9) & (since >= AFTER_EVENTS)


TVES = (0.001, 0.01)


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="python -m scenarios.compare.bound",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    known = list(comparison.JUDGED)
    parser.add_argument("records", nargs="*", metavar="RECORD", help=f"{', '.join(known)} (default: all)")
    parser.add_argument("--seeds", type=int, default=100, help="noise seeds (default: %(default)s)")
    arguments = parser.parse_args()
    for name in arguments.records:
        if name not in known:
            parser.error(f'there is no "{name}"; known: {", ".join(known)}')
    console = Console(width=120)
    table = Table("record", "TVE", "", "bound", "robust", "robust/bound", title="RMS in quiet times, from 5 s on")
    for name in arguments.records or known:
        truth = comparison.JUDGED[name].truth()
        least_of_all, counts = bounds(truth), quiet(truth)
        least = least_of_all[counts]
        noisy = runs.noisy(truth, TVES, arguments.seeds, comparison.SEED)
        with progress_bar(console) as progress:
            errors = runs.run_observer("robust", noisy, comparison.Work(progress, len(least_of_all)).of(1))
        for i, tve in enumerate(TVES):
            for j, (quantity, unit) in enumerate(STATES.items()):
                bound, ours = tve * rms(least[:, j]), rms(getattr(errors, quantity)[counts, i])
                cells = f"{bound:.3g} {unit}", f"{ours:.3g} {unit}", f"{ours / bound:.2f}"
                table.add_row(name, f"{tve:.1%}", quantity, *cells)
    console.print(table)


if __name__ == "__main__":
    main()
