"""The fit: the data that make the innovations smallest, with the derivatives of smoothed phasors as instruments.

Noise in the regressors biases every least-squares fit, also one of innovations. So the residuals r are those of the raw
frames, but the derivatives J those of smoothed ones, where each phasor comes from its neighbours and shares no noise
with its own residual. What is solved is  J' r + (u - u_sheet)/spread^2 = 0  (instrumental variables), by
Levenberg and Marquardt; a step is taken by the cost of r_smooth(u') + [r(u) - r_smooth(u)].
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from . import parameters
from .innovations import innovations
from .model import linear
from .parameters import Free
from .prepare import Prepared

START_SPREAD = 0.1
"""pu, prior of E'd and E'q at the first frame about the quasi-steady state."""

SHARE_SPREAD = 0.5
"""Prior of the share of an interval before its jump, about 1/2; narrower ones bias T'q0 where events lie on frames."""

P_M_SPREAD, P_M_UNKNOWN, P_M_WALK = 0.02, 0.3, 0.005
"""pu of the record's largest P: offset of a recorded P_m; of one that is not recorded; and pu/sqrt(s) its walk."""

INSTRUMENTS = ("gain of V", "gain of I", "angle of I")

DIFFERENCE = 1e-4
"""Of u, in a derivative."""

LONGEST_STEP = 0.3
"""Of u, a logarithm, in one step."""

ANNEALED = {"two_axis": (0.01,), "genrou": (0.1, 0.01)}
"""TVEs that are assumed first, where they are above the record's: the cost has fewer wells."""

MOST_STEPS, SMALL_STEP = 40, 0.01
"""Steps of Levenberg and Marquardt; the last one is shorter than 0.01 standard deviations."""


class Problem(NamedTuple):
    order: str
    free: Free
    records: tuple[Prepared, ...]
    instruments: tuple[float, float] | None  # spread of gains (relative) and angle (rad) of V and I; None: exact
    tve: float


class Fit(NamedTuple):
    problem: Problem
    u: np.ndarray  # all unknowns: the parameters, instruments, then those of each record
    spread: np.ndarray  # of their priors
    covariance: np.ndarray  # of u
    information: np.ndarray  # J'J, without the priors
    residuals: list[np.ndarray]  # (T, 2) a record; 0 where a frame is not good
    cost: float  # sum r^2 + prior
    converged: bool


class Unknowns(NamedTuple):
    """Where in u the unknowns are, and about what their priors lie."""

    centre: np.ndarray
    spread: np.ndarray
    shared: int  # parameters and instruments
    own: list[slice]  # of each record: p of the first frame (2), shares, shares of E_f


def unknowns(p: Problem) -> Unknowns:
    spread = list(p.free.spread)
    if p.instruments:
        gain, angle = p.instruments
        spread += [gain, gain, angle]
    shared = len(spread)
    centre = [0.0] * shared
    own = []
    for record in p.records:
        shares = len(record.events) + len(record.E_f_events)
        own.append(slice(len(spread), len(spread) + 2 + shares))
        spread += [START_SPREAD] * 2 + [SHARE_SPREAD] * shares
        centre += [0.0] * 2 + [0.5] * shares
    return Unknowns(np.array(centre), np.array(spread), shared, own)


def residuals(p: Problem, where: Unknowns, number: int, u: np.ndarray, smooth: bool, tve: float):
    """(C, T, 2) of candidates u (C, unknowns) on one record, and the filter's states."""
    record = p.records[number]
    V, I = (record.smooth_V, record.smooth_I) if smooth else (record.V, record.I)  # noqa: E741 - the paper's name
    V, I = V[None], I[None]  # noqa: E741 - the paper's name
    names = len(p.free.names)
    machine, k_f = parameters.machine(p.free, u[:, :names])
    if p.instruments:
        gain_V, gain_I, angle_I = u[:, names : names + 3].T[..., None]
        V, I = V * (1 + gain_V), I * (1 + gain_I) * np.exp(1j * angle_I)  # noqa: E741 - the paper's name
    own = u[:, where.own[number]]
    events = 2 + len(record.events)
    share, E_f_share = (np.full((len(u), len(record.h)), -2.0) for _ in range(2))
    share[:, record.events] = np.clip(own[:, 2:events], -0.5, 1.5)
    E_f_share[:, record.E_f_events] = np.clip(own[:, events:], -0.5, 1.5)
    P_m = record.record.P_m
    largest = float(np.max(np.abs(record.V * record.I)))
    known = P_m is not None
    b0 = machine.omega_s / (2 * machine.H)
    return innovations(
        linear(p.order, machine, V, I),
        record.h,
        share,
        k_f[:, None] * record.record.E_f,
        E_f_share,
        P_m if known else np.full(len(record.h), (record.V[0] * record.I[0].conj()).real),
        record.good,
        b0,
        machine.D * b0,
        tve,
        (P_M_SPREAD if known else P_M_UNKNOWN) * largest,
        0.0 if known else P_M_WALK * largest,
        own[:, :2],
    )


def stacked(p: Problem, where: Unknowns, u: np.ndarray, smooth: bool, tve: float) -> np.ndarray:
    """All records' residuals (R,) of one u."""
    return np.concatenate([residuals(p, where, i, u[None], smooth, tve)[0][0].ravel() for i in range(len(p.records))])


def derivatives(p: Problem, where: Unknowns, u: np.ndarray, tve: float) -> tuple[np.ndarray, np.ndarray]:
    """r (R,) and J (R, unknowns) on the smoothed phasors: a candidate for every unknown of the record."""
    r, J = [], []
    for i in range(len(p.records)):
        moved = [*range(where.shared), *range(*where.own[i].indices(len(u)))]
        candidates = np.tile(u, (len(moved) + 1, 1))
        candidates[np.arange(1, len(moved) + 1), moved] += DIFFERENCE * step_scale(where, moved)
        found = residuals(p, where, i, candidates, True, tve)[0].reshape(len(candidates), -1)
        block = np.zeros((found.shape[1], len(u)))
        block[:, moved] = (found[1:] - found[0]).T / (DIFFERENCE * step_scale(where, moved))
        r.append(found[0])
        J.append(block)
    return np.concatenate(r), np.concatenate(J)


def step_scale(where: Unknowns, moved) -> np.ndarray:
    """D and the start are no logarithms: their differences are taken in their priors."""
    return np.minimum(where.spread[moved] / 0.15, 1.0)


def fit(p: Problem, start: np.ndarray | None = None, progress: Callable[[float], None] = lambda done: None) -> Fit:
    """Annealed from a large TVE to the records'. Raises LinAlgError where nothing is told at all (no usable frame)."""
    where = unknowns(p)
    u = where.centre.copy()
    if start is not None:
        u[: len(start)] = start
    levels = [tve for tve in ANNEALED[p.order] if tve > 1.5 * p.tve] + [p.tve]
    converged = False
    for number, tve in enumerate(levels):
        u, converged = levenberg_marquardt(p, where, u, tve)
        progress((number + 1) / len(levels))
    r = [residuals(p, where, i, u[None], False, p.tve)[0][0] for i in range(len(p.records))]
    _, J = derivatives(p, where, u, p.tve)
    information = J.T @ J
    covariance = np.linalg.inv(information + np.diag(where.spread**-2.0))
    cost = sum(float(np.sum(x * x)) for x in r) + prior_cost(where, u)
    return Fit(p, u, where.spread, covariance, information, r, cost, converged)


def prior_cost(where: Unknowns, u: np.ndarray) -> float:
    return float(np.sum(((u - where.centre) / where.spread) ** 2))


def levenberg_marquardt(p: Problem, where: Unknowns, u: np.ndarray, tve: float) -> tuple[np.ndarray, bool]:
    damping, growth = 1e-3, 2.0
    prior = where.spread**-2.0
    raw = stacked(p, where, u, False, tve)
    smooth, J = derivatives(p, where, u, tve)
    for _ in range(MOST_STEPS):
        gradient = J.T @ raw + prior * (u - where.centre)
        normal = J.T @ J + np.diag(prior)
        step = -np.linalg.solve(normal + damping * np.diag(np.diag(normal)), gradient)
        step *= min(1.0, LONGEST_STEP / max(float(np.max(np.abs(step[: where.shared]))), 1e-12))
        length = float(np.sqrt(step @ normal @ step))
        if length < SMALL_STEP:
            return u, True
        there = u + step
        smooth_there = stacked(p, where, there, True, tve)
        before = float(raw @ raw) + prior_cost(where, u)
        corrected = smooth_there + (raw - smooth)
        after = float(corrected @ corrected) + prior_cost(where, there)
        promised = -float(step @ (2 * gradient + normal @ step))
        ratio = (before - after) / max(promised, 1e-30) if np.isfinite(after) else -1.0
        if ratio > 0:
            u = there
            raw = stacked(p, where, u, False, tve)
            smooth, J = derivatives(p, where, u, tve)
            damping *= max(1 / 3, 1 - (2 * ratio - 1) ** 3)
            growth = 2.0
        else:
            damping *= growth
            growth *= 2
            if damping > 1e8:
                return u, True
    return u, False
