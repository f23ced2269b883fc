"""Lemma 3 of the paper (GPEBO): the state is a known trajectory plus a known matrix times an unknown constant.

    xi' = A xi + (0, c1 u2),  xi(0) = 0;    Phi' = A Phi,  Phi(0) = I;    (x3, x4) = xi + Phi theta

Y1 = |xi + Phi theta|^2 then gives the regression y_E = psi^T Theta, Theta = (th1, th2, th1 th2, th1^2, th2^2).
"""

from typing import NamedTuple, Tuple

from .interface import Scalar
from .linear import (
    IDENTITY,
    Matrix,
    Propagation,
    Vector,
    apply,
    columns,
    dot,
    multiply,
    propagate,
)


class Gpebo(NamedTuple):
    xi: Vector = Vector(0.0, 0.0)  # pu
    Phi: Matrix = IDENTITY


class Regression(NamedTuple):
    """y_E = psi^T Theta: five regressors and the measured left side, pu^2."""

    psi: Tuple[Scalar, Scalar, Scalar, Scalar, Scalar]
    y_E: Scalar


def advance(state: Gpebo, interval: Propagation) -> Gpebo:
    """xi and Phi over one interval, exactly for the mean A of it."""
    return Gpebo(propagate(interval, state.xi), multiply(interval.F, state.Phi))


def regression(state: Gpebo, Y1) -> Regression:
    """psi = (2 Phi1.xi, 2 Phi2.xi, 2 Phi1.Phi2, |Phi1|^2, |Phi2|^2), y_E = Y1 - |xi|^2; Phi1, Phi2 are columns."""
    xi = state.xi
    Phi1, Phi2 = columns(state.Phi)
    psi = (2 * dot(Phi1, xi), 2 * dot(Phi2, xi), 2 * dot(Phi1, Phi2), dot(Phi1, Phi1), dot(Phi2, Phi2))
    return Regression(psi, Y1 - dot(xi, xi))


def estimate(state: Gpebo, theta: Vector) -> Vector:
    """(x3, x4) = xi + Phi theta."""
    part = apply(state.Phi, theta)
    return Vector(state.xi.d + part.d, state.xi.q + part.q)
