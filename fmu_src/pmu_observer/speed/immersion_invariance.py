"""The paper's immersion & invariance (I&I) speed observer, with Pm known or unknown.

    Pm known:    x2 = z + k x1,   z' = -(a0 + k) x2 + b0 (u1 - y5)               error: e' = -(a0 + k) e
    Pm unknown:  x2 = z + k1 x1,  d = n + k2 x1,  Pm = d/b0
                 z' = -(a0 + k1) x2 - b0 y5 + d,  n' = -k2 x2                     error: s^2 + (a0 + k1) s + k2

Over an interval in which x1 turns evenly these are linear equations in (x2, d), solved exactly; any k is stable.
High gains amplify noise: with 1 mrad on x1, k = 80 makes 0.046 rad/s of it and k = 2 makes 0.002 (50 frames/s).
"""

from typing import NamedTuple

from ..angle import Estimate, unwrap
from ..linear import Matrix, Propagation, Vector, exponential, propagate, relax
from ..machines.two_axis import Constants
from ..phasors import Signals
from ..sampling import Interval
from . import rotor as swing
from .rotor import Rotor


class Parameters(NamedTuple):
    pass


class Outputs(NamedTuple):
    pass


def start(xp, c: Constants, s: Signals, estimate: Estimate, settings):
    return swing.balanced(xp, estimate.delta, s.measured, settings.P_m_known), ()


def step(xp, p, c: Constants, rotor: Rotor, own, interval: Interval, estimate: Estimate, settings):
    turn = turn_of(xp, rotor, interval, estimate)
    moved = xp.cond(
        settings.P_m_known,
        lambda: step_known(xp, rotor, c.a0, c.b0, settings.k, interval, turn),
        lambda: step_unknown(xp, rotor, c.a0, c.b0, settings.k, interval, turn),
    )
    return moved._replace(delta=estimate.delta), own


def turn_of(xp, rotor: Rotor, interval: Interval, estimate: Estimate):
    """By how much the rotor has turned over the interval, rad; the estimator's correction is no turn of the rotor."""
    return unwrap(xp, estimate.delta + estimate.turn - rotor.delta, rotor.omega * interval.h)


def step_known(xp, rotor: Rotor, a0, b0, k, interval, turn) -> Rotor:
    """x2+ = E x2 + (1 - E)/L (k dx1/h + b0 (u1 - mean y5)),  L = a0 + k,  E = e^(-L h)."""
    h = interval.h
    P_m = (interval.before.measured.P_m + interval.after.measured.P_m) / 2
    drive = k * turn / h + b0 * (P_m - mean_power(interval))
    omega = relax(xp, rotor.omega, a0 + k, drive, h)
    return Rotor(rotor.delta + turn, omega, interval.after.measured.P_m)


def step_unknown(xp, rotor: Rotor, a0, b0, k, interval, turn) -> Rotor:
    """The same with d = b0 Pm as a second state; k1 = k, and k2 = (a0 + k)^2/4 puts both poles at -(a0 + k)/2."""
    h = interval.h
    L = a0 + k
    k2 = L * L / 4
    F = exponential(xp, Matrix(-L, 1.0, -k2, 0.0), h)
    # about the point (x2, d) where the interval's even turn would leave it at rest
    omega_rest = turn / h
    d_rest = a0 * omega_rest + b0 * mean_power(interval)
    omega, d = propagate(
        Propagation(F, Vector(omega_rest, d_rest)), Vector(rotor.omega - omega_rest, b0 * rotor.P_m - d_rest)
    )
    return Rotor(rotor.delta + turn, omega, d / b0)


def mean_power(interval):
    return (interval.before.measured.P + interval.after.measured.P) / 2


def constants(c: Constants, own) -> Constants:
    return c


def outputs(xp, own):
    return Outputs()
