"""Which frames to believe: not those that are marked invalid, broken, repeated, or grossly wrong."""

from . import noise
from .angle import Estimate
from .linear import propagate
from .machines.two_axis import Constants
from .phasors import LOWEST_VOLTAGE, Frame, is_finite
from .sampling import Interval
from .speed import Rotor

STILL = 1e-4
"""rad, the resolution of a PMU's angles: a rotor that turns less may well give the same frame again."""

LONGEST_REPEAT = 1.0
"""s for which a repeated frame is held over; then it is believed: the estimated speed is wrong."""

GROSS = 25.0
"""Squared standard deviations beyond which a frame is a gross error."""

MOST_REJECTED, FORGIVEN = 2, 0.25
"""Gross errors in a row; the next one is believed: then it is the estimate that is wrong. So it is where more than one
frame in five is rejected: a good frame makes up for a quarter of a gross one."""


def is_usable(xp, frame: Frame, machine_inputs, valid):
    """Marked valid, finite, and with a voltage."""
    usable = xp.logical_and(is_finite(xp, [*frame, *machine_inputs]), frame.V_t > LOWEST_VOLTAGE)
    return xp.logical_and(usable, valid > 0)


def is_same(xp, frame: Frame, last: Frame):
    same = frame[0] == last[0]
    for value, last_value in zip(frame[1:], last[1:]):
        same = xp.logical_and(same, value == last_value)
    return same


def is_gross(xp, c: Constants, interval: Interval, estimate: Estimate, rotor: Rotor):
    """Is j E' of the frame that closes the interval more than 5 standard deviations from where it is expected?

    That is e^{j delta}(x3 + j x4), which no event in the network can make jump. Half the jump of A and of P over the
    interval is allowed for; so are 0.2 % of what the model does not know. Only where both estimator and speed observer
    say how sure they are: I&I does not, and rejecting what contradicts it would leave it wrong.
    """
    s, h, P, R = interval.after, interval.h, estimate.covariance, rotor.covariance
    x = propagate(interval.flow, estimate.x)
    acceleration = c.b0 * (rotor.P_m - (interval.before.measured.P + s.measured.P) / 2)
    delta = rotor.delta + h * (rotor.omega + h / 2 * acceleration)
    cos, sin = xp.cos(delta), xp.sin(delta)
    re, im = s.Y2 - (cos * x.d - sin * x.q), s.Y3 - (sin * x.d + cos * x.q)
    b = xp.maximum(c.b1, c.b2) * h / 2
    jump = interval.jump.nu
    jump_variance = b * b * (jump.re * jump.re + jump.im * jump.im) * s.Y1
    wrong = c.b0 * h * h / 4 * interval.jump.P
    angle_variance = R.dd + h * h * R.oo + wrong * wrong
    variance = noise.of_phasor(c, s) + 2 * (P.dd + P.qq + s.Y1 * angle_variance) + jump_variance + 4e-6 * s.Y1
    sure = xp.logical_and(estimate.capturing < 0.5, xp.logical_and(P.dd > 0, R.dd > 0))
    return xp.logical_and(sure, re * re + im * im > GROSS * variance)
