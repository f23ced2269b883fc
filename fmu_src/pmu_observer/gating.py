"""Which frame to take, and how long after the one before: not those that are marked invalid, broken, repeated, too old,
or grossly wrong.

A frame carries the time at which it was measured, or is dated with its arrival, and is taken when it is new.
"""

from typing import NamedTuple

from . import gaussian, noise
from .angle import Estimate
from .interface import Scalar
from .linear import Vector, propagate
from .machines.two_axis import Constants
from .observer_interface import MEASURED, PHASORS, STAMPED, Inputs, Parameters, system_base, system_transformer
from .phasors import (
    LOWEST_VOLTAGE,
    Frame,
    Signals,
    is_consistent,
    is_finite,
    measurement,
    power_mismatch,
    signals,
)
from .sampling import Interval
from .speed.rotor import Rotor, predict
from .terminal import at_machine, behind_impedance

STILL = 1e-4
"""rad, the resolution of a PMU's angles: a rotor that turns less may well give the same frame again."""

LONGEST_REPEAT = 1.0
"""s for which a repeated frame is no new one; then it is believed: the estimated speed is wrong."""

EARLY, LATE, OVERDUE = 0.95, 1.05, 1.5
"""Of a frame period, after the last frame: when the next one is expected, and from when on it is missing."""

PERIOD_STEP = 1.03
"""Factor by which a new interval moves the learnt frame period, and how far it may be from it without doing so: the
period is the median of the intervals, so that neither jitter nor lost frames move it."""

SHORTEST = 1e-5
"""s; between two stamps of one frame, where it is rounded."""

OLDEST, CLOCK_ERROR = 10.0, 0.01
"""s; a stamp farther in the past, or ahead of the end of the step, is of another clock."""

GROSS = 25.0
"""Squared standard deviations beyond which a frame is a gross error."""

UNMODELLED = 2e-3
"""Of |E'|: what the model does not know of where it is."""

MOST_REJECTED, FORGIVEN = 2, 0.25
"""Gross errors in a row; the next one is believed: then it is the estimate that is wrong. So it is where more than one
frame in five is rejected: a good frame makes up for a quarter of a gross one."""


class Received(NamedTuple):
    """What has come at a communication point: numbers that can be calculated with, whatever it was."""

    signals: Signals
    frame: Frame  # only the fields that are used, 0 for the others
    usable: Scalar  # 1, or 0 where it was no frame to calculate with
    complete: Scalar  # 1, or 0 where P_m or E_f was missing, and is the last one
    power_mismatch: Scalar  # see phasors


class Gate(NamedTuple):
    """What is remembered of the frames that have come."""

    frame: Frame = Frame()  # the last usable one
    t_frame: Scalar = 0.0  # its time stamp, s
    unchanged: Scalar = 0.0  # s, since it came
    period: Scalar = 0.0  # s, learnt from those that differed; 0: there was none yet
    rejected: Scalar = 0.0  # gross errors of late
    held: Scalar = 0.0  # 1 where the last thing that came was not believed


class Timing(NamedTuple):
    """When a frame was measured."""

    h: Scalar  # s after the last one that was taken
    latency: Scalar  # s before the communication point at which it came
    new: Scalar  # 1 if it is not the last one again
    doubtful: Scalar  # 1 where it is the last one again, believed for want of another


def receive(
    xp, p: Parameters, c: Constants, inputs: Inputs, t, h, started, last: Signals, estimate: Estimate, rotor: Rotor, tve
) -> Received:
    """The inputs at t, before a step of h; `tve` is the noise, and the others are of the last frame, if started."""
    from_phasors = p.power_source == PHASORS
    V, theta, I, phi, P, Q = inputs.frame  # noqa: E741 - the paper's name
    P, Q = xp.where(from_phasors, 0.0, P), xp.where(from_phasors, 0.0, Q)
    phi_came = is_finite(xp, (phi,))
    usable = xp.logical_and(is_finite(xp, (V, theta, I, P, Q)), V > LOWEST_VOLTAGE)
    usable = xp.logical_and(usable, xp.logical_or(phi_came, xp.logical_not(from_phasors)))
    usable = xp.logical_and(usable, inputs.frame_valid > 0)
    usable = xp.logical_and(usable, is_of_this_clock(xp, p, inputs, t, h))

    P_m, P_m_came = given(xp, p.mechanical_power == MEASURED, inputs.P_m, last.measured.P_m, rotor.P_m)
    E_f, E_f_came = given(xp, p.field_voltage == MEASURED, inputs.E_f, last.measured.E_f, estimate.E_f)
    complete = xp.logical_and(P_m_came, E_f_came)
    usable = xp.logical_and(usable, xp.logical_or(complete, started))

    ones = Frame(1.0, 1.0, 1.0, 1.0, 1.0, 1.0)  # math.cos(inf) raises
    frame = xp.cond(usable, lambda: Frame(V, theta, I, xp.where(phi_came, phi, 0.0), P, Q), lambda: ones)
    at_pmu = measurement(xp, frame, P_m, E_f, from_phasors)._replace(
        tve=tve, E_f_known=xp.where(p.field_voltage == MEASURED, 1.0, 0.0)
    )
    at_terminal = at_machine(xp, at_pmu, system_transformer(p))
    s = signals(xp, c, behind_impedance(xp, at_terminal, system_base(p).Ra, 0.0))
    return Received(
        signals=s,
        frame=frame,
        usable=xp.where(xp.logical_and(usable, is_consistent(xp, c, s)), 1.0, 0.0),
        complete=xp.where(complete, 1.0, 0.0),
        power_mismatch=xp.where(phi_came, power_mismatch(xp, c, frame, at_pmu), 0.0),
    )


def given(xp, measured, value, last, estimated):
    """A machine input: the value, or the last one where it is missing, or the estimated one; and is it not missing?"""
    finite = is_finite(xp, (value,))
    came = xp.logical_or(finite, xp.logical_not(measured))
    return xp.where(measured, xp.where(finite, value, last), estimated), came


def is_of_this_clock(xp, p: Parameters, inputs: Inputs, t, h):
    """Not measured after the step that brings it (a master may have stepped the PMU first), nor ages before."""
    age = t - inputs.t_frame
    possible = xp.logical_and(age < OLDEST, age > -h - CLOCK_ERROR)
    return xp.logical_or(p.frame_time != STAMPED, possible)


def timing(xp, p: Parameters, gate: Gate, received: Received, t_frame, t, h, elapsed, omega) -> Timing:
    """Is the frame at t, `elapsed` s after the last one that was taken, a new one, and when was it measured?

    stamped: at t_frame; new if that is later than the last one's. arrival: at t; new if it differs from the last one. A
    rotor at rest gives the same frame again, a frame period after the last one, and what is left of it is known at the
    latest before the next communication point, h later. After LONGEST_REPEAT s of repeats it is omega that is wrong.
    """
    stamped = p.frame_time == STAMPED
    same = is_same(xp, received.frame, gate.frame)
    turning = xp.logical_or(xp.abs(omega) * elapsed > STILL, gate.held > 0)
    turning = xp.logical_and(turning, gate.period > 0)  # frames that never differ are those of a rotor at rest

    period = frame_period(xp, p, gate)
    due = xp.logical_and(elapsed >= EARLY * period, elapsed + h > LATE * period)
    believed = xp.logical_or(xp.logical_not(turning), gate.unchanged > LONGEST_REPEAT)
    repeat = xp.logical_and(same, xp.logical_and(due, believed))
    punctual = xp.logical_and(repeat, elapsed < OVERDUE * period)
    on_arrival = xp.where(punctual, xp.maximum(elapsed - period, 0.0), 0.0)

    latency = xp.where(stamped, t - t_frame, on_arrival)
    new = xp.where(stamped, t_frame > gate.t_frame + SHORTEST, xp.logical_or(xp.logical_not(same), repeat))
    doubtful = xp.logical_and(xp.logical_not(stamped), xp.logical_and(same, turning))
    return Timing(elapsed - latency, latency, xp.where(new, 1.0, 0.0), xp.where(doubtful, 1.0, 0.0))


def is_same(xp, frame: Frame, last: Frame):
    same = frame[0] == last[0]
    for value, last_value in zip(frame[1:], last[1:]):
        same = xp.logical_and(same, value == last_value)
    return same


def frame_period(xp, p: Parameters, gate: Gate):
    """s, as given, or as learnt; 0 as long as every step may bring a frame."""
    return xp.where(p.frame_period > 0, p.frame_period, gate.period)


def is_overdue(xp, p: Parameters, gate: Gate, waited):
    """Has none come for longer than OVERDUE periods?"""
    period = frame_period(xp, p, gate)
    return xp.logical_and(period > 0, waited > OVERDUE * period)


def seen(xp, p: Parameters, gate: Gate, received: Received, timing: Timing, t_frame, gross) -> Gate:
    """The gate behind a new frame, taken or rejected as a gross error."""
    stamped = p.frame_time == STAMPED
    differs = xp.logical_or(stamped, xp.logical_not(is_same(xp, received.frame, gate.frame)))
    interval = xp.where(stamped, t_frame - gate.t_frame, gate.unchanged)
    held = xp.logical_or(xp.logical_or(gross, timing.doubtful > 0), received.complete <= 0)
    return Gate(
        frame=received.frame,
        t_frame=t_frame,
        unchanged=xp.where(differs, 0.0, gate.unchanged),
        period=xp.where(differs, learnt_period(xp, gate.period, interval), gate.period),
        rejected=xp.where(gross, gate.rejected + 1, xp.maximum(gate.rejected - FORGIVEN, 0.0)),
        held=xp.where(held, 1.0, 0.0),
    )


def first(received: Received, t_frame) -> Gate:
    """The gate behind the first usable frame."""
    return Gate(frame=received.frame, t_frame=t_frame)


def learnt_period(xp, period, interval):
    moved = xp.where(
        interval > PERIOD_STEP * period,
        PERIOD_STEP * period,
        xp.where(PERIOD_STEP * interval < period, period / PERIOD_STEP, period),
    )
    return xp.where(period > 0, moved, interval)


def is_gross(xp, c: Constants, gate: Gate, interval: Interval, estimate: Estimate, rotor: Rotor, P_m_known):
    """Is j F of the frame that closes the interval more than 5 standard deviations from where it is expected?

    That is e^{j delta}(f_d + j f_q), which no event in the network can make jump. Only where both estimator and speed
    observer say how sure they are: I&I does not, and rejecting what contradicts it would leave it wrong.
    """
    s, P = interval.after, estimate.covariance
    x = expected(xp, c, interval.flow, estimate)
    moved = predict(xp, c, rotor, interval, rotor.P_m, P_m_known)
    cos, sin = xp.cos(moved.delta), xp.sin(moved.delta)
    re, im = s.Y2 - (cos * x.d - sin * x.q), s.Y3 - (sin * x.d + cos * x.q)
    jump_variance = by_jump(xp, c, interval)
    angle_variance = moved.covariance.dd
    variance = noise.of_phasor(s) + 2 * (P.dd + P.qq)
    variance = variance + s.Y1 * (2 * angle_variance + jump_variance + UNMODELLED * UNMODELLED)
    sure = xp.logical_and(estimate.capturing < 0.5, xp.logical_and(P.dd > 0, rotor.covariance.dd > 0))
    gross = xp.logical_and(sure, re * re + im * im > GROSS * variance)
    return xp.logical_and(gross, gate.rejected < MOST_REJECTED)


def expected(xp, c: Constants, flow, estimate: Estimate) -> Vector:
    """The estimate at the end of an interval, by its start."""
    if c.model:
        return gaussian.flux(c, flow.C, gaussian.expected(xp, c, flow, estimate.gaussian.x))
    return propagate(flow, estimate.x)


def by_jump(xp, c: Constants, interval: Interval):
    """The variance, per pu^2 of Y1, that half the jump of A over the interval makes of the estimate."""
    if c.model:
        d, q = interval.flow.jump[0], interval.flow.jump[c.model.D_STATES]
        return d[0] * d[0] + d[1] * d[1] + q[0] * q[0] + q[1] * q[1]
    b, jump = xp.maximum(c.b1, c.b2) * interval.h / 2, interval.jump.nu
    return b * b * (jump.re * jump.re + jump.im * jump.im)
