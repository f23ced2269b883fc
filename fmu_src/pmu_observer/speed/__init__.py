"""The observers of the speed deviation x2 = omega from the rotor angle."""

from typing import NamedTuple

from ..interface import Scalar


class RotorCovariance(NamedTuple):
    """Of (delta, omega, P_m): d, o, p. All zero: not known."""

    dd: Scalar = 0.0
    do: Scalar = 0.0
    oo: Scalar = 0.0
    dp: Scalar = 0.0
    op: Scalar = 0.0
    pp: Scalar = 0.0


class Rotor(NamedTuple):
    """What every speed observer estimates."""

    delta: Scalar  # rad, unwrapped
    omega: Scalar = 0.0  # rad/s
    P_m: Scalar = 0.0  # pu
    covariance: RotorCovariance = RotorCovariance()
