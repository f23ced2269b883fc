"""One Kalman filter of (z, E_f) under any machine model, linear but for its measurement Y1 = |f|^2, f = C z.

    z+ = F z + G E_f + g,   E_f+ = E_f + random walk             (E_f given where it is measured)

F is exact for the mean A of the interval.
"""

from typing import NamedTuple

from . import noise
from .angle import Covariance
from .interface import Scalar
from .linear import Vector
from .matrix import Column, Rows, Symmetric, apply, dot, full, outer, place
from .phasors import Signals
from .transition import Transition

WILD = 9.0
"""Squared standard deviations beyond which a residual moves the estimate no further."""

UNLIKELY = 16.0
"""Squared standard deviations beyond which a residual makes a hypothesis no less likely: gross errors have no wells."""


class Gaussian(NamedTuple):
    x: Column  # (z, E_f), pu
    P: Symmetric  # its covariance, pu^2


class Circle(NamedTuple):
    """What a frame says of f: how far it is from zero."""

    Y1: Scalar  # pu^2, less the mean of its error
    R: Scalar  # pu^4, variance of that error


def circle_of(s: Signals) -> Circle:
    s2, R = noise.of_Y1(s)
    return Circle(s.Y1 - s2, R)


class Updated(NamedTuple):
    gaussian: Gaussian
    r: Scalar  # pu^2, residual
    S: Scalar  # pu^4, its variance


def innovation(xp, u: Updated):
    """The residual in standard deviations."""
    return u.r / xp.sqrt(u.S)


def log_likelihood(xp, u: Updated):
    return -(xp.log(u.S) + xp.minimum(u.r * u.r / u.S, UNLIKELY)) / 2


def flux(c, C: Rows, x: Column) -> Vector:
    """f = C (z[0] of d, z[0] of q)."""
    at = x[0], x[c.model.D_STATES]
    return Vector(*apply(C, at)) if c.model.SALIENT else Vector(*at)


def flux_covariance(c, C: Rows, v: Gaussian) -> Covariance:
    """Of f."""
    n, q = len(v.x), c.model.D_STATES
    dd, dq, qq = v.P[0], v.P[place(0, q, n)], v.P[place(q, q, n)]
    if not c.model.SALIENT:
        return Covariance(dd, dq, qq)
    (a, b), (e, g) = C
    return Covariance(
        dd=a * (a * dd + 2 * b * dq) + b * b * qq,
        dq=a * (e * dd + g * dq) + b * (e * dq + g * qq),
        qq=e * (e * dd + 2 * g * dq) + g * g * qq,
    )


def expected(xp, c, t: Transition, x: Column) -> Column:
    """z+ = F z + G E_f + g; gensal's field loses what its iron takes, at the E'q of each estimate."""
    known = t.E_f_known > 0
    E_f = xp.where(known, t.E_f, x[-1])
    if c.model.field_of_saturation:
        taken = c.model.field_of_saturation(xp, *t.iron, x[-2])
        E_f = E_f - xp.where(known, taken, 0.0)
    z = x[:-1]
    return tuple([dot(row, z) + by_field * E_f + g for row, by_field, g in zip(t.F, t.G, t.g)])


def process_noise(t: Transition, before: Vector, after: Vector) -> Symmetric:
    """Q + n n' + m m' + (a a' - b b')/R: what the interval adds to the covariance of z.

    n and m: a jump of kappa at an unknown instant, taken half way, and when it really is. a = `common` f is what z's
    error has in common with that of Y1, b its part by kappa, which Q holds; S is a function of Y1.
    """
    f_before, f = tuple(before), tuple(after)
    n, m = outer(apply(t.jump, f_before)), outer(apply(t.when, f_before))
    a, b = outer(apply(t.common, f)), outer(apply(t.by_kappa, f))
    return tuple([Q + x + y + t.per_R * (z - w) for Q, x, y, z, w in zip(t.Q, n, m, a, b)])


def predict(xp, c, t: Transition, v: Gaussian, walk) -> Gaussian:
    """x+ and P+ = [F G; 0 1] P [F G; 0 1]^T + process noise; `walk` is the variance that E_f adds, pu^2."""
    x, n = v.x, len(t.F)
    z = expected(xp, c, t, x)
    added = process_noise(t, flux(c, t.C_before, x), flux(c, t.C, z))
    whole = [(*row, by_field) for row, by_field in zip(t.F, t.G)]
    P = full(v.P, n + 1)
    FP = [[dot(row, column) for column in P] for row in whole]
    covariance, k = [], 0
    for i in range(n):
        for j in range(i, n):
            covariance.append(dot(FP[i], whole[j]) + added[k])
            k += 1
        covariance.append(FP[i][n])
    covariance.append(P[n][n] + walk)
    return Gaussian((*z, xp.where(t.E_f_known > 0, t.E_f, x[n])), tuple(covariance))


def turn_variance(c, t: Transition, before: Gaussian, after: Gaussian):
    """Of the change of the error of arg f over an interval, rad^2: that of z changes by F - 1, and by process noise."""
    n = len(t.F)
    f0, f1 = flux(c, t.C_before, before.x), flux(c, t.C, after.x)
    v, w = across(c, t.C_before, f0, n), across(c, t.C, f1, n)
    moved = [dot(w, column) for column in zip(*t.F)]
    e = [x - y for x, y in zip(moved, v)] + [dot(w, t.G)]
    own = dot(e, apply(full(before.P, n + 1), e))
    return own + dot(w, apply(full(process_noise(t, f0, f1), n), w))


def across(c, C: Rows, f: Vector, n: int) -> Column:
    """The gradient of arg f by z."""
    r2 = f.d * f.d + f.q * f.q + 1e-12
    d, q = -f.q / r2, f.d / r2
    if c.model.SALIENT:
        d, q = d * C[0][0] + q * C[1][0], d * C[0][1] + q * C[1][1]
    gradient = [0.0] * n
    gradient[0], gradient[c.model.D_STATES] = d, q
    return tuple(gradient)


def update(xp, c, t: Transition, v: Gaussian, circle: Circle) -> Updated:
    """With a frame, to second order in the error of f:

    r = Y1 - |f|^2 - tr Pf,  S = H P H^T - 2 H a + 2 tr Pf^2 + R,  H = 2 f^T C,  K = (P H^T - a)/max(S, r^2/WILD)

    Pf is the covariance of f, a that of the errors of z and Y1: the frame at the end of the interval went into A, by
    half for this interval and by half for the next one. Where C is measured too, its noise counts with that of Y1.
    """
    x, n, q = v.x, len(t.F), c.model.D_STATES
    P, f = full(v.P, n + 1), flux(c, t.C, v.x)
    dd, dq, qq, *_ = flux_covariance(c, t.C, v)
    a, R, H = apply(t.common, f), circle.R, Vector(2 * f.d, 2 * f.q)
    if c.model.SALIENT:
        o = t.output
        # |C z|^2 is off by (i_d, i_q) (dkappa f), which has a variance and something in common with Y1 and z
        i_d, i_q = H.d * o.CX[0][0] + H.q * o.CX[1][0], H.d * o.CX[0][1] + H.q * o.CX[1][1]
        re, im = o.common.re * f.d - o.common.im * f.q, o.common.im * f.d + o.common.re * f.q
        R = xp.maximum(R + o.variance * (i_d * i_d + i_q * i_q) - 2 * (i_d * re + i_q * im), LEAST_R * R)
        a = tuple([y - o.variance * (i_d * d + i_q * q) for y, d, q in zip(a, o.u_d, o.u_q)])
        H = Vector(H.d * t.C[0][0] + H.q * t.C[1][0], H.d * t.C[0][1] + H.q * t.C[1][1])
    PH = [H.d * row[0] + H.q * row[q] for row in P]
    gain = [y - z for y, z in zip(PH, a)] + PH[n:]
    r = circle.Y1 - f.d * f.d - f.q * f.q - dd - qq
    S = H.d * (gain[0] - a[0]) + H.q * (gain[q] - a[q]) + 2 * (dd * dd + 2 * dq * dq + qq * qq) + R
    S = xp.maximum(S, R / 10)  # f far off the circle
    weight = 1 / (S * xp.maximum(r * r / S / WILD, 1.0))
    K = [weight * y for y in gain]
    covariance = [P[i][j] - K[i] * gain[j] for i in range(n + 1) for j in range(i, n + 1)]
    return Updated(Gaussian(tuple([y + k * r for y, k in zip(x, K)]), tuple(covariance)), r, S)


LEAST_R = 1e-2
"""Of the variance of Y1: what is left of it at least, where the noise of C and that of Y1 cancel to first order."""
