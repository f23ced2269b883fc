"""The rotor angle that belongs to an estimate of (E'd, E'q)."""

from math import pi
from typing import NamedTuple

from .interface import Scalar
from .linear import Vector
from .phasors import Signals


class Estimate(NamedTuple):
    delta: Scalar  # rad, unwrapped
    x: Vector  # (E'd, E'q), pu


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
