"""Open loop: xi alone, the machine's equations driven by the frames without any correction.

    (x3, x4)' = A (x3, x4) + (0, c1 u2)

A(t) is usually stable, so that it converges by itself, as slowly as the machine's own time constants.
"""

from typing import NamedTuple

from ..angle import rotor_angle
from ..linear import Vector, propagate


class Parameters(NamedTuple):
    pass


class Outputs(NamedTuple):
    pass


class State(NamedTuple):
    x: Vector  # (E'd, E'q), pu


def start(xp, p, c, s):
    return State(Vector(0.0, 0.0))


def step(xp, p, c, state, interval):
    return State(propagate(interval.flow, state.x))


def estimate(xp, state, s, near):
    return rotor_angle(xp, s, state.x, near)


def outputs(xp, state):
    return Outputs()
