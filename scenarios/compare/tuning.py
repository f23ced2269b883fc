"""How the EKF and the UKF are tuned: the best of a grid, on another record than the one they are judged on.

Process noise Q = h diag(0, q_omega^2, q_d^2, q_q^2) with each q relative to the TVE: their inputs' noise is.
R is right: it follows from the TVE. Tuning takes for every TVE the q with the least product of the RMS errors of delta,
omega and (E'd, E'q) after a good start; then the P of a flat start, by the RMS error of (E'd, E'q) over its first 5 s.
"""

from itertools import product
from typing import NamedTuple

import numpy as np

from fmu_src.pmu_observer.plants import smib

from ..studies import frames, machines

Q_OMEGA = (3.0, 10.0, 30.0, 100.0)
"""rad/s per sqrt(s), relative to the TVE; the noise of P alone makes b0 |V I| sqrt(h) = 4.5 of it."""

Q_D = (0.01, 0.03, 0.1, 0.3, 1.0, 3.0)
Q_Q = (1e-4, 1e-3, 0.01, 0.1, 1.0)
"""pu per sqrt(s), relative to the TVE; the noise of V alone makes b2 V sqrt(h/2) = 0.9 of E'd and 0.05 of E'q."""

P_FLAT = (0.03, 0.1, 0.3, 1.0, 3.0)
"""Standard deviation of a flat start: rad, rad/s, pu and pu."""

GRID = np.array(list(product(Q_OMEGA, Q_D, Q_Q)))


class Tuning(NamedTuple):
    q: np.ndarray  # (TVEs, 3): q_omega, q_d, q_q, relative to the TVE
    P_flat: np.ndarray  # (TVEs,)


def record_to_tune_on() -> frames.Truth:
    """Generator 6 behind a line at an infinite bus, which a load elsewhere pulls down from 2 s to 6 s; 10 s."""
    plant = machines.g6_behind_line()

    def inputs(t: float, outputs: smib.Outputs) -> smib.Inputs:
        loaded = 2.0 <= t < 6.0
        return plant.inputs._replace(V_inf=0.99 if loaded else 1.0, theta_inf=-0.02 if loaded else 0.0)

    return machines.simulate(plant, 10.0, inputs=inputs)


def process_noise(q, tve):
    """Q of one frame, shape (..., 4, 4), from q (..., 3) relative to tve, which broadcasts with (...)."""
    variances = frames.PERIOD * (q * np.asarray(tve)[..., None]) ** 2
    Q = np.zeros((*variances.shape[:-1], 4, 4))
    Q[..., [1, 2, 3], [1, 2, 3]] = variances
    return Q
