"""One frame to the next: what every estimator needs of the interval [t-, t] that the frame at t closes."""

from typing import NamedTuple

from .interface import Scalar
from .linear import Propagation, propagation
from .machine import Constants
from .phasors import Signals


class Interval(NamedTuple):
    before: Signals  # the frame at t-
    after: Signals  # the frame at t
    h: Scalar  # s, t - t-
    flow: Propagation  # of (x3, x4) from t- to t


def interval(xp, c: Constants, before: Signals, after: Signals, h) -> Interval:
    """The interval with A and E_f linear between its two frames: second order in h."""
    forcing0, forcing1 = c.c1 * before.measured.E_f, c.c1 * after.measured.E_f
    return Interval(before, after, h, propagation(xp, before.A, after.A, forcing0, forcing1, h))


def half_steps(xp, correct, propagate, interval: Interval, state):
    """Strang splitting: half a correction at the frame before, the propagation, half a correction at the frame after.

    `correct(state, signals, h)` solves the correction exactly for frozen signals and is its own adjoint, so that the
    whole is second order in h and no gain is ever stiff.
    """
    state = correct(state, interval.before, interval.h / 2)
    state = propagate(state)
    return correct(state, interval.after, interval.h / 2)
