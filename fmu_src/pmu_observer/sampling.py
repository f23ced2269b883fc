"""One frame to the next: what every estimator needs of the interval [t-, t] that the frame at t closes.

An interval may be of any length: frames that are lost or not believed make a longer one, and so does a slow PMU.
"""

from typing import Any, NamedTuple

from . import noise
from .interface import Scalar
from .linear import Complex, propagation
from .machines.two_axis import Constants
from .phasors import Signals
from .transition import transition

SEEN = 0.1
"""s; over longer than this, what happened between two frames cannot be concluded from them: swings last 0.5 to 2 s."""

JUMP = 28.0
"""Variances of nu's noise beyond which a change is a jump: changes have 2 of them, so that noise alone gets there once
in a million frames (e^-14)."""

SHORTEST = 1e-3
"""s; PMUs are not faster, but a master may hand over two frames at nearly the same instant."""

LEAST_JUMP2 = 1e-6
"""The square of a change of nu below which it is none, whatever the noise."""


class Change(NamedTuple):
    """How fast, on average over an interval, what the equations take as linear in time has changed."""

    nu: Complex = Complex(0.0, 0.0)  # 1/s
    P: Scalar = 0.0  # pu/s
    E_f: Scalar = 0.0  # pu/s


STEADY = Change()


class Jump(NamedTuple):
    """What changed at an unknown instant between two frames, and not linearly; zero in quiet times."""

    nu: Complex
    P: Scalar  # pu
    E_f: Scalar  # pu


class Interval(NamedTuple):
    before: Signals  # the frame at t-
    after: Signals  # the frame at t
    h: Scalar  # s, t - t-
    jump: Jump
    flow: Any  # from t- to t: Propagation of (x3, x4), or Transition under a machine model


def interval(xp, c: Constants, before: Signals, after: Signals, h, last: Change = STEADY) -> Interval:
    """The interval with A and E_f linear between its two frames: second order in h. `last` is the change before it."""
    jumped = jump(xp, before, after, h, last)
    return Interval(before, after, h, jumped, flow(xp, c, before, after, h, jumped))


def flow(xp, c: Constants, before: Signals, after: Signals, h, jump: Jump):
    if c.model:
        return transition(xp, c, before, after, h, jump, xp.maximum(h - SEEN, 0.0))
    return propagation(xp, before.A, after.A, c.c1 * before.measured.E_f, c.c1 * after.measured.E_f, h)


def change(xp, before: Signals, after: Signals, h) -> Change:
    per_second = 1 / xp.maximum(h, SHORTEST)
    return Change(
        Complex((after.nu.re - before.nu.re) * per_second, (after.nu.im - before.nu.im) * per_second),
        (after.measured.P - before.measured.P) * per_second,
        (after.measured.E_f - before.measured.E_f) * per_second,
    )


def jump(xp, before: Signals, after: Signals, h, last: Change) -> Jump:
    """The part of a change that is neither noise nor the going on of the last one: a fault, its clearing, a switching.

    |jump|^2 = min(|dnu|^2, |d2nu|^2), if |dnu|^2 and |d2nu|^2/3 are beyond JUMP variances of nu's noise: d2nu has three
    times the variance of dnu. What went on for longer than SEEN is not expected to go on. E_f has no noise.
    """
    on = xp.minimum(h, SEEN)
    re, im = after.nu.re - before.nu.re, after.nu.im - before.nu.im
    bend_re, bend_im = re - on * last.nu.re, im - on * last.nu.im
    size2 = re * re + im * im
    bend2 = bend_re * bend_re + bend_im * bend_im
    jumped = xp.minimum(size2, bend2 / 3) > JUMP * noise.of_nu(after) + LEAST_JUMP2
    scale = xp.where(jumped, xp.sqrt(xp.minimum(size2, bend2) / xp.maximum(size2, 1e-12)), 0.0)

    def smaller(difference, last_rate):
        return xp.minimum(xp.abs(difference), xp.abs(difference - on * last_rate))

    return Jump(
        Complex(scale * re, scale * im),
        xp.where(jumped, smaller(after.measured.P - before.measured.P, last.P), 0.0),
        smaller(after.measured.E_f - before.measured.E_f, last.E_f),
    )


def ahead(xp, c: Constants, s: Signals, h, last: Change) -> Interval:
    """The interval of length h that begins with a frame, with that frame held.

    The estimators take Y1, A and P of the frame on. What changed over the last interval may do so again, unseen.
    """
    on = xp.minimum(h, SEEN)
    unseen = Jump(Complex(on * last.nu.re, on * last.nu.im), on * last.P, on * last.E_f)
    return Interval(s, s, h, unseen, flow(xp, c, s, s, h, unseen))


def half_steps(xp, correct, propagate, interval: Interval, state):
    """Strang splitting: half a correction at the frame before, the propagation, half a correction at the frame after.

    `correct(state, signals, h)` solves the correction exactly for frozen signals and is its own adjoint, so that the
    whole is second order in h and no gain is ever stiff.
    """
    state = correct(state, interval.before, interval.h / 2)
    state = propagate(state)
    return correct(state, interval.after, interval.h / 2)
