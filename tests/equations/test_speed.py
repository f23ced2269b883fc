"""The speed observers on the true rotor angle, against their continuous equations; halving h divides the error by 4."""

import numpy as np
import pytest

from fmu_src.pmu_observer.carriers import floats
from fmu_src.pmu_observer.machines.two_axis import constants
from fmu_src.pmu_observer.phasors import measurement, signals
from fmu_src.pmu_observer.sampling import interval
from fmu_src.pmu_observer.speed import adaptive, immersion_invariance
from fmu_src.pmu_observer.speed.rotor import Rotor

from . import reference
from .reference import MOVING_CASE
from .sampled import inputs_along, inputs_of, machine_of

FINEST, DURATION = 4e-3, 3.2
K, P_M = 20.0, 4.0  # the gain, and a wrong first guess of the mechanical power
# damped, so that the estimate of a0 keeps off zero, where the package stops it
CASE = MOVING_CASE._replace(machine=MOVING_CASE.machine._replace(D=0.3))
M = CASE.machine
C = constants(machine_of(M))
CALIBRATION = adaptive.Parameters(gamma=1e3, lam=5.0, mu=1.0)
A0, B0 = 1.0, 5.0  # wrong first guesses: the machine has 1.62 and 5.42


def known(state, span, turn):
    return immersion_invariance.step_known(floats, state, C.a0, C.b0, K, span, turn)


def unknown(state, span, turn):
    return immersion_invariance.step_unknown(floats, state, C.a0, C.b0, K, span, turn)


def calibrate(state, span, turn):
    return adaptive.calibrate(floats, CALIBRATION, state, span, turn)


def omega(z, x):
    return [z[0] + K * x[0]]


def omega_and_power(z, x):
    return [z[0] + K * x[0], (z[1] + ((M.a0 + K) / 2) ** 2 * x[0]) / M.b0]


def errors(step, start, found, continuous, expected):
    times = np.arange(0, DURATION + FINEST / 2, FINEST)
    solution = reference.solve(CASE, times, continuous)
    reference_values = np.array([expected(z, x) for z, x in zip(solution.observer.T, solution.machine.T)])
    frames = [
        signals(floats, C, measurement(floats, i.frame, i.P_m, i.E_f, False)) for i in inputs_along(CASE, solution)
    ]
    largest = []
    for stride in (4, 2, 1):
        h, state, values = stride * FINEST, start, [found(start)]
        angle, seen = solution.machine[0, ::stride], frames[::stride]
        for k in range(1, len(seen)):
            state = step(state, interval(floats, C, seen[k - 1], seen[k], h), angle[k] - angle[k - 1])
            values.append(found(state))
        largest.append(np.abs(np.array(values) - reference_values[::stride]).max(axis=0))
    return largest


TRIALS = {
    "Pm known": (
        known,
        Rotor(0.0, 0.0, P_M),
        lambda state: [state.omega],
        reference.speed_known(CASE, K),
        omega,
    ),
    "Pm unknown": (
        unknown,
        Rotor(0.0, 0.0, P_M),
        lambda state: [state.omega, state.P_m],
        reference.speed_unknown(CASE, K, P_M),
        omega_and_power,
    ),
    "a0 and b0 unknown": (
        calibrate,
        adaptive.State(a0=A0, b0=B0),
        lambda state: [state.a0, state.b0],
        reference.speed_adaptive(CASE, K, A0, B0, *CALIBRATION),
        lambda z, x: z[8:],
    ),
}


@pytest.mark.parametrize("trial", TRIALS.values(), ids=TRIALS)
def test_second_order_in_h(trial):
    coarse, middle, fine = errors(*trial)
    np.testing.assert_allclose(coarse / middle, 4, rtol=0.1)
    np.testing.assert_allclose(middle / fine, 4, rtol=0.05)


def final(case, continuous, expected, duration):
    solution = reference.solve(case, [0.0, duration], continuous)
    return expected(solution.observer[:, -1], solution.machine[:, -1]), solution.machine[1, -1]


def test_the_continuous_observers_converge():
    """The equations above are those of observers: speed, power and constants come out right."""
    (speed,), swing = final(CASE, reference.speed_known(CASE, K), omega, 2.0)
    assert speed == pytest.approx(swing, abs=1e-9)
    steady = CASE._replace(P_m=lambda t: 5.0)
    (speed, power), swing = final(steady, reference.speed_unknown(steady, K, P_M), omega_and_power, 4.0)
    assert (speed, power) == pytest.approx((swing, 5.0), abs=1e-9)
    adapting = reference.speed_adaptive(CASE, K, A0, B0, gamma=1e5, lam=5.0, mu=1.0)
    constants_found, _ = final(CASE, adapting, lambda z, x: z[8:], 15.0)
    # the filters' start from zero is forgotten like e^-t
    assert constants_found == pytest.approx([M.a0, M.b0], abs=1e-5)


@pytest.mark.parametrize("k", [1e-3, 80.0, 1e4])
@pytest.mark.parametrize("step", [immersion_invariance.step_known, immersion_invariance.step_unknown])
def test_no_gain_is_unstable(step, k):
    """In steady state and at 5 frames/s an error of the speed only gets smaller."""
    i = inputs_of(reference.seen(CASE, 0.0, CASE.start))
    at_rest = i._replace(P_m=i.frame.P_t)
    s = signals(floats, C, measurement(floats, at_rest.frame, at_rest.P_m, at_rest.E_f, False))
    state, speeds = Rotor(0.0, 1.0, at_rest.P_m), [1.0]
    for _ in range(50):
        state = step(floats, state, C.a0, C.b0, k, interval(floats, C, s, s, 0.2), 0.0)
        speeds.append(state.omega)
    assert max(abs(speed) for speed in speeds) <= 1 and abs(speeds[-1]) < (1e-9 if k > 1 else 1)
