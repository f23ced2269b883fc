"""Kalman filter of (delta, omega, P_m): its gain follows from the noise.

Measured are P, whose noise moves omega (see `rotor`), and the angle of j E' less that of (E'd, E'q). The error of the
latter is no noise: it stays, changes a little by itself, and turns with what the estimator corrects. So delta here is
the rotor angle plus that error; a correction turns it at once and leaves omega alone.
"""

from typing import NamedTuple

from .. import noise
from ..angle import Estimate, unwrap
from ..machines.two_axis import Constants
from ..phasors import Signals
from ..sampling import Interval
from . import rotor as swing
from .rotor import Rotor, RotorCovariance

ACCELERATION_START = 14.0
"""rad/s^2, standard deviation of b0 (P_m - P) at the first frame: 0.3 pu for a machine of H = 4 s on its own base."""

OMEGA_START = 3.0
"""rad/s, standard deviation of omega at the first frame."""

SURPRISE = 25.0
"""Squared standard deviations beyond which a residual is not noise."""


class Parameters(NamedTuple):
    pass


class Outputs(NamedTuple):
    pass


def start(xp, c: Constants, s: Signals, estimate: Estimate, settings):
    """The estimator's angle, synchronous speed, and an unknown P_m that balances the first frame's P."""
    deviation = ACCELERATION_START / c.b0
    covariance = RotorCovariance(
        dd=angle_variance(s),
        oo=OMEGA_START * OMEGA_START,
        pp=xp.where(settings.P_m_known, 0.0, deviation * deviation),
    )
    return swing.balanced(xp, estimate.delta, s.measured, settings.P_m_known, covariance), ()


def angle_variance(s: Signals):
    """Of arg(j E'), rad^2: E|n|^2/(2 Y1)."""
    return noise.of_phasor(s) / (2 * s.Y1)


def step(xp, p, c: Constants, rotor: Rotor, own, interval: Interval, estimate: Estimate, settings):
    """Over an interval, and on to the estimator's angle at its end."""
    before, after = interval.before.measured, interval.after.measured
    P_m = xp.where(settings.P_m_known, (before.P_m + after.P_m) / 2, rotor.P_m)
    moved = swing.predict(xp, c, rotor, interval, P_m, settings.P_m_known)
    dd, *others = moved.covariance
    turned = moved._replace(
        delta=moved.delta - estimate.turn, covariance=RotorCovariance(dd + estimate.turn_variance, *others)
    )
    updated = update(xp, turned, estimate.delta, angle_variance(interval.after))
    return updated._replace(P_m=xp.where(settings.P_m_known, after.P_m, updated.P_m)), own


def update(xp, rotor: Rotor, angle, variance) -> Rotor:
    """With the angle and its variance: K = P H^T/S, H = (1, 0, 0).

    A residual beyond 5 standard deviations says that P is too small: P grows until they are 5.
    """
    e = unwrap(xp, angle - rotor.delta, 0.0)
    before = rotor.covariance
    innovation = e / xp.sqrt(before.dd + variance)
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
    return Rotor(rotor.delta + kd * e, rotor.omega + ko * e, rotor.P_m + kp * e, covariance, innovation)


def constants(c: Constants, own) -> Constants:
    return c


def outputs(xp, own):
    return Outputs()
