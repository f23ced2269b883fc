"""The rotor angle that belongs to an estimate of the voltage F in the rotor's frame: of (E'd, E'q) in the paper."""

from math import pi
from typing import Any, NamedTuple

from .interface import Scalar
from .linear import Vector
from .phasors import Signals


class Covariance(NamedTuple):
    """Of x, pu^2; all zero: the estimator does not know how far it is off."""

    dd: Scalar = 0.0
    dq: Scalar = 0.0
    qq: Scalar = 0.0


class Estimate(NamedTuple):
    """What an estimator makes of the frames so far; those of the paper leave all but delta and x at the defaults."""

    delta: Scalar  # rad, unwrapped
    x: Vector  # the rotor's view of F, pu: (E'd, E'q) for the paper's estimators
    covariance: Covariance = Covariance()
    gaussian: Any = ()  # of the machine model's own states, if the estimator works with any
    E_f: Scalar = 0.0  # pu, if the estimator has one
    E_f_walk: Scalar = 0.0  # pu^2/s, the variance that an estimated E_f gains
    innovation: Scalar = 0.0  # of the last frame, in standard deviations
    capturing: Scalar = 0.0  # 1 while several values of x are still possible
    turn: Scalar = 0.0  # rad, by which the last frame corrected the direction of x
    turn_variance: Scalar = 0.0  # rad^2, of how the error of that direction changed by itself since the frame before


def direction_variance(x: Vector, covariance: Covariance):
    """Of arg(x3 + j x4), rad^2."""
    r2 = x.d * x.d + x.q * x.q + 1e-12
    across = x.q * x.q * covariance.dd - 2 * x.d * x.q * covariance.dq + x.d * x.d * covariance.qq
    return across / (r2 * r2)


def rotor_angle(xp, s: Signals, x: Vector, near) -> Estimate:
    """x1 = atan2(x3 Y3 - x4 Y2, x3 Y2 + x4 Y3), rad: the angle of (Y2, Y3) less that of (x3, x4).

    Of all x1 + 2 k pi, the one nearest to `near`. The paper's arcsin fails beyond +-pi/2, which an absolute angle
    leaves in 12.5 s at 20 mHz. An estimate of zero has no angle: E_f drives it along q, so that q is its limit.
    """
    q = xp.where(xp.logical_and(x.d == 0, x.q == 0), 1.0, x.q)
    x1 = xp.atan2(x.d * s.Y3 - q * s.Y2, x.d * s.Y2 + q * s.Y3)
    return Estimate(unwrap(xp, x1, near), x)


def unwrap(xp, angle, near):
    """Of all angle + 2 k pi, rad, the one nearest to `near`."""
    return angle + 2 * pi * xp.floor((near - angle) / (2 * pi) + 0.5)
