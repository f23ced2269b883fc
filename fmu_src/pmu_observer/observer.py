"""Proposition 2, put together and sampled: frames in, x-hat out.

On a step from t to t + h the inputs are the frame at t. A frame that is due closes the interval since the frame before:
the estimator and the speed observer move to t, and the outputs predict from there to t + h with the frame held. A frame
that cannot be used is replaced by the last good one, turned on at the estimated speed.
"""

from collections import namedtuple
from math import pi
from typing import Annotated, Any, List, NamedTuple

from . import frames, noise, tree
from .angle import Estimate, direction_variance, unwrap
from .estimators import ESTIMATORS, kalman
from .interface import INLINE, Boolean, Enumeration, Integer, Real, Rule, Scalar
from .linear import Vector, propagation
from .machines.data import Machine, on_system_base, reactance_rules
from .machines.two_axis import Constants, constants
from .phasors import Frame, Measurement, Signals, behind_resistance, is_consistent, is_finite, measurement, signals
from .sampling import Change, Interval, change, interval
from .speed import Rotor, immersion_invariance
from .speed import adaptive as adaptive_ii
from .speed import kalman as kalman_speed

WAITING, CAPTURING, TRACKING, HOLDING = 0, 1, 2, 3

ADAPTIVE, KALMAN = 2, 3
"""Items of speed_observer."""

ROBUST = 1 + list(ESTIMATORS).index("robust")

MEASURED, ESTIMATED = 1, 2
"""Items of field_voltage and mechanical_power."""


class Inputs(NamedTuple):
    frame: Annotated[Frame, INLINE] = Frame()
    P_m: Annotated[Scalar, Real("pu", "mechanical power; not used where it is estimated")] = 0.0
    E_f: Annotated[
        Scalar, Real("pu", "field voltage (open circuit: E_f = 1 gives V = 1); not used where it is estimated")
    ] = 0.0
    frame_valid: Annotated[Scalar, Boolean("the frame is a new one and not marked invalid; else it is held over")] = 1.0


def of_each_estimator(kind):
    """A tree with one branch an estimator, named like it: its Parameters or its Outputs, with their defaults."""
    return namedtuple(f"Estimator{kind}", ESTIMATORS)(*[getattr(module, kind)() for module in ESTIMATORS.values()])


class Parameters(NamedTuple):
    machine: Annotated[Machine, INLINE] = Machine()
    S_base: Annotated[Scalar, Real("MVA", "base of the frames and of P_m", min=1e-6, max=1e6, nominal=100.0)] = 100.0
    S_n: Annotated[Scalar, Real("MVA", "base of the machine's parameters", min=1e-6, max=1e6, nominal=100.0)] = 100.0
    estimator: Annotated[Scalar, Enumeration("Estimator", "estimator of E'd and E'q", tuple(ESTIMATORS))] = ROBUST
    tve: Annotated[
        Scalar,
        Real(
            "1",
            "assumed noise of the phasors: total vector error, RMS; rather too large than too small; "
            "0: estimated from the frames",
            min=0.0,
            max=0.2,
            nominal=0.01,
        ),
    ] = 0.01
    power_source: Annotated[
        Scalar,
        Enumeration("PowerSource", "P and Q from the inputs P_t, Q_t or from the phasors", ("inputs", "phasors")),
    ] = 1
    frame_period: Annotated[
        Scalar,
        Real("s", "time between PMU frames, where steps are shorter; 0: every step brings a frame", min=0.0, max=10.0),
    ] = 0.0
    field_voltage: Annotated[
        Scalar,
        Enumeration(
            "FieldVoltage", "E_f from its input, or estimated (by the estimator robust)", ("measured", "estimated")
        ),
    ] = MEASURED
    speed_observer: Annotated[
        Scalar,
        Enumeration(
            "SpeedObserver",
            "I&I, I&I with a0 and b0 estimated, or a Kalman filter with its gain from tve",
            ("immersion_invariance", "adaptive", "kalman"),
        ),
    ] = KALMAN
    mechanical_power: Annotated[
        Scalar,
        Enumeration(
            "MechanicalPower", "P_m from its input, or estimated by the speed observer", ("measured", "estimated")
        ),
    ] = MEASURED
    k_speed: Annotated[Scalar, Real("1/s", "gain of the I&I speed observer", min=0.0, max=1e4, tunable=True)] = 80.0
    adaptive: adaptive_ii.Parameters = adaptive_ii.Parameters()
    estimators: Annotated[Any, INLINE] = of_each_estimator("Parameters")


def deviation(unit, of, known_to):
    return Real(unit, f"standard deviation of {of}; 0: not known (only {known_to} knows it) or measured", min=0.0)


class Outputs(NamedTuple):
    delta: Annotated[Scalar, Real("rad", "rotor angle in the frame of theta_t, unwrapped")] = 0.0
    load_angle: Annotated[Scalar, Real("rad", "delta - theta_t, in (-pi, pi]")] = 0.0
    omega: Annotated[Scalar, Real("rad/s", "deviation from synchronous speed")] = 0.0
    e1d: Annotated[Scalar, Real("pu", "E'd, d-axis transient voltage")] = 0.0
    e1q: Annotated[Scalar, Real("pu", "E'q, q-axis transient voltage")] = 0.0
    E_f_hat: Annotated[Scalar, Real("pu", "field voltage: measured or estimated, see field_voltage")] = 0.0
    P_m_hat: Annotated[Scalar, Real("pu", "mechanical power: measured or estimated, see mechanical_power")] = 0.0
    delta_std: Annotated[Scalar, deviation("rad", "delta", "speed_observer kalman")] = 0.0
    omega_std: Annotated[Scalar, deviation("rad/s", "omega", "speed_observer kalman")] = 0.0
    e1d_std: Annotated[Scalar, deviation("pu", "E'd", "estimator robust")] = 0.0
    e1q_std: Annotated[Scalar, deviation("pu", "E'q", "estimator robust")] = 0.0
    E_f_std: Annotated[Scalar, deviation("pu", "E_f", "estimator robust")] = 0.0
    P_m_std: Annotated[Scalar, deviation("pu", "P_m", "speed_observer kalman")] = 0.0
    innovation: Annotated[
        Scalar,
        Real("1", "|E'|^2 of the last frame less its prediction, in standard deviations; estimator robust, else 0"),
    ] = 0.0
    status: Annotated[
        Scalar,
        Integer(
            "0 waiting for a first usable frame, 1 capturing (no reliable estimate yet), 2 tracking, "
            "3 holding (the last frame was not usable: prediction)",
            min=0,
            max=3,
        ),
    ] = WAITING
    adaptive: adaptive_ii.Outputs = adaptive_ii.Outputs()
    estimators: Annotated[Any, INLINE] = of_each_estimator("Outputs")


class State(NamedTuple):
    started: Scalar  # 0 until the first usable frame, then 1
    rejected: Scalar  # gross errors of late
    elapsed: Scalar  # s, since the last frame due
    gap: Scalar  # s, held over before that
    frame: Frame  # the last usable one, as it came
    moving: Scalar  # 1 if it differed from the one before
    signals: Signals  # of the last frame due, or what was held in its place
    change: Change  # over the last interval
    estimator: Any
    estimate: Estimate  # at the last frame due
    rotor: Rotor  # likewise
    adaptive: adaptive_ii.State
    noise: noise.Estimate


def system_base(p: Parameters) -> Machine:
    return on_system_base(p.machine, p.S_n, p.S_base)


def rules(xp, p: Parameters, inputs: Inputs) -> List[Rule]:
    """What must hold of parameters that are each in range."""
    one_unknown = xp.logical_or(p.speed_observer != ADAPTIVE, p.mechanical_power == MEASURED)
    has_field = xp.logical_or(p.field_voltage == MEASURED, p.estimator == ROBUST)
    return [
        *reactance_rules(p.machine),
        Rule(
            one_unknown,
            "mechanical_power = 2 (estimated) is not allowed with speed_observer = 2 (adaptive); use 1",
        ),
        Rule(
            has_field,
            "field_voltage = 2 (estimated) is not allowed with estimator = {estimator}; only robust (6) estimates it",
        ),
    ]


def start(name: str, xp, p: Parameters, inputs: Inputs, t):
    """State and outputs at initialisation: the outputs show the frame at t, which the first step brings again."""
    c = constants(system_base(p))
    # an open generator: only its shape matters
    some = signals(xp, c, Measurement(0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    estimator = ESTIMATORS[name].start(xp, getattr(p.estimators, name), c, some)
    state = State(
        started=0.0,
        rejected=0.0,
        elapsed=0.0,
        gap=0.0,
        frame=Frame(),
        moving=0.0,
        signals=some,
        change=Change(),
        estimator=estimator,
        estimate=Estimate(0.0, Vector(0.0, 0.0)),
        rotor=Rotor(0.0),
        adaptive=adaptive_ii.start(c),
        noise=noise.Estimate(),
    )
    _, outputs = step(name, xp, p, state, inputs, t, 0.0)
    return state, outputs


def step(name: str, xp, p: Parameters, state: State, inputs: Inputs, t, h):
    """A communication step from t to t + h with the estimator called `name`: the state and the outputs at t + h."""
    m = system_base(p)
    c = constants(m)
    started = state.started > 0
    due = state.elapsed >= 0.95 * p.frame_period  # a recorded time stamp may be rounded
    usable, s = read(xp, p, m, c, state, inputs)
    state = xp.cond(
        started,
        lambda: xp.cond(due, lambda: close(name, xp, p, c, state, inputs.frame, s, usable), lambda: state),
        lambda: xp.cond(usable, lambda: begin(name, xp, p, c, state, inputs.frame, s), lambda: state),
    )
    state = state._replace(elapsed=xp.where(state.started > 0, state.elapsed + h, 0.0))
    return state, predict(name, xp, p, m, c, state)


def read(xp, p: Parameters, m: Machine, c: Constants, state: State, inputs: Inputs):
    """Is the frame usable, and its signals: any that can be calculated with, if it is not."""
    field_known, power_known = p.field_voltage == MEASURED, p.mechanical_power == MEASURED
    P_m = xp.where(power_known, inputs.P_m, state.rotor.P_m)
    E_f = xp.where(field_known, inputs.E_f, state.estimate.E_f)
    usable = frames.is_usable(xp, inputs.frame, (P_m, E_f), inputs.frame_valid)
    given = inputs.frame, P_m, E_f
    frame, P_m, E_f = xp.cond(usable, lambda: given, lambda: tree.map(lambda _: 1.0, given))  # math.cos(inf) raises
    tve = xp.where(p.tve > 0, p.tve, noise.learnt(xp, state.noise))
    measured = measurement(xp, frame, P_m, E_f, p.power_source == 2)._replace(
        tve=xp.maximum(tve, noise.LEAST_TVE), E_f_known=xp.where(field_known, 1.0, 0.0)
    )
    s = signals(xp, c, behind_resistance(xp, measured, m.Ra))
    return xp.logical_and(usable, is_consistent(xp, c, s)), s


def held_over(xp, c: Constants, state: State) -> Signals:
    """The last good frame, turned on at the estimated speed."""
    last = state.signals.measured
    return signals(xp, c, last._replace(theta=last.theta + state.rotor.omega * state.elapsed, held=1.0))


def begin(name, xp, p, c, state: State, frame: Frame, s: Signals) -> State:
    """The state at the first usable frame."""
    estimator = ESTIMATORS[name]
    fresh = estimator.start(xp, getattr(p.estimators, name), c, s)
    estimate = estimator.estimate(xp, fresh, s, s.measured.theta)
    rotor = rotor_at_start(xp, p, c, s, estimate)
    return state._replace(
        started=1.0,
        frame=frame,
        signals=s,
        estimator=fresh,
        estimate=estimate,
        rotor=rotor,
        adaptive=adaptive_ii.start(c),
    )


def close(name, xp, p, c, state: State, frame: Frame, s: Signals, usable) -> State:
    """The state at a frame, from the one at the frame before."""
    estimator, own, h = ESTIMATORS[name], getattr(p.estimators, name), state.elapsed

    # the frame, or what is held in its place
    same = frames.is_same(xp, frame, state.frame)
    turning = xp.abs(state.rotor.omega) * (state.gap + h) > frames.STILL
    stale = xp.logical_and(xp.logical_and(same, state.moving > 0), turning)
    stale = xp.logical_and(stale, state.gap < frames.LONGEST_REPEAT)
    usable = xp.logical_and(usable, xp.logical_not(stale))
    held = held_over(xp, c, state)
    s = xp.cond(usable, lambda: s, lambda: held)
    span = interval(xp, c, state.signals, s, h, state.change)
    gross = xp.logical_and(usable, frames.is_gross(xp, c, span, state.estimate, state.rotor))
    gross = xp.logical_and(gross, state.rejected < frames.MOST_REJECTED)
    span = xp.cond(gross, lambda: interval(xp, c, state.signals, held, h, state.change), lambda: span)
    s = span.after

    near = state.rotor.delta + state.rotor.omega * h
    moved = estimator.step(xp, own, c, state.estimator, span)
    estimate = estimator.estimate(xp, moved, s, near)
    credible = is_finite(xp, [1e6 * x for x in estimate.x])  # below 1000 pu: an estimator that ran away starts again

    def restarted():
        fresh = estimator.start(xp, own, c, s)
        return fresh, estimator.estimate(xp, fresh, s, near)

    moved, estimate = xp.cond(credible, lambda: (moved, estimate), restarted)

    rotor, calibrated = swing(xp, p, c, state, span, estimate)
    return State(
        started=1.0,
        rejected=xp.where(gross, state.rejected + 1, xp.maximum(state.rejected - frames.FORGIVEN, 0.0)),
        elapsed=0.0,
        gap=xp.where(s.measured.held > 0, state.gap + h, 0.0),
        frame=xp.cond(usable, lambda: frame, lambda: state.frame),
        moving=xp.where(xp.logical_and(usable, xp.logical_not(same)), 1.0, state.moving),
        signals=s,
        change=change(span.before, s),
        estimator=moved,
        estimate=estimate,
        rotor=rotor,
        adaptive=calibrated,
        noise=xp.cond(
            xp.logical_and(p.tve <= 0, s.measured.held <= 0),
            lambda: noise.learn(xp, c, state.noise, s),
            lambda: state.noise,
        ),
    )


def swing(xp, p, c, state: State, span: Interval, estimate: Estimate):
    """The rotor, and the adaptive observer's state, at the end of an interval."""
    held = span.after.measured.held > 0
    known = p.mechanical_power == MEASURED

    def by_immersion_invariance():
        # a gap and the frame that ends it are one interval; the estimator's correction is no turn of the rotor
        whole = span._replace(h=state.gap + span.h)
        before = state.rotor._replace(delta=state.rotor.delta - state.rotor.omega * state.gap)
        turn = unwrap(xp, estimate.delta + estimate.turn - before.delta, before.omega * whole.h)
        calibrated = xp.cond(
            xp.logical_and(xp.logical_not(held), p.speed_observer == ADAPTIVE),
            lambda: adaptive_ii.step(xp, p.adaptive, state.adaptive, whole, turn),
            lambda: state.adaptive,
        )
        a0, b0 = (state.adaptive.a0 + calibrated.a0) / 2, (state.adaptive.b0 + calibrated.b0) / 2
        moved = xp.cond(
            known,
            lambda: immersion_invariance.step_known(xp, before, a0, b0, p.k_speed, whole, turn),
            lambda: immersion_invariance.step_unknown(xp, before, c.a0, c.b0, p.k_speed, whole, turn),
        )
        # a held P drives no swing
        on = state.rotor._replace(delta=state.rotor.delta + state.rotor.omega * span.h)
        return xp.cond(held, lambda: on, lambda: moved._replace(delta=estimate.delta)), calibrated

    rotor, calibrated = xp.cond(
        p.speed_observer == KALMAN,
        lambda: (kalman_speed.step(xp, c, state.rotor, span, estimate, known), state.adaptive),
        by_immersion_invariance,
    )
    # a speed observer that ran away starts again: beyond 1000 rad/s, or, since a full turn between two frames is none,
    # where a Kalman filter that trusts itself would hold on to it, beyond a quarter turn a frame
    turning = xp.where(p.speed_observer == KALMAN, rotor.omega * span.h, 0.0)
    credible = xp.logical_and(is_finite(xp, (1e6 * rotor.omega,)), xp.abs(turning) < pi / 2)
    rotor = xp.cond(credible, lambda: rotor, lambda: rotor_at_start(xp, p, c, span.after, estimate))
    return rotor, xp.cond(credible, lambda: calibrated, lambda: adaptive_ii.start(c))


def rotor_at_start(xp, p, c, s: Signals, estimate: Estimate) -> Rotor:
    """The estimator's angle, synchronous speed, and an unknown P_m that balances the frame's P."""
    known = p.mechanical_power == MEASURED
    return xp.cond(
        p.speed_observer == KALMAN,
        lambda: kalman_speed.start(xp, c, s, estimate, known),
        lambda: Rotor(estimate.delta, 0.0, xp.where(known, s.measured.P_m, s.measured.P)),
    )


def predict(name, xp, p: Parameters, m: Machine, c: Constants, state: State) -> Outputs:
    """The outputs `elapsed` after the last frame, with its measurement and its load angle held.

    omega' = -a0 omega + b0 (Pm - P) and delta' = omega go on; while frames are held over, omega is constant. What
    changed between the last two frames may do so again unseen: that goes into the standard deviations.
    """
    s, h, estimate, rotor = state.signals, state.elapsed, state.estimate, state.rotor
    frame = s.measured
    flow = propagation(xp, s.A, s.A, c.c1 * frame.E_f, c.c1 * frame.E_f, h)
    coming = Interval(s, s, h, flow, state.change)
    ahead = kalman.predict(
        xp,
        kalman.transition(xp, c, coming, frame.E_f_known, 0.0),
        kalman.Gaussian(estimate.x, estimate.E_f, estimate.covariance),
        0.0,
    )
    calibrated = c._replace(a0=state.adaptive.a0, b0=state.adaptive.b0)
    rotor_ahead = kalman_speed.predict(xp, calibrated, rotor, coming, rotor.P_m, p.mechanical_power == MEASURED)
    terminal = behind_resistance(xp, frame, -m.Ra)

    # behind x'd the estimator sees E'd + (x'q - x'd) Iq: exact in steady state
    angle = rotor.delta - frame.theta
    Iq = (frame.P * xp.cos(angle) - frame.Q * xp.sin(angle)) / frame.V
    P, R = ahead.P, rotor_ahead.covariance

    def deviation(known, variance):
        return xp.where(known > 0, xp.sqrt(xp.maximum(variance, 0.0)), 0.0)

    sure, rotor_sure = estimate.covariance.dd, rotor.covariance.dd
    outputs = Outputs(
        delta=rotor_ahead.delta,
        load_angle=unwrap(xp, rotor.delta - terminal.theta, 0.0),
        omega=rotor_ahead.omega,
        e1d=ahead.x.d - (m.xq1 - m.xd1) * Iq,
        e1q=ahead.x.q,
        E_f_hat=ahead.E_f,
        P_m_hat=rotor.P_m,
        delta_std=deviation(rotor_sure, R.dd + direction_variance(ahead.x, P)),
        omega_std=deviation(rotor_sure, R.oo),
        e1d_std=deviation(sure, P.dd),
        e1q_std=deviation(sure, P.qq),
        E_f_std=deviation(xp.where(frame.E_f_known > 0, 0.0, sure), P.ff),
        P_m_std=deviation(rotor_sure, rotor.covariance.pp),
        innovation=estimate.innovation,
        status=xp.where(frame.held > 0, HOLDING, xp.where(estimate.capturing > 0.5, CAPTURING, TRACKING)),
        adaptive=adaptive_ii.outputs(state.adaptive),
        estimators=Outputs().estimators._replace(**{name: ESTIMATORS[name].outputs(xp, state.estimator)}),
    )
    return xp.cond(state.started > 0, lambda: outputs, Outputs)
