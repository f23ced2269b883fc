"""Frames that cannot be used: nothing raises, no output is NaN, the status says so, and the estimate recovers."""

from math import inf, isfinite, nan

import numpy as np
import pytest

from fmu_src.pmu_observer import observer, tree
from fmu_src.pmu_observer.carriers import floats
from fmu_src.pmu_observer.estimators import ESTIMATORS
from fmu_src.pmu_observer.observer import CAPTURING, HOLDING, TRACKING, WAITING

from . import reference
from .reference import MOVING_CASE
from .sampled import inputs_along, parameters_of, run

H = 1 / 60
CASE = MOVING_CASE._replace(P_m=lambda t: 5.0, E_f=lambda t: 2.0)  # swings, and comes to rest
SOLUTION = reference.solve(CASE, np.arange(0, 12, H))
INPUTS = inputs_along(CASE, SOLUTION)
P = parameters_of(CASE.machine)

# the same, damped
STEADY_SOLUTION = reference.solve(CASE._replace(machine=CASE.machine._replace(D=0.3)), np.arange(0, 25, H))
STEADY = inputs_along(CASE, STEADY_SOLUTION)


def spoilt(i, **values):
    """The inputs with some of the frame's or of their own values replaced."""
    own = {name: value for name, value in values.items() if name in i._fields}
    frame = {name: value for name, value in values.items() if name not in own}
    return i._replace(frame=i.frame._replace(**frame), **own)


BAD = {
    **{f"{name} NaN": {name: nan} for name in ("V_t", "theta_t", "I_t", "P_t", "Q_t", "P_m", "E_f")},
    **{f"{name} inf": {name: inf} for name in ("V_t", "theta_t", "I_t", "P_t", "E_f")},
    "P -inf": {"P_t": -inf},
    "V zero": {"V_t": 0.0},
    "V negative": {"V_t": -1.0},
    "V below 1e-3": {"V_t": 0.9e-3},
    "all zero": {"V_t": 0.0, "theta_t": 0.0, "I_t": 0.0, "phi_t": 0.0, "P_t": 0.0, "Q_t": 0.0},
    "I contradicts P and Q": {"I_t": 100.0},
    "P contradicts I": {"P_t": 50.0},
    "P and Q left out": {"P_t": 0.0, "Q_t": 0.0},
    "V of 1e8": {"V_t": 1e8},
    "all of 1e8": {"V_t": 1e8, "I_t": 1e8, "P_t": 1e16, "Q_t": 0.0},
    "beyond any number": {"V_t": 1e300, "I_t": 1e300, "P_t": 1e300},
}


SPEED_OBSERVERS = {
    "I&I": {},
    "I&I, Pm unknown": {"mechanical_power": 2},
    "kalman": {"speed_observer": 3},
    "kalman, Pm unknown": {"speed_observer": 3, "mechanical_power": 2},
}


def assert_finite(outputs):
    for o in outputs:
        assert all(isfinite(value) for value in tree.leaves(o)), o


@pytest.mark.parametrize("estimator", ESTIMATORS)
@pytest.mark.parametrize("bad", BAD.values(), ids=BAD)
def test_a_bad_frame_is_held_over(estimator, bad):
    frames = list(INPUTS[:12])
    frames[5] = spoilt(frames[5], **bad)
    outputs = run(estimator, P, frames, H).outputs
    assert_finite(outputs)
    started = CAPTURING if estimator == "robust" else TRACKING
    # the frame at k shows in the outputs of k + 1
    assert [o.status for o in outputs] == [started] * 6 + [HOLDING] + [started] * 5


@pytest.mark.parametrize("estimator", ESTIMATORS)
@pytest.mark.parametrize("bad", [{"V_t": 0.0}, {"V_t": nan}, {"I_t": 100.0}], ids=["zero", "NaN", "contradiction"])
def test_a_first_frame_that_is_bad_is_waited_over(estimator, bad):
    """The observer starts at the first usable frame as if the record began there."""
    late = run(estimator, P, [*(spoilt(i, **bad) for i in INPUTS[:3]), *INPUTS[3:10]], H)
    assert [o.status == WAITING for o in late.outputs] == [True] * 4 + [False] * 6
    assert all(value == 0 for o in late.outputs[:4] for value in tree.leaves(o))
    on_time = run(estimator, P, INPUTS[3:10], H)
    assert late.states[3:] == on_time.states


def test_a_record_without_any_usable_frame():
    outputs = run("drem", P, [spoilt(i, V_t=0.0) for i in INPUTS[:5]], H).outputs
    assert {o.status for o in outputs} == {WAITING}
    assert_finite(outputs)


@pytest.mark.parametrize("estimator", ESTIMATORS)
@pytest.mark.parametrize("speed", SPEED_OBSERVERS.values(), ids=SPEED_OBSERVERS)
def test_the_estimate_recovers(estimator, speed):
    """Ten bad frames while the machine swings; 6 s later they have left next to nothing."""
    p = P._replace(**speed)
    bad = list(BAD.values())
    frames = [spoilt(i, **bad[k % len(bad)]) if 60 <= k < 70 else i for k, i in enumerate(INPUTS)]
    clean, disturbed = run(estimator, p, INPUTS, H).outputs, run(estimator, p, frames, H).outputs
    assert_finite(disturbed)
    after, undisturbed = states_of(disturbed[430:]), states_of(clean[430:])
    # a gap of 0.17 s integrated with the frame held displaces (E'd, E'q) for good where nothing corrects it, and fades
    # with the machine's time constants: T'd0 x'd/xd = 1.4 s
    assert np.abs(after - undisturbed).max() < 5e-3


def test_delta_keeps_count_of_the_revolutions():
    """The infinite bus runs 0.5 Hz fast: the angles of a PMU wrap, delta does not, also over bad frames."""
    rate = 2 * np.pi * 0.5

    def turned(k, i):
        angle = rate * k * H
        wrapped = {
            name: (getattr(i.frame, name) + angle + np.pi) % (2 * np.pi) - np.pi for name in ("theta_t", "phi_t")
        }
        return spoilt(i, **wrapped, **({"V_t": nan} if 300 <= k < 305 else {}))

    still = run("gradient", P, INPUTS, H).outputs
    frames = [turned(k, i) for k, i in enumerate(INPUTS)]
    turning = run("gradient", P, frames, H).outputs
    expected = still[-1].delta + rate * (len(INPUTS) - 1) * H
    # a steady turn adds to omega what turns delta; at rest the two differ by nothing but the swing's rest
    assert turning[-1].delta == pytest.approx(expected, abs=1e-3)
    assert turning[-1].omega - still[-1].omega == pytest.approx(rate, abs=1e-2)


@pytest.mark.parametrize("speed_observer", [1, 2])
def test_a_burst_of_wild_numbers_leaves_no_mark_for_good(speed_observer):
    """Frames that are each usable, and nonsense together: whatever ran away starts again."""
    random = np.random.default_rng(0)
    p = P._replace(speed_observer=speed_observer)
    numbers = [-1e8, 0.0, 1e8]
    wild = [
        spoilt(i, theta_t=random.uniform(-np.pi, np.pi), P_m=random.choice(numbers), E_f=random.choice(numbers))
        for i in INPUTS[:100]
    ]
    outputs = run("gradient", p, [*wild, *INPUTS], H).outputs
    assert_finite(outputs)
    final = outputs[-1]
    true = SOLUTION.machine[:, len(INPUTS) - 1]
    assert abs(np.exp(1j * final.delta) - np.exp(1j * true[0])) < 1e-2
    assert abs(final.omega - true[1]) < 1e-2 and (final.e1d, final.e1q) == pytest.approx(true[2:], abs=1e-2)


def states_of(outputs):
    return np.array([[o.delta, o.omega, o.e1d, o.e1q] for o in outputs])


@pytest.mark.parametrize("speed", SPEED_OBSERVERS.values(), ids=SPEED_OBSERVERS)
def test_three_frames_in_four_are_lost(speed):
    """At random, and marked so: whatever the gain, the speed observer does not take a gap for one frame's time."""
    lost = np.random.default_rng(0).random(len(INPUTS)) < 0.75
    frames = [i._replace(frame_valid=float(not lost[k])) for k, i in enumerate(INPUTS)]
    outputs = run("gradient", P._replace(**speed), frames, H).outputs
    error = np.abs(states_of(outputs) - SOLUTION.machine.T)[300:]
    # held frames leave out a swing of 0.5 Hz and 1 rad/s for up to 0.2 s
    assert (error.max(axis=0) < [0.1, 1.0, 0.02, 0.02]).all()
    assert (error[-60:].max(axis=0) < [0.01, 0.1, 0.01, 0.01]).all()


@pytest.mark.parametrize("speed", SPEED_OBSERVERS.values(), ids=SPEED_OBSERVERS)
@pytest.mark.parametrize("resolution", [1e-3, 1e-4, 1e-6])
def test_rounded_frames(resolution, speed):
    """A PMU rounds; where the machine comes to rest, frame after frame is the same. That is not a lost frame."""
    frames = [
        i._replace(frame=type(i.frame)(*[round(value / resolution) * resolution for value in i.frame])) for i in STEADY
    ]
    outputs = run("gradient", P._replace(**speed), frames, H).outputs
    error = np.abs(states_of(outputs) - STEADY_SOLUTION.machine.T)[-300:]
    # the estimates are off by as much as the frames, the speed by as much in 0.02 s, and once for a step of rounding
    assert (error.max(axis=0) < 3 * resolution * np.array([1, 80, 1, 1]) + 1e-3).all()
    assert np.mean([o.status == HOLDING for o in outputs[-300:]]) < 0.1


def test_phasors_alone():
    """A record without P and Q gives the same estimate with power_source = 2."""
    without = [spoilt(i, P_t=0.0, Q_t=0.0) for i in INPUTS[:60]]
    with_power = run("gradient", P, INPUTS[:60], H).states[-1]
    alone = run("gradient", P._replace(power_source=2), without, H).states[-1]
    assert tree.leaves(alone.estimate) == pytest.approx(tree.leaves(with_power.estimate), abs=1e-9)
    assert tree.leaves(alone.rotor) == pytest.approx(tree.leaves(with_power.rotor), abs=1e-9)


def test_an_idle_machine_is_usable():
    """No power, and a current that is only what the PMU resolves: no contradiction."""
    idle = spoilt(INPUTS[0], I_t=1e-3, phi_t=0.0, P_t=0.0, Q_t=0.0)
    _, o = observer.start("robust", floats, P, idle, 0.0)
    assert o.status == CAPTURING


def test_steps_are_pure():
    """A step from one state is the same however often it is done: what rolling back relies on."""
    state = run("drem", P, INPUTS[:20], H).states[-1]
    once = observer.step("drem", floats, P, state, INPUTS[20], 20 * H, H)
    assert observer.step("drem", floats, P, state, INPUTS[20], 20 * H, H) == once
