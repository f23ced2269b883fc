"""Joint gradient observer of (x1, x3, x4), on the cost that the paper's conclusion proposes.

    J = |Y1 - |x|^2|^2 / 2 + |(Y2, Y3) - R(x1) x|^2 / 2,     x = (x3, x4),  R(x1) a rotation by x1

    x1' = x2 - Gamma dJ/dx1,   x' = A x + (0, c1 u2) - Gamma dJ/dx,
    x2  = z + k x1,            z' = -(a0 + k) x2 + b0 (u1 - y5)

x2 is the speed that x1 turns with: the I&I observer of the paper on this estimator's own x1.
"""

from math import pi
from typing import Annotated, NamedTuple

from ..angle import Estimate, unwrap
from ..interface import Real, Scalar
from ..linear import Vector, decay_mean, dot, propagate
from ..sampling import half_steps
from .gradient import pull


class Parameters(NamedTuple):
    Gamma: Annotated[Scalar, Real("1/s", "gain of the correction", min=0.0, max=1e12, nominal=10.0, tunable=True)] = (
        10.0
    )
    k: Annotated[Scalar, Real("1/s", "speed correction per angle correction", min=0.0, max=1e6, tunable=True)] = 2.0


class Outputs(NamedTuple):
    pass


class State(NamedTuple):
    x1: Scalar  # rad
    x2: Scalar  # rad/s
    x: Vector  # (E'd, E'q), pu


def start(xp, p, c, s):
    # x = 0, and the rotor's q axis along E'
    return State(xp.atan2(s.Y3, s.Y2) - pi / 2, 0.0, Vector(0.0, 0.0))


def step(xp, p, c, state, interval):
    return half_steps(
        xp,
        lambda state, s, h: correct(xp, p, state, s, h),
        lambda state: swing(xp, c, state, interval)._replace(x=propagate(interval.flow, state.x)),
        interval,
        state,
    )


def swing(xp, c, state, interval):
    """x1' = x2, x2' = -a0 x2 + b0 (u1 - y5), exactly for the mean power of the interval."""
    before, after, h = interval.before.measured, interval.after.measured, interval.h
    acceleration = c.b0 * (before.P_m - before.P + after.P_m - after.P) / 2
    mean = decay_mean(xp, c.a0 * h)
    change = h * mean * (acceleration - c.a0 * state.x2)
    # the mean of x2 over the interval, second order in h like the mean power
    return state._replace(x1=state.x1 + h * (state.x2 + change / 2), x2=state.x2 + change)


def correct(xp, p, state, s, h):
    """The gradient flow of J over h for frozen signals, as a symmetric product of flows known in closed form."""
    x = pull(xp, state.x, s.Y1, p.Gamma * h)  # over h/2: the gradient of (Y1 - |x|^2)^2/2 is twice that of the pull
    x = towards_phasor(xp, x, state.x1, s, p.Gamma * h / 2)
    x1 = turn(xp, x, state.x1, s, p.Gamma * h)
    x = towards_phasor(xp, x, x1, s, p.Gamma * h / 2)
    x = pull(xp, x, s.Y1, p.Gamma * h)
    return State(x1, state.x2 + p.k * (x1 - state.x1), x)


def towards_phasor(xp, x, x1, s, gain):
    """x' = R(x1)^T (Y2, Y3) - x over `gain`."""
    cos, sin = xp.cos(x1), xp.sin(x1)
    d, q = cos * s.Y2 + sin * s.Y3, -sin * s.Y2 + cos * s.Y3
    decay = xp.exp(-gain)
    return Vector(d + (x.d - d) * decay, q + (x.q - q) * decay)


def turn(xp, x, x1, s, gain):
    """x1' = |E'| |x| sin(arg(Y2 + j Y3) - x1 - arg(x3 + j x4)) over `gain`: tan of half the sine's argument decays."""
    cos, sin = xp.cos(x1), xp.sin(x1)
    d, q = cos * s.Y2 + sin * s.Y3, -sin * s.Y2 + cos * s.Y3
    behind = xp.atan2(x.d * q - x.q * d, x.d * d + x.q * q)
    rate = xp.sqrt((s.Y2 * s.Y2 + s.Y3 * s.Y3) * dot(x, x))
    left = 2 * xp.atan2(xp.sin(behind / 2) * xp.exp(-gain * rate), xp.cos(behind / 2))
    return x1 + behind - left


def estimate(xp, state, s, near):
    return Estimate(unwrap(xp, state.x1, near), state.x)


def outputs(xp, state):
    return Outputs()
