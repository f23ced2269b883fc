"""Who runs on which frames. All get the same frames and predict to the next one, as the FMU does."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from fmu_src.pmu_observer import observer
from fmu_src.pmu_observer.angle import unwrap
from fmu_src.pmu_observer.machines.two_axis import constants

from ..bench import frames
from ..bench.frames import PERIOD, Truth
from ..bench.streams import Streams, numbers
from . import model


class Frames(NamedTuple):
    """The noisy frames of a record; shape (frames, TVEs, seeds)."""

    truth: Truth
    tve: np.ndarray  # (TVEs, 1)
    V: np.ndarray  # pu, complex
    I: np.ndarray  # noqa: E741 - pu, complex


class Errors(NamedTuple):
    """Row k: of the prediction for frame k + 1; shape (frames - 1, ..., TVEs, seeds)."""

    delta: np.ndarray  # rad, in (-pi, pi]
    omega: np.ndarray  # rad/s
    e1d: np.ndarray  # pu
    e1q: np.ndarray  # pu
    tracking: np.ndarray  # 1 where the estimator says that it has captured; a peer always does

    @property
    def e1(self):
        """|error of (E'd, E'q)|, pu."""
        return np.hypot(self.e1d, self.e1q)


def noisy(truth: Truth, tves, seeds: int, seed: int) -> Frames:
    """The same noise for every TVE, but for its size."""
    tve = np.asarray(tves, float)[:, None]
    streams, channel = Streams(numbers(seed, (1, seeds))), frames.noise(tve)
    received = [channel(k, streams, *phasors) for k, phasors in enumerate(zip(truth.V, truth.I, strict=True))]
    V, I = (np.array([getattr(each, name) for each in received]) for name in ("V", "I"))  # noqa: E741 - the paper's name
    return Frames(truth, tve, V, I)


def errors(truth: Truth, k: int, x, tracking=1.0):
    """Of an estimate of (delta, omega, E'd, E'q) for frame k + 1."""
    true = (truth.delta, truth.omega, truth.e1d, truth.e1q)
    delta, omega, e1d, e1q = (value - column[k + 1] for value, column in zip(x, true, strict=True))
    return np.broadcast_arrays(unwrap(np, delta, 0.0), omega, e1d, e1q, tracking)


def run_observer(name: str, noisy: Frames, progress: Callable[[], None], **parameters) -> Errors:
    """The observer with the estimator `name`; its parameters may be arrays that broadcast with (TVEs, seeds)."""
    received = (frames.Received(*phasors) for phasors in zip(noisy.V, noisy.I, strict=True))
    rows = []
    for k, o in enumerate(frames.observe(name, noisy.truth, received, tve=noisy.tve, **parameters)):
        rows.append(errors(noisy.truth, k, (o.delta, o.omega, o.e1d, o.e1q), o.status == observer.TRACKING))
        progress()
    return Errors(*map(np.array, zip(*rows, strict=True)))


def run_peer(step: Callable, noisy: Frames, x, P, q, progress: Callable[[], None]) -> Errors:
    """An EKF or UKF from x (..., TVEs, seeds, 4) and P, with the process noise q (..., TVEs, 1, 3).

    For the EKF the machine may be one of arrays that broadcast with (..., TVEs, seeds).
    """
    truth, h = noisy.truth, PERIOD
    c = constants(truth.machine)
    Q = process_noise(q, noisy.tve)
    shape = np.broadcast_shapes(x.shape[:-1], P.shape[:-2], Q.shape[:-2])
    x = np.broadcast_to(x, (*shape, 4))
    u = [model.Inputs(*each) for each in zip(truth.P_m, truth.E_f, np.abs(noisy.V), np.angle(noisy.V), strict=True)]
    rows = []
    for k in range(len(truth.V) - 1):
        rows.append(errors(truth, k, model.f(np, c, np.moveaxis(x, -1, 0), u[k], h)))
        z, size2 = model.measured(c, noisy.V[k + 1], noisy.I[k + 1])
        z, R = np.stack([z.real, z.imag], axis=-1), noisy.tve**2 * size2 / 2
        x, P = step(c, x, P, Q, model.mean(u[k], u[k + 1]), h, z, R)
        progress()
    return Errors(*map(np.array, zip(*rows, strict=True)))


def process_noise(q, tve):
    """Q of one frame, shape (..., 4, 4), from q (..., 3) relative to tve, which broadcasts with (...)."""
    variances = PERIOD * (q * np.asarray(tve)[..., None]) ** 2
    Q = np.zeros((*variances.shape[:-1], 4, 4))
    Q[..., [1, 2, 3], [1, 2, 3]] = variances
    return Q


def good_start(noisy: Frames):
    """The steady state that the first frame would have: delta = arg(V + j xq I); shape (TVEs, seeds, 4)."""
    m, V, I = noisy.truth.machine, noisy.V[0], noisy.I[0]  # noqa: E741 - the paper's name
    delta = np.angle(V + 1j * m.xq * I)
    e1 = 1j * (V + 1j * m.xd1 * I) * np.exp(-1j * delta)
    return np.stack([delta, np.zeros_like(delta), e1.real, e1.imag], axis=-1)


def flat_start(noisy: Frames, turned: float = 0.0):
    """E' = 1 pu on the q axis, in the direction of the voltage, or turned away from there, rad."""
    delta = np.angle(noisy.V[0]) + turned
    return np.stack([delta, 0 * delta, 0 * delta, 1 + 0 * delta], axis=-1)
