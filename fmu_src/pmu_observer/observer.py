"""Proposition 2, put together and sampled: frames in, x-hat out.

On a step from t to t + h the inputs are the frame at t. A frame that is taken (see `gating`) closes the interval since
the last one: the estimator and the speed observer move to the time at which it was measured. The outputs predict from
there to t + h with the frame held (see `prediction`). A frame that is not taken makes a longer interval, no more.
"""

from collections import namedtuple
from math import pi
from typing import Any, Callable, NamedTuple, Sequence

from . import confidence, gating, noise
from .angle import Estimate
from .estimators import ESTIMATORS
from .gating import Gate, Received, Timing
from .interface import Scalar
from .machines import MACHINE_MODELS
from .machines.two_axis import Constants, constants
from .observer_interface import (
    CAPTURING,
    HOLDING,
    MEASURED,
    STAMPED,
    TRACKING,
    WAITING,
    Inputs,
    Outputs,
    Parameters,
    rules,
    system_base,
)
from .phasors import Measurement, Signals, is_finite, signals
from .prediction import predict
from .sampling import Change, Interval, change, interval
from .speed import SPEED_OBSERVERS, Settings
from .speed.rotor import Rotor

__all__ = [
    "CAPTURING",
    "HOLDING",
    "TRACKING",
    "WAITING",
    "Inputs",
    "Outputs",
    "Parameters",
    "State",
    "first_state",
    "rules",
    "start",
    "step",
]

LARGEST_STATE, LARGEST_SPEED = 1e3, 1e3
"""pu and rad/s; beyond it an estimator or a speed observer has run away, and starts again."""

OwnStates: Any = namedtuple("OwnStates", SPEED_OBSERVERS)
"""The state of each speed observer beside the rotor; only the selected one's moves."""


class State(NamedTuple):
    started: Scalar  # 0 until the first usable frame, then 1
    elapsed: Scalar  # s, since the last frame that was taken was measured
    latency: Scalar  # s, from then to its arrival
    gate: Gate
    power_mismatch: Scalar
    signals: Signals  # of the last frame that was taken
    change: Change  # over the last interval
    estimator: Any
    estimate: Estimate  # at that frame
    rotor: Rotor  # likewise
    speed: Any  # OwnStates
    noise: noise.Estimate
    mean_squares: confidence.MeanSquares


def constants_of(name: str, machine_model: str, p: Parameters) -> Constants:
    """The machine's constants; for the estimator robust with its data and model."""
    m = system_base(p)
    c = constants(m)
    return c._replace(machine=m, model=MACHINE_MODELS[machine_model]) if name == "robust" else c


def start(name: str, xp, p: Parameters, inputs: Inputs, t, machine_model: str = "two_axis"):
    """State and outputs at initialisation: the outputs show the frame at t, which the first step brings again."""
    state = first_state(name, xp, p, inputs, t, machine_model)
    return state, step(name, xp, p, state, inputs, t, 0.0, machine_model)[1]


def first_state(name: str, xp, p: Parameters, inputs: Inputs, t, machine_model: str = "two_axis") -> State:
    """The state before the first frame."""
    c = constants_of(name, machine_model, p)
    # an open generator: only its shape matters
    some = signals(xp, c, Measurement(0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    own = ESTIMATORS[name].start(xp, getattr(p.estimators, name), c, some)
    nothing = ESTIMATORS[name].estimate(xp, own, some, 0.0)
    settings = Settings(0.0, 0.0)
    return State(
        started=0.0,
        elapsed=0.0,
        latency=0.0,
        gate=Gate(),
        power_mismatch=0.0,
        signals=some,
        change=Change(),
        estimator=own,
        estimate=nothing,
        rotor=Rotor(0.0),
        speed=OwnStates(*[module.start(xp, c, some, nothing, settings)[1] for module in SPEED_OBSERVERS.values()]),
        noise=noise.Estimate(),
        mean_squares=confidence.MeanSquares(),
    )


def step(name: str, xp, p: Parameters, state: State, inputs: Inputs, t, h, machine_model: str = "two_axis"):
    """A communication step from t to t + h with the estimator called `name`: the state and the outputs at t + h."""
    c = constants_of(name, machine_model, p)
    tve = xp.maximum(xp.where(p.tve > 0, p.tve, noise.learnt(xp, state.noise)), noise.LEAST_TVE)
    started = state.started > 0
    received = gating.receive(xp, p, c, inputs, t, h, started, state.signals, state.estimate, state.rotor, tve)
    t_frame = xp.where(p.frame_time == STAMPED, inputs.t_frame, 0.0)
    state = xp.cond(
        received.usable > 0,
        lambda: xp.cond(
            started,
            lambda: consider(name, xp, p, c, state, received, t_frame, t, h),
            lambda: begin(name, xp, p, c, state, received, t_frame, t),
        ),
        lambda: state._replace(gate=state.gate._replace(held=1.0)),
    )
    state = state._replace(
        elapsed=xp.where(state.started > 0, state.elapsed + h, 0.0),
        gate=state.gate._replace(unchanged=xp.where(state.started > 0, state.gate.unchanged + h, 0.0)),
    )
    return state, predict(name, xp, p, c, state)


def begin(name, xp, p, c, state: State, received: Received, t_frame, t) -> State:
    """The state at the first usable frame."""
    estimator, s = ESTIMATORS[name], received.signals
    fresh = estimator.start(xp, getattr(p.estimators, name), c, s)
    estimate = estimator.estimate(xp, fresh, s, s.measured.theta)
    rotor, own = selected(xp, p, state.speed, lambda module, own: module.start(xp, c, s, estimate, settings_of(p)))
    latency = xp.where(p.frame_time == STAMPED, t - t_frame, 0.0)
    return state._replace(
        started=1.0,
        elapsed=latency,
        latency=latency,
        gate=gating.first(received, t_frame),
        power_mismatch=received.power_mismatch,
        signals=s,
        estimator=fresh,
        estimate=estimate,
        rotor=rotor,
        speed=own,
    )


def consider(name, xp, p, c, state: State, received: Received, t_frame, t, h) -> State:
    """The state at a usable frame: is it a new one, and does it agree with what has come so far?"""
    timing = gating.timing(xp, p, state.gate, received, t_frame, t, h, state.elapsed, state.rotor.omega)

    def judged():
        span = interval(xp, c, state.signals, received.signals, timing.h, state.change)
        known = p.mechanical_power == MEASURED
        gross = gating.is_gross(xp, c, state.gate, span, state.estimate, state.rotor, known)
        gate = gating.seen(xp, p, state.gate, received, timing, t_frame, gross)
        remembered = state._replace(gate=gate, power_mismatch=received.power_mismatch)
        return xp.cond(gross, lambda: remembered, lambda: take(name, xp, p, c, remembered, span, timing))

    return xp.cond(timing.new > 0, judged, lambda: state)


def take(name, xp, p, c, state: State, span: Interval, timing: Timing) -> State:
    """The state at a frame, from the one at the frame before."""
    estimator, gains, s, h = ESTIMATORS[name], getattr(p.estimators, name), span.after, span.h
    near = state.rotor.delta + state.rotor.omega * h
    moved = estimator.step(xp, gains, c, state.estimator, span)
    estimate = estimator.estimate(xp, moved, s, near)

    def restarted():
        fresh = estimator.start(xp, gains, c, s)
        return fresh, estimator.estimate(xp, fresh, s, near)

    credible = is_finite(xp, estimate.x, LARGEST_STATE)
    moved, estimate = xp.cond(credible, lambda: (moved, estimate), restarted)
    rotor, own = swing(xp, p, c, state, span, estimate)
    return State(
        started=1.0,
        elapsed=timing.latency,
        latency=timing.latency,
        gate=state.gate,
        power_mismatch=state.power_mismatch,
        signals=s,
        change=change(xp, span.before, s, h),
        estimator=moved,
        estimate=estimate,
        rotor=rotor,
        speed=own,
        noise=xp.cond(p.tve <= 0, lambda: noise.learn(xp, state.noise, s), lambda: state.noise),
        mean_squares=confidence.observed(
            xp, state.mean_squares, estimate.innovation, rotor.innovation, estimate.capturing, h
        ),
    )


def swing(xp, p, c: Constants, state: State, span: Interval, estimate: Estimate):
    """The rotor, and the speed observers' own states, at the end of an interval.

    A speed observer that ran away starts again. So it does beyond half a turn a frame, where the angles fit another
    speed as well, and a filter that trusts itself would hold on to the wrong one; where frames were rejected in
    between, over the whole interval: a rotor that turns by 2 pi/3 a frame would fit every third one for good.
    """
    settings = settings_of(p)

    def stepped(module, own):
        gains = getattr(p.speed, name_of(module))
        return module.step(xp, gains, c, state.rotor, own, span, estimate, settings)

    def restarted(module, own):
        return module.start(xp, c, span.after, estimate, settings)

    rotor, own = selected(xp, p, state.speed, stepped)
    period = xp.minimum(span.h, gating.frame_period(xp, p, state.gate))
    turn = rotor.omega * xp.where(state.gate.rejected > 0, span.h, period)
    knows = rotor.covariance.dd > 0  # I&I forgets a wrong speed by itself
    unambiguous = xp.logical_or(xp.logical_not(knows), xp.abs(turn) < pi)
    credible = xp.logical_and(is_finite(xp, (rotor.omega,), LARGEST_SPEED), unambiguous)
    return xp.cond(credible, lambda: (rotor, own), lambda: selected(xp, p, state.speed, restarted))


def settings_of(p: Parameters) -> Settings:
    return Settings(P_m_known=p.mechanical_power == MEASURED, k=p.k_speed)


def name_of(module) -> str:
    return next(name for name, other in SPEED_OBSERVERS.items() if other is module)


def selected(xp, p: Parameters, speed, function: Callable) -> Any:
    """(rotor, own states) with what `function(module, own state)` makes of the selected speed observer."""

    def of(name):
        rotor, own = function(SPEED_OBSERVERS[name], getattr(speed, name))
        return rotor, speed._replace(**{name: own})

    return choose(xp, p.speed_observer, [lambda name=name: of(name) for name in SPEED_OBSERVERS])


def choose(xp, number, functions: Sequence[Callable]) -> Any:
    """What the function of that number returns, counted from 1."""
    *others, last = functions
    chosen = last
    for k, function in reversed(list(enumerate(others, 1))):
        chosen = branch(xp, number == k, function, chosen)
    return chosen()


def branch(xp, condition, then, otherwise):
    return lambda: xp.cond(condition, then, otherwise)
