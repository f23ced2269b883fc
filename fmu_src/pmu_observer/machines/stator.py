"""What the nonlinear form of every model shares: pairs in the rotor's frame, and the stator.

V_d = E_d + X_q I_q - Ra I_d,  V_q = E_q - X_d I_d - Ra I_q        j V = e^{j delta} (V_d + j V_q), and so for I
"""

from typing import NamedTuple

from ..interface import Scalar
from ..linear import Vector


class Stator(NamedTuple):
    """A voltage behind reactances, pu."""

    E: Vector
    X_d: Scalar
    X_q: Scalar


class Field(NamedTuple):
    """A machine at rest: V_q + Ra I_q = E_f/gain - X_d I_d,  V_d + Ra I_d = X_q I_q."""

    gain: Scalar
    X_d: Scalar
    X_q: Scalar


def behind(v: Vector, i: Vector, x) -> Vector:
    """V + j x I in the rotor's frame."""
    return Vector(v.d - x * i.q, v.q + x * i.d)


def magnitude(xp, v: Vector):
    return xp.sqrt(v.d * v.d + v.q * v.q)


def magnitude_behind(xp, V, I, Q, x):  # noqa: E741 - the paper's name
    """|V + j x I| from what a frame gives: V, I and Q."""
    return xp.sqrt(xp.maximum(V * V + x * (2 * Q + x * I * I), 0.0))
