"""Kalman filter of (delta, omega, P_m): its gain follows from the noise.

    delta' = omega,  omega' = -a0 omega + b0 (P_m - P),  P_m measured, or a random walk

Measured are P, whose noise moves omega, and the angle of j E' less that of (E'd, E'q). The error of the latter is no
noise: it stays, changes a little by itself, and turns with what the estimator corrects. So delta here is the rotor
angle plus that error; a correction turns it at once and leaves omega alone.
"""

from typing import NamedTuple

from .. import noise
from ..angle import Estimate, unwrap
from ..interface import Scalar
from ..linear import decay_mean
from ..machines.two_axis import Constants
from ..phasors import Signals
from ..sampling import Interval
from . import Rotor, RotorCovariance

ACCELERATION_WALK = 0.24
"""rad/s^2/sqrt(s) of b0 P_m: 0.005 pu/sqrt(s) for a machine of H = 4 s on its own base, at 60 Hz."""

OMEGA_WALK = 0.24
"""rad/s/sqrt(s) of omega while frames are held over."""

ACCELERATION_START = 14.0
"""rad/s^2, standard deviation of b0 (P_m - P) at the first frame: 0.3 pu for the same machine."""

OMEGA_START = 3.0
"""rad/s, standard deviation of omega at the first frame."""


def start(xp, c: Constants, s: Signals, estimate: Estimate, P_m_known) -> Rotor:
    """The estimator's angle, synchronous speed, and an unknown P_m that balances the first frame's P."""
    m, deviation = s.measured, ACCELERATION_START / c.b0
    covariance = RotorCovariance(
        dd=angle_variance(c, s),
        oo=OMEGA_START * OMEGA_START,
        pp=xp.where(P_m_known, 0.0, deviation * deviation),
    )
    return Rotor(estimate.delta, 0.0, xp.where(P_m_known, m.P_m, m.P), covariance)


def angle_variance(c: Constants, s: Signals):
    """Of arg(j E'), rad^2: E|n|^2/(2 Y1)."""
    return noise.of_phasor(c, s) / (2 * s.Y1)


SURPRISE = 25.0
"""Squared standard deviations beyond which a residual is not noise."""


class Motion(NamedTuple):
    """delta+ = delta + t omega + w f,  omega+ = E omega + v f,  f = b0 (P_m - P) constant."""

    E: Scalar
    t: Scalar  # s
    v: Scalar  # s
    w: Scalar  # s^2


def motion(xp, a0, h) -> Motion:
    """E = e^-z, t = v = h (1 - e^-z)/z, w = h^2 (z - 1 + e^-z)/z^2,  z = a0 h."""
    z = a0 * h
    mean = decay_mean(xp, z)
    w = xp.where(z < 1e-3, 0.5 - z / 6, (1 - mean) / xp.maximum(z, 1e-3))
    return Motion(1 - z * mean, h * mean, h * mean, h * h * w)


def step(xp, c: Constants, rotor: Rotor, interval: Interval, estimate: Estimate, P_m_known) -> Rotor:
    """Over an interval, and on to the estimator's angle at its end; while frames are held over, omega stays."""
    before, after = interval.before.measured, interval.after.measured
    held = after.held > 0
    P_m = xp.where(P_m_known, (before.P_m + after.P_m) / 2, rotor.P_m)
    moved = predict(xp, c, rotor, interval, P_m, P_m_known)
    dd, *others = moved.covariance
    turned = RotorCovariance(dd + estimate.turn_variance, *others)
    predicted = Rotor(moved.delta - estimate.turn, moved.omega, moved.P_m, turned)
    variance = angle_variance(c, interval.after)
    corrected = xp.cond(held, lambda: predicted, lambda: update(xp, predicted, estimate.delta, variance))
    return corrected._replace(P_m=xp.where(P_m_known, after.P_m, corrected.P_m))


def predict(xp, c: Constants, rotor: Rotor, interval: Interval, P_m, P_m_known) -> Rotor:
    before, after, h = interval.before.measured, interval.after.measured, interval.h
    held = after.held > 0
    a0, b0 = xp.where(held, 0.0, c.a0), xp.where(held, 0.0, c.b0)
    m, P = motion(xp, a0, h), rotor.covariance
    acceleration = c.b0 * (P_m - (before.P + after.P) / 2)
    f = xp.where(held, 0.0, acceleration)

    # P P^T times the transition's rows
    v, w = m.v * b0, m.w * b0
    dd = P.dd + m.t * P.do + w * P.dp
    do = P.do + m.t * P.oo + w * P.op
    dp = P.dp + m.t * P.op + w * P.pp
    oo = m.E * P.oo + v * P.op
    op = m.E * P.op + v * P.pp

    S = after.tve * after.V * after.I
    jump = interval.jump.P
    # of an acceleration that is wrong for the whole interval; while frames are held it is left out
    wrong = xp.where(held, acceleration * acceleration, b0 * b0 * (S * S + jump * jump / 4))
    drift = xp.where(held, OMEGA_WALK * OMEGA_WALK * h, 0.0)
    walk = xp.where(P_m_known, 0.0, ACCELERATION_WALK * ACCELERATION_WALK * h / xp.maximum(c.b0 * c.b0, 1e-12))
    covariance = RotorCovariance(
        dd=dd + m.t * do + w * dp + m.w * m.w * wrong,
        do=m.E * do + v * dp + m.v * m.w * wrong,
        oo=m.E * oo + v * op + m.v * m.v * wrong + drift,
        dp=dp,
        op=op,
        pp=P.pp + walk,
    )
    return Rotor(rotor.delta + m.t * rotor.omega + m.w * f, m.E * rotor.omega + m.v * f, rotor.P_m, covariance)


def update(xp, rotor: Rotor, angle, variance) -> Rotor:
    """With the angle and its variance: K = P H^T/S, H = (1, 0, 0).

    A residual beyond 5 standard deviations says that P is too small: P grows until they are 5.
    """
    e = unwrap(xp, angle - rotor.delta, 0.0)
    before = rotor.covariance
    wider = xp.maximum((e * e / SURPRISE - variance) / xp.maximum(before.dd, 1e-30), 1.0)
    P = RotorCovariance(*[wider * v for v in before])
    S = P.dd + variance
    kd, ko, kp = P.dd / S, P.do / S, P.dp / S
    covariance = RotorCovariance(
        dd=P.dd - kd * P.dd,
        do=P.do - kd * P.do,
        oo=P.oo - ko * P.do,
        dp=P.dp - kd * P.dp,
        op=P.op - ko * P.dp,
        pp=P.pp - kp * P.dp,
    )
    return Rotor(rotor.delta + kd * e, rotor.omega + ko * e, rotor.P_m + kp * e, covariance)
