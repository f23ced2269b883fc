"""The algebraic observer of the 3rd-order model (Proposition 1): every frame by itself, for a machine with E'd = 0.

E'd = 0,   E'q = |E'|,   delta = the angle of E'
"""

from typing import NamedTuple

from ..angle import rotor_angle
from ..linear import Vector
from ..third_order import observe


class Parameters(NamedTuple):
    pass


class Outputs(NamedTuple):
    pass


class State(NamedTuple):
    x: Vector  # (E'd, E'q), pu


def start(xp, p, c, s):
    m = s.measured
    return State(Vector(0.0, observe(xp, m.V, m.P, m.Q, m.I, c.x).e1q))


def step(xp, p, c, state, interval):
    return start(xp, p, c, interval.after)


def estimate(xp, state, s, near):
    return rotor_angle(xp, s, state.x, near)


def outputs(xp, state):
    return Outputs()
