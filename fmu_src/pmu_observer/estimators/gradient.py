"""The paper's state gradient observer, on the cost (Y1 - |x|^2)^2.

(x3, x4)' = Gamma (Y1 - |x|^2) x + A x + (0, c1 u2)
"""

from typing import Annotated, NamedTuple

from ..angle import rotor_angle
from ..interface import Real, Scalar
from ..linear import Vector, dot, propagate
from ..sampling import half_steps


class Parameters(NamedTuple):
    Gamma: Annotated[
        Scalar, Real("1/s", "gain of the correction, per pu^2", min=0.0, max=1e12, nominal=10.0, tunable=True)
    ] = 10.0


class Outputs(NamedTuple):
    pass


class State(NamedTuple):
    x: Vector  # (E'd, E'q), pu


def start(xp, p, c, s):
    return State(Vector(0.0, 0.0))


def step(xp, p, c, state, interval):
    x = half_steps(
        xp,
        lambda x, s, h: pull(xp, x, s.Y1, p.Gamma * h),
        lambda x: propagate(interval.flow, x),
        interval,
        state.x,
    )
    return State(x)


def pull(xp, x: Vector, Y1, gain) -> Vector:
    """x' = (Y1 - |x|^2) x over `gain`, 1/pu^2, in closed form: |x|^2 is logistic, and x keeps its direction."""
    square = dot(x, x)
    decay = xp.maximum(xp.exp(-2 * gain * Y1), 1e-30)  # no division by zero for |x| = 0 and a high gain
    scale = xp.sqrt(Y1 / (square * (1 - decay) + Y1 * decay))
    return Vector(x.d * scale, x.q * scale)


def estimate(xp, state, s, near):
    return rotor_angle(xp, s, state.x, near)


def outputs(xp, state):
    return Outputs()
