"""The whole observer, estimator and speed together, against its continuous equations and against the machine.

The state at the frames is of second order in h. So is what the outputs show a step later, predicted by the machine's
equations with the frame held; but it leaves out how the estimate will be corrected, and hence is of first order against
the continuous observer while that still converges.
"""

import numpy as np
import pytest

from fmu_src.pmu_observer import observer
from fmu_src.pmu_observer.carriers import floats
from fmu_src.pmu_observer.estimators import gradient
from fmu_src.pmu_observer.linear import Vector
from fmu_src.pmu_observer.machines.two_axis import constants
from fmu_src.pmu_observer.prediction import predict
from fmu_src.pmu_observer.speed import adaptive

from . import reference
from .reference import MOVING_CASE, PAPER_CASE
from .sampled import inputs_along, parameters_of, run

FINEST, DURATION, K = 2e-3, 1.6, 20.0
STRIDES = (4, 2, 1)
TIMES = np.arange(0, DURATION + FINEST / 2, FINEST)


def by_drem(machine):
    return reference.drem(machine, 1e15), lambda z: reference.gpebo_pair(z[:6], z[reference.DREM_THETA])


def by_gradient(machine):
    return reference.gradient(machine, 10.0), lambda z: complex(*z)


def shown(outputs):
    return np.array([[o.delta, o.omega, o.e1d, o.e1q] for o in outputs])


def errors(name, estimator, case):
    """Largest errors of (delta, omega, E'd, E'q) at the frames and in the outputs, for h = 8, 4 and 2 ms."""
    continuous, pair_of = estimator(case.machine)
    solution = reference.solve(case, TIMES, reference.with_speed(case, continuous, pair_of, K))
    expected = []
    for t, x, z in zip(solution.t, solution.machine.T, solution.observer.T):
        pair = pair_of(z[:-1])
        angle = reference.estimated_angle(reference.seen(case, t, x), x, pair)
        expected.append([angle, z[-1] + K * angle, pair.real, pair.imag])
    expected = np.array(expected)

    p = parameters_of(case.machine, name)._replace(k_speed=K)
    inputs = inputs_along(case, solution)
    at_frames, in_outputs = [], []
    for stride in STRIDES:
        result = run(name, p, inputs[::stride], stride * FINEST)
        states = np.array([[s.rotor.delta, s.rotor.omega, *s.estimate.x] for s in result.states])
        at_frames.append(np.abs(states - expected[::stride]).max(axis=0))
        in_outputs.append(np.abs(shown(result.outputs) - expected[::stride])[1:].max(axis=0))
    return at_frames, in_outputs


TRIALS = {
    "Proposition 2, paper": ("drem", by_drem, PAPER_CASE),
    "Proposition 2, moving": ("drem", by_drem, MOVING_CASE),
    "gradient, moving": ("gradient", by_gradient, MOVING_CASE),
}


@pytest.mark.parametrize("trial", TRIALS.values(), ids=TRIALS)
def test_the_continuous_observer_is_met(trial):
    (coarse, middle, fine), in_outputs = errors(*trial)
    np.testing.assert_allclose(coarse / middle, 4, rtol=0.15)
    np.testing.assert_allclose(middle / fine, 4, rtol=0.1)
    coarse, middle, fine = in_outputs
    assert (middle / fine > 1.8).all()


def started_from_truth(p, frame, case, h):
    """The gradient observer after its first step, with what it estimates replaced by the truth."""
    delta, omega, e1d, e1q = case.start
    true = Vector(e1d, e1q)
    state, _ = observer.start("gradient", floats, p, frame, 0.0)
    state, _ = observer.step("gradient", floats, p, state, frame, 0.0, h)
    return state._replace(
        estimator=gradient.State(true),
        estimate=state.estimate._replace(delta=delta, x=true),
        rotor=state.rotor._replace(delta=delta, omega=omega),
    )


def test_the_outputs_show_the_machine_to_second_order():
    """With a start from the true state, the outputs differ from the machine only by what sampling costs."""
    solution = reference.solve(MOVING_CASE, TIMES)
    inputs = inputs_along(MOVING_CASE, solution)
    p = parameters_of(MOVING_CASE.machine, "gradient")._replace(k_speed=K)
    largest = []
    for stride in STRIDES:
        h, frames = stride * FINEST, inputs[::stride]
        state = started_from_truth(p, frames[0], MOVING_CASE, h)
        outputs = []
        for k, frame in enumerate(frames[1:], 1):
            state, now = observer.step("gradient", floats, p, state, frame, k * h, h)
            outputs.append(now)
        expected = solution.machine[:, ::stride].T
        largest.append(np.abs(shown(outputs[:-1]) - expected[2:]).max(axis=0))
    coarse, middle, fine = largest
    np.testing.assert_allclose(coarse / middle, 4, rtol=0.15)
    np.testing.assert_allclose(middle / fine, 4, rtol=0.1)


def test_one_prediction():
    """From a true state, over one step: P and A held make an error of h^2 in omega and x, and of h^3 in delta."""
    p = parameters_of(MOVING_CASE.machine, "gradient")._replace(k_speed=K)
    found = []
    for h in (4e-3, 2e-3):
        solution = reference.solve(MOVING_CASE, [0.0, h])
        state = started_from_truth(p, inputs_along(MOVING_CASE, solution)[0], MOVING_CASE, h)
        outputs = predict("gradient", floats, p, constants(p.machine), state)
        found.append(np.abs(shown([outputs])[0] - solution.machine[:, -1]))
    np.testing.assert_allclose(found[0] / found[1], [8, 4, 4, 4], rtol=0.1)


def test_adaptive_speed_observer():
    """a0 and b0 change over an interval: the speed takes their mean."""
    case = MOVING_CASE._replace(machine=MOVING_CASE.machine._replace(D=0.3))
    gains = adaptive.Parameters(gamma=1e3)
    continuous = reference.speed_adaptive(case, K, 1.0, 5.0, *gains)
    continuous.start[0] += case.start[1]  # x2 = z + k x1 starts from the true speed
    solution = reference.solve(case, TIMES, continuous)
    expected = np.column_stack([solution.observer[0] + K * solution.machine[0], *solution.observer[8:]])
    inputs = inputs_along(case, solution)
    p = parameters_of(case.machine, "gradient")._replace(k_speed=K, speed_observer=2)
    p = p._replace(speed=p.speed._replace(adaptive=gains))
    largest = []
    for stride in STRIDES:
        h, frames = stride * FINEST, inputs[::stride]
        state = started_from_truth(p, frames[0], case, h)
        state = state._replace(speed=state.speed._replace(adaptive=adaptive.State(a0=1.0, b0=5.0)))
        found = []
        for k, frame in enumerate(frames[1:], 1):
            state, _ = observer.step("gradient", floats, p, state, frame, k * h, h)
            found.append([state.rotor.omega, state.speed.adaptive.a0, state.speed.adaptive.b0])
        largest.append(np.abs(np.array(found) - expected[::stride][1:]).max(axis=0))
    coarse, middle, fine = largest
    np.testing.assert_allclose(coarse / middle, 4, rtol=0.15)
    np.testing.assert_allclose(middle / fine, 4, rtol=0.1)
