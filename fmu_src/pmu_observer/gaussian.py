"""One Kalman filter of (E'd, E'q, E_f), linear but for its measurement Y1 = E'd^2 + E'q^2.

    (x3, x4)+ = F (x3, x4) + g + G E_f,   E_f+ = E_f + random walk        (G = 0 and E_f given where E_f is measured)

F is exact for the mean A of the interval. A itself is measured, so that its noise, and what it does between the frames
when the network jumps, are process noise; nothing else is, and there is nothing to tune.
"""

from typing import NamedTuple

from . import noise
from .angle import Covariance
from .interface import Scalar
from .linear import Complex, Matrix, Vector, decay_mean, dot
from .machines.two_axis import Constants
from .phasors import Signals
from .sampling import SEEN, Interval

UNSEEN_NU = 0.002
"""1/s/sqrt(s): how fast nu may change in a gap between frames, besides what the frames at its ends show: load changes
of some percent."""

WILD = 9.0
"""Squared standard deviations beyond which a residual moves the estimate no further."""

UNLIKELY = 16.0
"""Squared standard deviations beyond which a residual makes a hypothesis no less likely: gross errors have no wells."""


class Gaussian(NamedTuple):
    x: Vector  # (E'd, E'q), pu
    E_f: Scalar  # pu
    P: Covariance


class Transition(NamedTuple):
    """What an interval does to every Gaussian."""

    F: Matrix
    g: Vector
    G: Vector
    Q: Vector  # variances that the noise of A adds, pu^2
    jump: Complex  # of nu, times h/2: A is wrong by that for half the interval
    common: Complex  # E[dnu dY1], pu^2, times h: what the frame's noise does to A, it does to Y1 too
    b: Vector  # b2, b1, 1/s, less what decays within the interval
    E_f: Scalar  # pu, measured
    E_f_known: Scalar


class Circle(NamedTuple):
    """What a frame says of (E'd, E'q): how far it is from zero."""

    Y1: Scalar  # pu^2, less the mean of its error
    R: Scalar  # pu^4, variance of that error


def circle_of(c: Constants, s: Signals) -> Circle:
    s2, R = noise.of_Y1(c, s)
    return Circle(s.Y1 - s2, R)


class Updated(NamedTuple):
    gaussian: Gaussian
    innovation: Scalar  # in standard deviations
    log_likelihood: Scalar


def transition(xp, c: Constants, interval: Interval) -> Transition:
    """What an interval does.

    E|dnu|^2 = v adds the variance (h b2)^2 v Y1/2 to E'd and (h b1)^2 v Y1/2 to E'q, less what decays within the
    interval; without it the filter is sure of itself and wrong. In a gap, nu moves unseen by UNSEEN_NU t sqrt(dt).
    """
    h, s, flow = interval.h, interval.after, interval.flow
    variance = h * h * noise.of_nu(s) * s.Y1 / 2
    gap = xp.maximum(h - SEEN, 0.0)
    in_gap = UNSEEN_NU * UNSEEN_NU * gap * gap * gap / 3 * s.Y1

    b = Vector(
        c.b2 * decay_mean(xp, xp.maximum(-s.A.dd, 0.0) * h),
        c.b1 * decay_mean(xp, xp.maximum(-s.A.qq, 0.0) * h),
    )
    common = noise.of_nu_and_Y1(s)
    known = s.measured.E_f_known > 0
    forcing_error = c.c1 * h / 2 * interval.jump.E_f
    return Transition(
        F=flow.F,
        g=Vector(xp.where(known, flow.g.d, 0.0), xp.where(known, flow.g.q, 0.0)),
        G=Vector(xp.where(known, 0.0, c.c1 * flow.unit.d), xp.where(known, 0.0, c.c1 * flow.unit.q)),
        Q=Vector(
            b.d * b.d * (variance + in_gap),
            b.q * b.q * (variance + in_gap) + forcing_error * forcing_error,
        ),
        jump=Complex(h / 2 * interval.jump.nu.re, h / 2 * interval.jump.nu.im),
        common=Complex(h * common.re, h * common.im),
        b=b,
        E_f=s.measured.E_f,
        E_f_known=s.measured.E_f_known,
    )


def by_nu(t: Transition, dnu: Complex, x: Vector) -> Vector:
    """What an error dnu of nu, times the time it lasts, does to x: (b2 Re, -b1 Im)(dnu conj(x3 + j x4))."""
    (b_d, b_q), (re, im), (d, q) = t.b, dnu, x
    return Vector(b_d * (re * d + im * q), b_q * (re * q - im * d))


def predict(xp, t: Transition, v: Gaussian, walk) -> Gaussian:
    """x+ = F x + g + G E_f,  P+ = [F G; 0 1] P [F G; 0 1]^T + Q + n n^T;  `walk` is the variance that E_f adds, pu^2.

    n is what a jump of nu at an unknown instant does.
    """
    (F_dd, F_dq, F_qd, F_qq), (g_d, g_q), (G_d, G_q), (Q_d, Q_q), *_ = t
    (x_d, x_q), E_f, (P_dd, P_dq, P_qq, P_df, P_qf, P_ff) = v
    x = Vector(F_dd * x_d + F_dq * x_q + g_d + G_d * E_f, F_qd * x_d + F_qq * x_q + g_q + G_q * E_f)
    # [F G] P
    dd = F_dd * P_dd + F_dq * P_dq + G_d * P_df
    dq = F_dd * P_dq + F_dq * P_qq + G_d * P_qf
    df = F_dd * P_df + F_dq * P_qf + G_d * P_ff
    qd = F_qd * P_dd + F_qq * P_dq + G_q * P_df
    qq = F_qd * P_dq + F_qq * P_qq + G_q * P_qf
    qf = F_qd * P_df + F_qq * P_qf + G_q * P_ff
    n_d, n_q = by_nu(t, t.jump, v.x)
    covariance = Covariance(
        dd * F_dd + dq * F_dq + df * G_d + Q_d + n_d * n_d,
        dd * F_qd + dq * F_qq + df * G_q + n_d * n_q,
        qd * F_qd + qq * F_qq + qf * G_q + Q_q + n_q * n_q,
        df,
        qf,
        P_ff + walk,
    )
    return Gaussian(x, xp.where(t.E_f_known > 0, t.E_f, E_f), covariance)


def turn_variance(t: Transition, before: Gaussian, after: Gaussian):
    """Of the change of the error of arg(x3 + j x4) over an interval, rad^2.

    That of x changes by (F - I), by Q and by a jump of nu, n.
    """
    v, w, n = across(before.x), across(after.x), by_nu(t, t.jump, before.x)
    e = Vector(w.d * t.F.dd + w.q * t.F.qd - v.d, w.d * t.F.dq + w.q * t.F.qq - v.q)
    P, turned = before.P, dot(w, n)
    own = e.d * e.d * P.dd + 2 * e.d * e.q * P.dq + e.q * e.q * P.qq
    return own + w.d * w.d * t.Q.d + w.q * w.q * t.Q.q + turned * turned


def across(x: Vector) -> Vector:
    """The gradient of arg(x3 + j x4)."""
    r2 = x.d * x.d + x.q * x.q + 1e-12
    return Vector(-x.q / r2, x.d / r2)


def update(xp, t: Transition, v: Gaussian, circle: Circle) -> Updated:
    """With a frame, to second order in the error of x:

    r = Y1 - |x|^2 - tr P,   S = H P H^T - 2 H C + 2 tr P^2 + R,   H = 2 x^T,   K = (P H^T - C)/max(S, r^2/WILD)

    C is the covariance of the errors of x and Y1: the frame at the end of the interval went into A, by half for this
    interval and by half for the next one.
    """
    (d, q), E_f, (dd, dq, qq, df, qf, ff) = v
    Y1, R = circle
    C_d, C_q = by_nu(t, t.common, v.x)
    # P H^T - C
    hd = 2 * (d * dd + q * dq) - C_d
    hq = 2 * (d * dq + q * qq) - C_q
    hf = 2 * (d * df + q * qf)
    r = Y1 - d * d - q * q - dd - qq
    S = 2 * (d * (hd - C_d) + q * (hq - C_q) + dd * dd + 2 * dq * dq + qq * qq) + R
    S = xp.maximum(S, R / 10)  # x far off the circle
    normalised2 = r * r / S
    weight = 1 / (S * xp.maximum(normalised2 / WILD, 1.0))
    kd, kq, kf = weight * hd, weight * hq, weight * hf
    P = Covariance(dd - kd * hd, dq - kd * hq, qq - kq * hq, df - kd * hf, qf - kq * hf, ff - kf * hf)
    return Updated(
        Gaussian(Vector(d + kd * r, q + kq * r), E_f + kf * r, P),
        r / xp.sqrt(S),
        -(xp.log(S) + xp.minimum(normalised2, UNLIKELY)) / 2,
    )
