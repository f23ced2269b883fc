"""A frame carries its time and is taken when it is new: whatever the master's steps, the estimates are the same."""

from math import inf, nan, pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fmu_src.pmu_observer import gating, observer, tree
from fmu_src.pmu_observer.carriers import floats
from fmu_src.pmu_observer.estimators import ESTIMATORS
from fmu_src.pmu_observer.observer_interface import ARRIVAL, CAPTURING, HOLDING, STAMPED, TRACKING, WAITING
from fmu_src.pmu_observer.plants import smib
from fmu_src.pmu_observer.speed import SPEED_OBSERVERS

from . import reference
from .reference import MOVING_CASE
from .sampled import inputs_along, machine_of, parameters_of

PERIOD = 0.02
CASE = MOVING_CASE._replace(P_m=lambda t: 5.0, E_f=lambda t: 2.0)
SOLUTION = reference.solve(CASE, np.arange(0, 1.6, PERIOD))
FRAMES = inputs_along(CASE, SOLUTION)
COUNT = len(FRAMES)
FRAME_TIMES = pytest.mark.parametrize("frame_time", [ARRIVAL, STAMPED], ids=["arrival", "stamped"])


def parameters(estimator="robust", **values):
    return parameters_of(CASE.machine, estimator)._replace(**{"speed_observer": 3, "frame_period": PERIOD, **values})


def at(inputs: observer.Inputs, t: float) -> observer.Inputs:
    return inputs._replace(t_frame=t)


def stream(times, latency=0.0, count=COUNT):
    """What a PMU shows at the communication points: the last frame that has come, with its stamp."""
    for t in times:
        k = min(int((t - latency) / PERIOD + 1e-9), count - 1) if t >= latency else 0
        yield t, at(FRAMES[k], k * PERIOD)


def run(p, communication_points, end, estimator="robust", latency=0.0, count=COUNT):
    """The state behind each communication point, and the outputs a step later, by its time."""
    points = [*communication_points, end]
    state, states, outputs = None, {}, {}
    for (t, inputs), after in zip(stream(points[:-1], latency, count), points[1:]):
        if state is None:
            state, _ = observer.start(estimator, floats, p, inputs, t)
        state, o = observer.step(estimator, floats, p, state, inputs, t, after - t)
        states[t], outputs[after] = state, o
    return states, outputs


def estimates(state: observer.State):
    return [*tree.leaves(state.estimate), *tree.leaves(state.rotor)]


STEPS = {"1 ms": np.arange(0, 1.5, 1e-3), "5 ms": np.arange(0, 1.5, 5e-3), "10 ms": np.arange(0, 1.5, 1e-2)}


@FRAME_TIMES
@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_the_step_does_not_matter(estimator, frame_time):
    """At the frames, the same estimate to rounding as with the frame period as step, for any estimator."""
    p = parameters(estimator, frame_time=frame_time)
    frames = np.arange(75) * PERIOD
    expected, _ = run(p, frames, 1.5, estimator)
    for times in (STEPS["1 ms"][:600], STEPS["5 ms"], STEPS["10 ms"]):
        states, outputs = run(p, times, times[-1] + 1e-3, estimator)
        for t in times[:: round(PERIOD / (times[1] - times[0]))][1:]:
            same = min(expected, key=lambda frame, t=t: abs(frame - t))
            found, right = estimates(states[t]), estimates(expected[same])
            np.testing.assert_allclose(found, right, rtol=1e-7, atol=1e-9)
        assert HOLDING not in {o.status for o in outputs.values()}


@FRAME_TIMES
@pytest.mark.parametrize("speed_observer", SPEED_OBSERVERS)
def test_nor_does_it_with_any_speed_observer(speed_observer, frame_time):
    p = parameters("gradient", frame_time=frame_time, speed_observer=1 + list(SPEED_OBSERVERS).index(speed_observer))
    expected, _ = run(p, np.arange(75) * PERIOD, 1.5, "gradient")
    states, _ = run(p, STEPS["5 ms"], 1.5, "gradient")
    np.testing.assert_allclose(
        [estimates(states[t])[:-1] for t in STEPS["5 ms"][::4]],
        [estimates(s)[:-1] for s in expected.values()],
        rtol=1e-6,
    )


@given(st.lists(st.floats(1e-4, 0.018), min_size=40, max_size=120))
def test_irregular_steps_with_stamps(steps):
    """Any steps that are no longer than a frame period: the same estimates, from the stamps alone."""
    times = [0.0, *np.cumsum(steps)]
    p = parameters(frame_time=STAMPED)
    states, _ = run(p, times[:-1], times[-1])
    last = max(states)
    taken = int(last / PERIOD + 1e-9)
    expected, _ = run(p, np.arange(taken + 1) * PERIOD, (taken + 1) * PERIOD)
    np.testing.assert_allclose(estimates(states[last]), estimates(expected[max(expected)]), rtol=1e-6, atol=1e-9)


def test_a_latency_costs_the_prediction_over_it_and_no_more():
    """The estimates at the stamps are the same; the outputs predict from there, wrong by the latency squared."""
    p = parameters(frame_time=STAMPED)
    times = np.arange(75) * PERIOD
    at_once, _ = run(p, times, 1.5)
    late, outputs = run(p, times, 1.5, latency=5 * PERIOD)
    for k in range(6, 75):
        np.testing.assert_allclose(estimates(late[times[k]]), estimates(at_once[times[k - 5]]), rtol=1e-6, atol=1e-9)
    assert {o.status for t, o in outputs.items() if t > 0.2} <= {CAPTURING, TRACKING}
    shown = np.array([[o.delta, o.omega] for o in outputs.values()])[40:-1]
    error = shown - SOLUTION.machine[:2, 41:75].T
    # P changes by up to 1.8 pu in 0.1 s here: b0 dP h/2 and b0 dP h^2/6, with b0 = 5.4 rad/s^2
    assert np.abs(error[:, 0]).max() < 0.025 and np.abs(error[:, 1]).max() < 0.5


def test_frames_out_of_order_change_nothing():
    p = parameters(frame_time=STAMPED)
    state, o = observer.start("robust", floats, p, at(FRAMES[0], 0.0), 0.0)
    shuffled, again = observer.start("robust", floats, p, at(FRAMES[0], 0.0), 0.0)
    for k in range(40):
        t = k * PERIOD
        state, o = observer.step("robust", floats, p, state, at(FRAMES[k], t), t, PERIOD)
        shuffled, _ = observer.step("robust", floats, p, shuffled, at(FRAMES[k], t), t, PERIOD / 2)
        old = at(FRAMES[max(k - 3, 0)], max(k - 3, 0) * PERIOD)
        shuffled, again = observer.step("robust", floats, p, shuffled, old, t + PERIOD / 2, PERIOD / 2)
    assert estimates(shuffled) == pytest.approx(estimates(state), rel=1e-9)
    assert tree.leaves(again) == pytest.approx(tree.leaves(o), rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("master", ["Jacobi", "Gauss-Seidel"])
def test_the_order_of_the_master_does_not_matter_to_a_stamped_frame(master):
    """Who steps the PMU first hands over the frame of t + h for the step from t: stamped, it is not misdated."""
    p = parameters(frame_time=STAMPED)
    lead = 1 if master == "Gauss-Seidel" else 0
    state, o = observer.start("robust", floats, p, at(FRAMES[0], 0.0), 0.0)
    for k in range(40):
        i = k + lead
        state, o = observer.step("robust", floats, p, state, at(FRAMES[i], i * PERIOD), k * PERIOD, PERIOD)
    expected, _ = observer.start("robust", floats, p, at(FRAMES[lead], lead * PERIOD), lead * PERIOD)
    for k in range(lead, 40 + lead):
        expected, _ = observer.step("robust", floats, p, expected, at(FRAMES[k], k * PERIOD), k * PERIOD, PERIOD)
    assert estimates(state) == pytest.approx(estimates(expected), rel=1e-6, abs=1e-9)
    assert o.status == TRACKING


@FRAME_TIMES
@pytest.mark.parametrize("start", [-1.0, 1.7e9])
def test_the_start_time_does_not_matter(start, frame_time):
    """With stamps, as far as the clock tells the times apart: 2.4e-7 s at 1.7e9 s, of 20 ms 1.2e-5."""
    p = parameters(frame_time=frame_time)
    found = []
    for t0 in (0.0, start):
        state, _ = observer.start("robust", floats, p, at(FRAMES[0], t0), t0)
        for k in range(60):
            inputs = at(FRAMES[k], t0 + k * PERIOD)
            state, _ = observer.step("robust", floats, p, state, inputs, t0 + k * PERIOD, PERIOD)
        found.append([*state.estimate.x, state.rotor.delta, state.rotor.omega])
    clock = 1e-9 if frame_time == ARRIVAL or start < 1e6 else 1e-3
    assert found[1] == pytest.approx(found[0], abs=clock)


@pytest.mark.parametrize("offset", [-1.7e9, -20.0, 0.5, 86_400.0, nan, inf])
def test_a_stamp_of_another_clock_is_no_frame(offset):
    p = parameters(frame_time=STAMPED)
    state, o = observer.start("robust", floats, p, at(FRAMES[0], offset), 0.0)
    for k in range(5):
        state, o = observer.step("robust", floats, p, state, at(FRAMES[k], k * PERIOD + offset), k * PERIOD, PERIOD)
    assert o.status == WAITING
    assert all(abs(leaf) < inf for leaf in tree.leaves(state))


@FRAME_TIMES
def test_no_frame_for_longer_than_one_and_a_half_periods(frame_time):
    """Rows missing, no sign of it in the values: holding from 1.5 periods on, and the standard deviations grow."""
    p = parameters(frame_time=frame_time)
    times = np.arange(0, 1.5, 1e-3)
    _, outputs = run(p, times, 1.5, count=41)  # the last frame is that of 0.8 s
    for t, o in outputs.items():
        if t > 0.2 and abs(t - 0.8 - 1.5 * PERIOD) > 1e-6:
            # arrival: after a second of it the repeated frame is believed, and still marked
            assert (o.status == HOLDING) == (t > 0.8 + 1.5 * PERIOD), t
    shown = list(outputs.values())
    before, later = shown[829], shown[1300]
    for name in ("delta_std", "omega_std", "e1d_std", "e1q_std"):
        assert getattr(later, name) > 3 * getattr(before, name)


@pytest.mark.parametrize("frame_period", [0.0, PERIOD])
def test_the_frame_period_is_learnt(frame_period):
    """From frames at 1 ms steps, with a fifth of them lost: 20 ms, so that 30 ms without a frame are a gap."""
    p = parameters(frame_time=STAMPED, frame_period=frame_period)
    state, o = observer.start("robust", floats, p, at(FRAMES[0], 0.0), 0.0)
    held = []
    for i in range(1400):
        t = i * 1e-3
        k = int(t / PERIOD + 1e-9)
        k -= k % 5 == 4  # lost
        state, o = observer.step("robust", floats, p, state, at(FRAMES[k], k * PERIOD), t, 1e-3)
        held.append((round(t + 1e-3 - k * PERIOD, 6), o.status == HOLDING))
    assert gating.frame_period(floats, p, state.gate) == pytest.approx(PERIOD, rel=0.03)
    for since, holding in held[400:]:
        if abs(since - 1.5 * PERIOD) > 1e-3:  # what is learnt is within 3 % of it
            assert holding == (since > 1.5 * PERIOD)


P_M = 6.5
_, AT_REST = smib.start(
    floats,
    smib.Parameters(machine=machine_of(CASE.machine), x_line=0.03, start_mode=smib.P_M_V_T, V_t_start=1.05),
    smib.Inputs(P_m=P_M),
    0.0,
)


def steady(k, turned):
    """The frame of a machine at rest in a grid that has turned."""
    angles = {name: (getattr(AT_REST.frame, name) + turned + pi) % (2 * pi) - pi for name in ("theta_t", "phi_t")}
    return observer.Inputs(AT_REST.frame._replace(**angles), P_M, AT_REST.E_f_start, t_frame=k * PERIOD)


@pytest.mark.parametrize("step", [PERIOD, 1e-3])
def test_a_clock_step_heals_although_the_frames_stay_the_same(step):
    """Half a radian at once, then bit-identical frames of a machine at rest: the speed that it suggests is wrong."""
    p = parameters(tve=1e-3)
    state, o = observer.start("robust", floats, p, steady(0, 0.0), 0.0)
    for i in range(round(4.0 / step)):
        t = i * step
        k = int(t / PERIOD + 1e-9)
        angle = 0.5 if k >= 100 else 1e-6 * (k % 2)  # the frames before differ
        state, o = observer.step("robust", floats, p, state, steady(k, angle), t, step)
    assert abs(o.omega) < 0.05


@pytest.mark.parametrize("turns", [0.2, 0.3, 0.45, -0.45])
@pytest.mark.parametrize("rate", [1, 10])
def test_up_to_nearly_half_a_turn_a_frame(rate, turns):
    """From nothing, at 1 and 10 frames/s: an angle is unambiguous up to half a turn."""
    period = 1 / rate
    omega = 2 * pi * turns * rate
    p = parameters(tve=1e-3, frame_period=period, mechanical_power=2)
    state, o = observer.start("robust", floats, p, steady(0, 0.0), 0.0)
    for k in range(60):
        inputs = steady(k, omega * period * k)
        state, o = observer.step("robust", floats, p, state, inputs, k * period, period)
    assert o.omega == pytest.approx(omega, rel=1e-3)


UNUSED = {
    "P, Q with phasors": ({"power_source": 2}, {"P_t": nan, "Q_t": nan}, {}),
    "phi with P, Q": ({}, {"phi_t": nan}, {}),
    "P_m estimated": ({"mechanical_power": 2}, {}, {"P_m": nan}),
    "E_f estimated": ({"field_voltage": 2}, {}, {"E_f": inf}),
    "t_frame at arrival": ({}, {}, {"t_frame": nan}),
}


@pytest.mark.parametrize("case", UNUSED)
def test_what_is_not_used_may_be_missing(case):
    values, fields, own = UNUSED[case]
    p = parameters(**values)
    spoilt, clean = [], []
    for inputs, found in (
        (lambda i: i, clean),
        (lambda i: i._replace(frame=i.frame._replace(**fields), **own), spoilt),
    ):
        state, o = observer.start("robust", floats, p, inputs(FRAMES[0]), 0.0)
        for k in range(40):
            state, o = observer.step("robust", floats, p, state, inputs(FRAMES[k]), k * PERIOD, PERIOD)
            found.append(o._replace(power_mismatch=0.0))
        assert o.status == TRACKING
        assert all(abs(leaf) < inf for leaf in tree.leaves(state))
    for a, b in zip(clean, spoilt):
        assert tree.leaves(a) == pytest.approx(tree.leaves(b), rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("missing", ["P_m", "E_f"])
def test_a_missing_machine_input_is_the_last_one_and_marked(missing):
    p = parameters()
    state, o = observer.start("robust", floats, p, FRAMES[0], 0.0)
    for k in range(60):
        inputs = FRAMES[k]._replace(**{missing: nan}) if k >= 30 else FRAMES[k]
        state, o = observer.step("robust", floats, p, state, inputs, k * PERIOD, PERIOD)
        assert (o.status == HOLDING) == (k >= 30)
    # P_m and E_f are constant in this case, so that nothing is lost
    assert [o.e1d, o.e1q] == pytest.approx(SOLUTION.machine[2:, 60], abs=1e-2)


def test_a_missing_machine_input_is_waited_for_at_the_start():
    p = parameters()
    state, o = observer.start("robust", floats, p, FRAMES[0]._replace(E_f=nan), 0.0)
    state, o = observer.step("robust", floats, p, state, FRAMES[1]._replace(E_f=nan), 0.0, PERIOD)
    assert o.status == WAITING
    state, o = observer.step("robust", floats, p, state, FRAMES[2], PERIOD, PERIOD)
    assert o.status == CAPTURING
