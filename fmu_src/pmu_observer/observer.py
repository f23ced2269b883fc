"""Proposition 2, put together and sampled: frames in, x-hat out.

On a step from t to t + h the inputs are the frame at t. A frame that is due closes the interval since the frame before:
the estimator and the speed observer move to t, and the outputs predict from there to t + h with the frame held. A frame
that cannot be used is replaced by the last good one, turned on at the estimated speed.
"""

from collections import namedtuple
from typing import Annotated, Any, List, NamedTuple

from . import tree
from .angle import unwrap
from .estimators import ESTIMATORS
from .interface import INLINE, Enumeration, Integer, Real, Rule, Scalar
from .linear import Vector, decay_mean, propagate, propagation
from .machine import Constants, TwoAxisMachine, constants, reactance_rules
from .phasors import (
    LOWEST_VOLTAGE,
    Frame,
    Measurement,
    Signals,
    behind_resistance,
    is_consistent,
    is_finite,
    measurement,
    signals,
)
from .sampling import interval
from .speed import adaptive as adaptive_ii
from .speed import immersion_invariance

WAITING, CAPTURING, TRACKING, HOLDING = 0, 1, 2, 3


class Inputs(NamedTuple):
    frame: Annotated[Frame, INLINE] = Frame()
    P_m: Annotated[Scalar, Real("pu", "mechanical power")] = 0.0
    E_f: Annotated[Scalar, Real("pu", "field voltage (open circuit: E_f = 1 gives V = 1)")] = 0.0


def of_each_estimator(kind):
    """A tree with one branch an estimator, named like it: its Parameters or its Outputs, with their defaults."""
    return namedtuple(f"Estimator{kind}", ESTIMATORS)(*[getattr(module, kind)() for module in ESTIMATORS.values()])


class Parameters(NamedTuple):
    machine: Annotated[TwoAxisMachine, INLINE] = TwoAxisMachine()
    estimator: Annotated[Scalar, Enumeration("Estimator", "estimator of E'd and E'q", tuple(ESTIMATORS))] = 1
    power_source: Annotated[
        Scalar,
        Enumeration("PowerSource", "P and Q from the inputs P_t, Q_t or from the phasors", ("inputs", "phasors")),
    ] = 1
    frame_period: Annotated[
        Scalar,
        Real("s", "time between PMU frames, where steps are shorter; 0: every step brings a frame", min=0.0, max=10.0),
    ] = 0.0
    speed_observer: Annotated[
        Scalar,
        Enumeration("SpeedObserver", "I&I, or I&I with a0 and b0 estimated", ("immersion_invariance", "adaptive")),
    ] = 1
    mechanical_power: Annotated[
        Scalar,
        Enumeration("MechanicalPower", "P_m from its input, or estimated by I&I", ("measured", "estimated")),
    ] = 1
    k_speed: Annotated[Scalar, Real("1/s", "gain of the I&I speed observer", min=0.0, max=1e4, tunable=True)] = 80.0
    adaptive: adaptive_ii.Parameters = adaptive_ii.Parameters()
    estimators: Annotated[Any, INLINE] = of_each_estimator("Parameters")


class Outputs(NamedTuple):
    delta: Annotated[Scalar, Real("rad", "rotor angle in the frame of theta_t, unwrapped")] = 0.0
    load_angle: Annotated[Scalar, Real("rad", "delta - theta_t, in (-pi, pi]")] = 0.0
    omega: Annotated[Scalar, Real("rad/s", "deviation from synchronous speed")] = 0.0
    e1d: Annotated[Scalar, Real("pu", "E'd, d-axis transient voltage")] = 0.0
    e1q: Annotated[Scalar, Real("pu", "E'q, q-axis transient voltage")] = 0.0
    P_m_hat: Annotated[Scalar, Real("pu", "mechanical power: measured or estimated, see mechanical_power")] = 0.0
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
    held: Scalar  # 1 if the last frame due was not usable
    elapsed: Scalar  # s, since the last frame due
    signals: Signals  # of the last frame due, or what was held in its place
    estimator: Any
    delta: Scalar  # rad, at that frame
    x: Vector  # pu, (E'd, E'q) at that frame
    speed: immersion_invariance.State
    adaptive: adaptive_ii.State


def rules(xp, p: Parameters, inputs: Inputs) -> List[Rule]:
    """What must hold of parameters that are each in range."""
    one_unknown = xp.logical_or(p.speed_observer == 1, p.mechanical_power == 1)
    together = "mechanical_power = 2 (estimated) is not allowed with speed_observer = 2 (adaptive); use 1"
    return [*reactance_rules(p.machine), Rule(one_unknown, together)]


def start(name: str, xp, p: Parameters, inputs: Inputs, t):
    """State and outputs at initialisation: the outputs show the frame at t, which the first step brings again."""
    c = constants(p.machine)
    some = signals(xp, c, Measurement(0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0))  # an open generator: only its shape matters
    state = State(
        started=0.0,
        held=0.0,
        elapsed=0.0,
        signals=some,
        estimator=ESTIMATORS[name].start(xp, getattr(p.estimators, name), c, some),
        delta=0.0,
        x=Vector(0.0, 0.0),
        speed=immersion_invariance.start(0.0),
        adaptive=adaptive_ii.start(c),
    )
    _, outputs = step(name, xp, p, state, inputs, t, 0.0)
    return state, outputs


def step(name: str, xp, p: Parameters, state: State, inputs: Inputs, t, h):
    """A communication step from t to t + h with the estimator called `name`: the state and the outputs at t + h."""
    c = constants(p.machine)
    usable, s = read(xp, p, c, state, inputs)
    started = state.started > 0
    due = state.elapsed >= 0.95 * p.frame_period  # a recorded time stamp may be rounded
    state = xp.cond(
        started,
        lambda: xp.cond(due, lambda: close(name, xp, p, c, state, s, usable), lambda: state),
        lambda: xp.cond(usable, lambda: begin(name, xp, p, c, state, s), lambda: state),
    )
    state = state._replace(elapsed=xp.where(state.started > 0, state.elapsed + h, 0.0))
    return state, predict(name, xp, p, c, state)


def read(xp, p: Parameters, c: Constants, state: State, inputs: Inputs):
    """Is the frame usable, and its signals: if it is not, the last good one's, turned on at the estimated speed."""
    finite = xp.logical_and(is_finite(xp, tree.leaves(inputs)), inputs.frame.V_t > LOWEST_VOLTAGE)
    safe = tree.map(lambda value: xp.where(finite, value, 1.0), inputs)  # math.cos(inf) raises
    m = measurement(xp, safe.frame, safe.P_m, safe.E_f, p.power_source == 2)
    s = signals(xp, c, behind_resistance(xp, m, p.machine.Ra))
    usable = xp.logical_and(finite, is_consistent(xp, s))

    last = state.signals.measured
    held = last._replace(theta=last.theta + state.speed.omega * state.elapsed)
    chosen = tree.map(lambda new, old: xp.where(usable, new, old), s.measured, held)
    return usable, signals(xp, c, chosen)


def begin(name, xp, p, c, state: State, s: Signals) -> State:
    """The state at the first usable frame."""
    estimator = ESTIMATORS[name]
    fresh = estimator.start(xp, getattr(p.estimators, name), c, s)
    delta, x = estimator.estimate(xp, fresh, s, s.measured.theta)
    speed = immersion_invariance.start(s.measured.P_m)
    return State(1.0, 0.0, 0.0, s, fresh, delta, x, speed, adaptive_ii.start(c))


def close(name, xp, p, c, state: State, s: Signals, usable) -> State:
    """The state at a frame, from the one at the frame before."""
    estimator, own = ESTIMATORS[name], getattr(p.estimators, name)
    span = interval(xp, c, state.signals, s, state.elapsed)
    near = state.delta + state.speed.omega * state.elapsed

    moved = estimator.step(xp, own, c, state.estimator, span)
    x = estimator.estimate(xp, moved, s, near).x
    credible = is_finite(xp, (1e6 * x.d, 1e6 * x.q))  # below 1000 pu: an estimator that ran away starts again
    moved = xp.cond(credible, lambda: moved, lambda: estimator.start(xp, own, c, s))
    delta, x = estimator.estimate(xp, moved, s, near)

    turn = unwrap(xp, delta - state.delta, state.speed.omega * state.elapsed)
    calibrating = xp.logical_and(usable, p.speed_observer == 2)
    calibrated = xp.cond(
        calibrating, lambda: adaptive_ii.step(xp, p.adaptive, state.adaptive, span, turn), lambda: state.adaptive
    )
    a0, b0 = (state.adaptive.a0 + calibrated.a0) / 2, (state.adaptive.b0 + calibrated.b0) / 2
    speed = xp.cond(
        p.mechanical_power == 2,
        lambda: immersion_invariance.step_unknown(xp, state.speed, c.a0, c.b0, p.k_speed, span, turn),
        lambda: immersion_invariance.step_known(xp, state.speed, a0, b0, p.k_speed, span, turn),
    )
    speed = xp.cond(usable, lambda: speed, lambda: state.speed)  # a held P drives no swing
    credible = is_finite(xp, (1e6 * speed.omega,))  # below 1000 rad/s, and likewise
    speed = xp.cond(credible, lambda: speed, lambda: immersion_invariance.start(s.measured.P_m))
    calibrated = xp.cond(credible, lambda: calibrated, lambda: adaptive_ii.start(c))
    return State(1.0, xp.where(usable, 0.0, 1.0), 0.0, s, moved, delta, x, speed, calibrated)


def predict(name, xp, p: Parameters, c: Constants, state: State) -> Outputs:
    """The outputs `elapsed` after the last frame, with its measurement and its load angle held.

    omega' = -a0 omega + b0 (Pm - P) and delta' = omega go on; while frames are held over, omega is constant.
    """
    m, h = state.signals.measured, state.elapsed
    forcing = c.c1 * m.E_f
    x = propagate(propagation(xp, state.signals.A, state.signals.A, forcing, forcing, h), state.x)
    a0, b0 = state.adaptive.a0, state.adaptive.b0
    acceleration = xp.where(state.held > 0, 0.0, b0 * (state.speed.P_m - m.P) - a0 * state.speed.omega)
    change = h * decay_mean(xp, a0 * h) * acceleration
    terminal = behind_resistance(xp, m, -p.machine.Ra)

    # behind x'd the estimator sees E'd + (x'q - x'd) Iq: exact in steady state
    Iq = (m.P * xp.cos(state.delta - m.theta) - m.Q * xp.sin(state.delta - m.theta)) / m.V
    outputs = Outputs(
        delta=state.delta + h * (state.speed.omega + change / 2),
        load_angle=unwrap(xp, state.delta - terminal.theta, 0.0),
        omega=state.speed.omega + change,
        e1d=x.d - (p.machine.xq1 - p.machine.xd1) * Iq,
        e1q=x.q,
        P_m_hat=state.speed.P_m,
        status=xp.where(state.held > 0, HOLDING, TRACKING),
        adaptive=adaptive_ii.outputs(state.adaptive),
        estimators=Outputs().estimators._replace(**{name: ESTIMATORS[name].outputs(xp, state.estimator)}),
    )
    return tree.map(lambda value, waiting: xp.where(state.started > 0, value, waiting), outputs, Outputs())
