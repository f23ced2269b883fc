"""What the EKF and the UKF know of the machine: the usual 4-state model, driven by the frame's voltage.

    x = (delta, omega, E'd, E'q),   u = (P_m, E_f, V, theta),   z = j E' = j (V + j x' I) = e^{j delta} (E'd + j E'q)

V and I enter z such that its noise is circular, E|n|^2 = tve^2 (V^2 + (x' I)^2). Taking I for z instead, with
h(x) = (E' - V)/(j x'), is the same filter: all residuals are divided by j x'.
"""

from typing import NamedTuple

import numpy as np

from fmu_src.pmu_observer.interface import Scalar
from fmu_src.pmu_observer.machines.two_axis import Constants
from fmu_src.pmu_observer.plants import runge_kutta

ALPHA, BETA, KAPPA = 1.0, 2.0, 0.0
"""Of the UKF's sigma points (Merwe); with alpha = 1 they lie 2 standard deviations out."""


class Inputs(NamedTuple):
    P_m: Scalar  # pu
    E_f: Scalar  # pu
    V: Scalar  # pu
    theta: Scalar  # rad


def mean(before: Inputs, after: Inputs) -> Inputs:
    """Over an interval: of P_m, E_f and the voltage phasor."""
    phasor = (before.V * np.exp(1j * before.theta) + after.V * np.exp(1j * after.theta)) / 2
    return Inputs((before.P_m + after.P_m) / 2, (before.E_f + after.E_f) / 2, np.abs(phasor), np.angle(phasor))


def derivative(xp, c: Constants, x, u: Inputs):
    """x', in rad/s, rad/s^2 and pu/s; `x` is a sequence of four scalars."""
    delta, omega, e1d, e1q = x
    d, q = u.V * xp.sin(delta - u.theta), u.V * xp.cos(delta - u.theta)
    P = (e1q * d - e1d * q) / c.x
    return (
        omega,
        -c.a0 * omega + c.b0 * (u.P_m - P),
        -c.a2 * e1d + c.b2 * d,
        -c.a1 * e1q + c.b1 * q + c.c1 * u.E_f,
    )


def f(xp, c: Constants, x, u: Inputs, h):
    """x after h with u constant."""
    return runge_kutta.step(lambda x: derivative(xp, c, x, u), tuple(x), h)


def f_jacobian(c: Constants, x, u: Inputs, h):
    """F = I + h A + (h A)^2/2 with A = d derivative/dx at x; shape (..., 4, 4)."""
    delta, _, e1d, e1q = x
    d, q = u.V * np.sin(delta - u.theta), u.V * np.cos(delta - u.theta)
    A = np.zeros((*np.shape(delta), 4, 4))
    A[..., 0, 1] = 1
    A[..., 1, 0] = -c.b0 / c.x * (e1q * q + e1d * d)
    A[..., 1, 1] = -c.a0
    A[..., 1, 2] = c.b0 / c.x * q
    A[..., 1, 3] = -c.b0 / c.x * d
    A[..., 2, 0] = c.b2 * q
    A[..., 2, 2] = -c.a2
    A[..., 3, 0] = -c.b1 * d
    A[..., 3, 3] = -c.a1
    hA = h * A
    return np.eye(4) + hA + hA @ hA / 2


def h(xp, x):
    """(Re z, Im z)."""
    delta, _, e1d, e1q = x
    cos, sin = xp.cos(delta), xp.sin(delta)
    return e1d * cos - e1q * sin, e1d * sin + e1q * cos


def h_jacobian(x):
    """dh/dx, shape (..., 2, 4)."""
    re, im = h(np, x)
    H = np.zeros((*np.shape(re), 2, 4))
    cos, sin = np.cos(x[0]), np.sin(x[0])
    H[..., 0, 0], H[..., 0, 2], H[..., 0, 3] = -im, cos, -sin
    H[..., 1, 0], H[..., 1, 2], H[..., 1, 3] = re, sin, cos
    return H


def measured(c: Constants, V, I):  # noqa: E741 - the paper's name
    """z and |.|^2 of what its noise is relative to, V^2 + (x' I)^2, of complex phasors in pu."""
    z = 1j * (V + 1j * c.x * I)
    return z, np.abs(V) ** 2 + np.abs(c.x * I) ** 2
