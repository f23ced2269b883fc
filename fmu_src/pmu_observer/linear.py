"""2x2 linear systems x' = A x + b on scalars: their exact solution over one interval."""

from typing import NamedTuple

from .interface import Scalar


class Vector(NamedTuple):
    """(x3, x4) = (E'd, E'q), or any other pair."""

    d: Scalar
    q: Scalar


class Matrix(NamedTuple):
    """Rows d, q; columns d, q."""

    dd: Scalar
    dq: Scalar
    qd: Scalar
    qq: Scalar


class Complex(NamedTuple):
    re: Scalar
    im: Scalar


IDENTITY = Matrix(1.0, 0.0, 0.0, 1.0)


def dot(v: Vector, w: Vector):
    return v.d * w.d + v.q * w.q


def apply(m: Matrix, v: Vector) -> Vector:
    return Vector(m.dd * v.d + m.dq * v.q, m.qd * v.d + m.qq * v.q)


def multiply(m: Matrix, n: Matrix) -> Matrix:
    return Matrix(
        m.dd * n.dd + m.dq * n.qd,
        m.dd * n.dq + m.dq * n.qq,
        m.qd * n.dd + m.qq * n.qd,
        m.qd * n.dq + m.qq * n.qq,
    )


def mean(m: Matrix, n: Matrix) -> Matrix:
    return Matrix((m.dd + n.dd) / 2, (m.dq + n.dq) / 2, (m.qd + n.qd) / 2, (m.qq + n.qq) / 2)


def columns(m: Matrix):
    return Vector(m.dd, m.qd), Vector(m.dq, m.qq)


def exponential(xp, a: Matrix, h) -> Matrix:
    """exp(A h), from the eigenvalues m +- r or m +- i r of A h:

    exp(A h) = c I + s (A h - m I),  c = e^m cosh r, s = e^m sinh(r)/r, or c = e^m cos r, s = e^m sin(r)/r.

    Real eigenvalues enter as e^(m+r) and e^(m-r), so that a long interval with a fast mode does not overflow;
    near r = 0 a series replaces the difference of the two.
    """
    m = (a.dd + a.qq) * h / 2
    half = (a.dd - a.qq) * h / 2
    off_dq, off_qd = a.dq * h, a.qd * h
    square = half * half + off_dq * off_qd  # r^2, negative for complex eigenvalues
    r = xp.sqrt(xp.abs(square))
    r_safe = xp.maximum(r, 1e-2)
    e_m = _exp(xp, m)
    fast, slow = _exp(xp, m + r), _exp(xp, m - r)
    series = e_m * (1 + square / 6 * (1 + square / 20 * (1 + square / 42)))
    oscillating = square < 0
    c = xp.where(oscillating, e_m * xp.cos(r), (fast + slow) / 2)
    ratio = xp.where(oscillating, e_m * xp.sin(r) / r_safe, (fast - slow) / (2 * r_safe))
    s = xp.where(r < 1e-2, series, ratio)
    return Matrix(c + s * half, s * off_dq, s * off_qd, c - s * half)


def _exp(xp, exponent):
    # a mode that grows by e^50 is lost anyway, and its covariance, in the fourth power of this, stays finite
    return xp.exp(xp.minimum(exponent, 50.0))


def decay_mean(xp, rate_h):
    """(1 - e^-z)/z for z = rate h >= 0: the mean of e^-rate t over the interval, 1 at z = 0."""
    z = xp.maximum(rate_h, 1e-30)
    return -xp.expm1(-z) / z


def relax(xp, v, rate, drive, h):
    """v' = drive - rate v over an interval of length h, exactly for a constant drive and a constant rate >= 0."""
    return v + h * decay_mean(xp, rate * h) * (drive - rate * v)


class Propagation(NamedTuple):
    """(x3, x4)(t) = F (x3, x4)(t-) + g over one interval."""

    F: Matrix
    g: Vector
    unit: Vector = Vector(0.0, 0.0)  # the g of a forcing (0, 1), constant over the interval


def propagation(xp, a0: Matrix, a1: Matrix, forcing0, forcing1, h) -> Propagation:
    """x' = A(t) x + (0, b(t)) over an interval of length h, A and b linear in time between their end values.

    F = exp(h mean A); the forcing integral by Simpson's rule on exp. Second order in h, and bounded for any h.
    """
    half = exponential(xp, mean(a0, a1), h / 2)
    F = multiply(half, half)
    middle = 2 * (forcing0 + forcing1)  # Simpson's 4 times the mean
    g = Vector(
        h / 6 * (F.dq * forcing0 + half.dq * middle),
        h / 6 * (F.qq * forcing0 + half.qq * middle + forcing1),
    )
    unit = Vector(h / 6 * (F.dq + 4 * half.dq), h / 6 * (F.qq + 4 * half.qq + 1))
    return Propagation(F, g, unit)


def propagate(p: Propagation, v: Vector) -> Vector:
    w = apply(p.F, v)
    return Vector(w.d + p.g.d, w.q + p.g.q)
