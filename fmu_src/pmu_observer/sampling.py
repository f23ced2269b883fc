"""One frame to the next: what every estimator needs of the interval [t-, t] that the frame at t closes."""

from typing import NamedTuple

from . import noise
from .interface import Scalar
from .linear import Complex, Propagation, propagation
from .machines.two_axis import Constants
from .phasors import Signals


class Change(NamedTuple):
    """What the equations take as linear in time between two frames."""

    nu: Complex = Complex(0.0, 0.0)
    P: Scalar = 0.0  # pu
    E_f: Scalar = 0.0  # pu


STEADY = Change()


class Interval(NamedTuple):
    before: Signals  # the frame at t-
    after: Signals  # the frame at t
    h: Scalar  # s, t - t-
    flow: Propagation  # of (x3, x4) from t- to t
    jump: Change  # what changed at an unknown instant between the frames, and not linearly; zero in quiet times


def interval(xp, c: Constants, before: Signals, after: Signals, h, last: Change = STEADY) -> Interval:
    """The interval with A and E_f linear between its two frames: second order in h. `last` is the change before it."""
    forcing0, forcing1 = c.c1 * before.measured.E_f, c.c1 * after.measured.E_f
    flow = propagation(xp, before.A, after.A, forcing0, forcing1, h)
    return Interval(before, after, h, flow, jump(xp, after, change(before, after), last))


def change(before: Signals, after: Signals) -> Change:
    return Change(
        Complex(after.nu.re - before.nu.re, after.nu.im - before.nu.im),
        after.measured.P - before.measured.P,
        after.measured.E_f - before.measured.E_f,
    )


def jump(xp, s: Signals, now: Change, last: Change) -> Change:
    """The part of a change that is neither noise nor the going on of the last one: a fault, its clearing, a switching.

    |jump|^2 = min(|dnu|^2, |d2nu|^2), if |dnu|^2 and |d2nu|^2/3 are beyond 28 variances of nu's noise; they have 2, so
    that noise alone gets there once in a million frames. E_f has no noise.
    """
    size2 = now.nu.re * now.nu.re + now.nu.im * now.nu.im
    bend_re, bend_im = now.nu.re - last.nu.re, now.nu.im - last.nu.im
    bend2 = bend_re * bend_re + bend_im * bend_im
    jump2 = xp.minimum(size2, bend2)
    jumped = xp.minimum(size2, bend2 / 3) > 28 * noise.of_nu(s) + 1e-6
    scale = xp.where(jumped, xp.sqrt(jump2 / xp.maximum(size2, 1e-12)), 0.0)

    def smaller(change, last_change):
        return xp.minimum(xp.abs(change), xp.abs(change - last_change))

    return Change(
        Complex(scale * now.nu.re, scale * now.nu.im),
        xp.where(jumped, smaller(now.P, last.P), 0.0),
        smaller(now.E_f, last.E_f),
    )


def half_steps(xp, correct, propagate, interval: Interval, state):
    """Strang splitting: half a correction at the frame before, the propagation, half a correction at the frame after.

    `correct(state, signals, h)` solves the correction exactly for frozen signals and is its own adjoint, so that the
    whole is second order in h and no gain is ever stiff.
    """
    state = correct(state, interval.before, interval.h / 2)
    state = propagate(state)
    return correct(state, interval.after, interval.h / 2)
