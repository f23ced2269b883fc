"""How the EKF and the UKF are tuned: the best of a grid, on another record than the one they are judged on.

Process noise Q = h diag(0, q_omega^2, q_d^2, q_q^2) with each q relative to the TVE: their inputs' noise is.
R is right: it follows from the TVE. For every TVE the q is taken that has the least product of the RMS errors of delta,
omega and (E'd, E'q) after a good start; then the P of a flat start that has the least RMS error of (E'd, E'q) in 5 s.
"""

from collections.abc import Callable
from itertools import product

import numpy as np

from fmu_src.pmu_observer.plants import smib

from ..bench import frames, machines, smib_fault
from . import runs

Q_OMEGA = (3.0, 10.0, 30.0, 100.0)
"""rad/s per sqrt(s), relative to the TVE; the noise of P alone makes b0 |V I| sqrt(h) = 4.5 of it."""

Q_D = (0.01, 0.03, 0.1, 0.3, 1.0, 3.0)
Q_Q = (1e-4, 1e-3, 0.01, 0.1, 1.0)
"""pu per sqrt(s), relative to the TVE; the noise of V alone makes b2 V sqrt(h/2) = 0.9 of E'd and 0.05 of E'q."""

P_FLAT = (0.03, 0.1, 0.3, 1.0, 3.0)
"""Standard deviation of a flat start: rad, rad/s, pu and pu."""

P_GOOD = 0.05
"""The same of a good start."""

GRID = np.array(list(product(Q_OMEGA, Q_D, Q_Q)))


def record_to_tune_on() -> frames.Truth:
    """Generator 6 behind a line at an infinite bus, which a load elsewhere pulls down from 2 s to 6 s; 10 s."""
    plant = smib_fault.plant()

    def inputs(t: float, outputs: smib.Outputs) -> smib.Inputs:
        loaded = 2.0 <= t < 6.0
        return plant.inputs._replace(V_inf=0.99 if loaded else 1.0, theta_inf=-0.02 if loaded else 0.0)

    return machines.simulate(plant, 10.0, inputs=inputs)


def P_of(deviation):
    """P, shape (..., 4, 4), of a start with that standard deviation in every state."""
    return np.asarray(deviation)[..., None, None] ** 2 * np.eye(4)


def tuned(step: Callable, noisy: runs.Frames, progress: Callable[[], None]):
    """q, shape (TVEs, 1, 3), and the standard deviation of a flat start, shape (TVEs,)."""
    e = over_grid(step, noisy, progress)
    q = GRID[np.argmin(e.delta * e.omega * e.e1, axis=0)][:, None, :]
    P = P_of(np.array(P_FLAT)[:, None, None])
    flat = runs.run_peer(step, noisy, runs.flat_start(noisy), P, q, progress)
    best = np.argmin(np.mean(flat.e1[: round(5 / frames.PERIOD)] ** 2, axis=(0, -1)), axis=0)
    return q, np.array(P_FLAT)[best]


def over_grid(step: Callable, noisy: runs.Frames, progress: Callable[[], None]) -> runs.Errors:
    """RMS errors from 2 s on after a good start, for every q of the grid; shape (grid, TVEs)."""
    e = runs.run_peer(step, noisy, runs.good_start(noisy), P_of(P_GOOD), GRID[:, None, None, :], progress)
    return runs.Errors(*[np.sqrt(np.mean(v[round(2 / frames.PERIOD) :] ** 2, axis=(0, -1))) for v in e])
