"""The rotor, and its motion between frames: the swing equation, with what it does to a covariance."""

from typing import NamedTuple

from ..interface import Scalar
from ..linear import decay_mean
from ..machines.two_axis import Constants
from ..sampling import SEEN, Interval

ACCELERATION_WALK = 0.24
"""rad/s^2/sqrt(s) of b0 P_m: 0.005 pu/sqrt(s) for a machine of H = 4 s on its own base, at 60 Hz."""

OMEGA_WALK = 0.24
"""rad/s/sqrt(s) of omega in a gap between frames."""


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
    innovation: Scalar = 0.0  # of the last frame's angle, in standard deviations, if the speed observer knows them


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
    w = xp.where(z < 1e-3, 0.5 - z / 6, (1 - mean) / xp.maximum(z, 1e-3))  # the series is exact to 1e-7 there
    return Motion(1 - z * mean, h * mean, h * mean, h * h * w)


def motion_with_gap(xp, a0, h) -> Motion:
    """For longer than SEEN, f acts for that long only: then the rotor coasts."""

    def with_gap():
        seen, coasting = motion(xp, a0, SEEN), motion(xp, a0, h - SEEN)
        return Motion(
            seen.E * coasting.E, seen.t + seen.E * coasting.t, seen.v * coasting.E, seen.w + seen.v * coasting.t
        )

    return xp.cond(h > SEEN, with_gap, lambda: motion(xp, a0, h))


def predict(xp, c: Constants, rotor: Rotor, interval: Interval, P_m, P_m_known) -> Rotor:
    """The rotor over an interval with the mean power of its ends:

        delta' = omega,  omega' = -a0 omega + b0 (P_m - P),  P_m measured, or a random walk.

    P's noise and half its jump, at an unknown instant, move omega. Over longer than SEEN the mean says little: from
    then on the acceleration counts as an error of its own size, and omega walks.
    """
    before, after, h = interval.before.measured, interval.after.measured, interval.h
    m, P = motion_with_gap(xp, c.a0, h), rotor.covariance
    acceleration = c.b0 * (P_m - (before.P + after.P) / 2)

    # P P^T times the transition's rows
    v, w = m.v * c.b0, m.w * c.b0
    dd = P.dd + m.t * P.do + w * P.dp
    do = P.do + m.t * P.oo + w * P.op
    dp = P.dp + m.t * P.op + w * P.pp
    oo = m.E * P.oo + v * P.op
    op = m.E * P.op + v * P.pp

    S = after.tve * after.V * after.I
    jump = interval.jump.P
    wrong = c.b0 * c.b0 * (S * S + jump * jump / 4)  # of an acceleration that is wrong for the whole interval
    gap = xp.maximum(h - SEEN, 0.0)
    unseen = acceleration * gap
    drift = unseen * unseen + OMEGA_WALK * OMEGA_WALK * gap
    walk = xp.where(P_m_known, 0.0, ACCELERATION_WALK * ACCELERATION_WALK * h / xp.maximum(c.b0 * c.b0, 1e-12))
    covariance = RotorCovariance(
        dd=dd + m.t * do + w * dp + m.w * m.w * wrong + drift * gap * gap / 3,
        do=m.E * do + v * dp + m.v * m.w * wrong + drift * gap / 2,
        oo=m.E * oo + v * op + m.v * m.v * wrong + drift,
        dp=dp,
        op=op,
        pp=P.pp + walk,
    )
    return Rotor(
        rotor.delta + m.t * rotor.omega + m.w * acceleration,
        m.E * rotor.omega + m.v * acceleration,
        rotor.P_m,
        covariance,
        rotor.innovation,
    )


def balanced(xp, delta, measured, P_m_known, covariance=RotorCovariance()) -> Rotor:  # noqa: B008 - immutable
    """At synchronous speed, with an unknown P_m that balances the frame's P."""
    return Rotor(delta, 0.0, xp.where(P_m_known, measured.P_m, measured.P), covariance)
