"""A whole step of the Kalman speed observer, and its start, against matrices."""

import numpy as np
import pytest
from scipy.linalg import expm

from fmu_src.pmu_observer import noise
from fmu_src.pmu_observer.angle import Estimate
from fmu_src.pmu_observer.carriers import floats
from fmu_src.pmu_observer.linear import Vector
from fmu_src.pmu_observer.machines.data import ieee39_g6
from fmu_src.pmu_observer.machines.two_axis import constants
from fmu_src.pmu_observer.phasors import Measurement, signals
from fmu_src.pmu_observer.sampling import interval
from fmu_src.pmu_observer.speed import Settings, kalman
from fmu_src.pmu_observer.speed.rotor import ACCELERATION_WALK, Rotor, RotorCovariance

C, H = constants(ieee39_g6()._replace(D=1.0)), 0.02
TVE, TURN, TURN_VARIANCE = 0.002, 0.03, 4e-5


def measured(P, P_m):
    return signals(floats, C, Measurement(0.3, 1.03, P / 1.03, P, 0.0, P_m, 2.2, tve=TVE))


SPAN = interval(floats, C, measured(6.0, 6.6), measured(6.1, 6.9), H)
DENSE = np.array([[2e-4, 1e-4, 1e-5], [1e-4, 3e-2, 2e-5], [1e-5, 2e-5, 7e-3]])


@pytest.mark.parametrize("inertia", [34.8, 500.0])  # s; on 100 MVA, so that b0 is above and below 1
@pytest.mark.parametrize("known", [True, False])
def test_a_step(known, inertia):
    """Predict with the mean of P and P_m; take out the estimator's correction; then the angle of j E'."""
    c = constants(ieee39_g6()._replace(D=1.0, H=inertia))
    P0 = DENSE * (np.outer([1, 1, 0], [1, 1, 0]) if known else 1)
    own = RotorCovariance(P0[0, 0], P0[0, 1], P0[1, 1], P0[0, 2], P0[1, 2], P0[2, 2])
    rotor = Rotor(0.9, 0.4, 6.6 if known else 6.3, own)
    x = np.array([0.9, 0.4, (6.6 + 6.9) / 2 if known else 6.3])
    F = expm(np.array([[0, 1, 0], [0, -c.a0, c.b0], [0, 0, 0]]) * H)
    after = SPAN.after.measured
    Q = (after.tve * after.V * after.I) ** 2 * np.outer(F[:2, 2], F[:2, 2])
    assert SPAN.jump.P == 0
    x, P = F @ x - [*(F[:2, 2] * 6.05), 0], F @ P0 @ F.T
    P[:2, :2] += Q
    P[2, 2] += 0.0 if known else ACCELERATION_WALK**2 * H / c.b0**2
    x[0] -= TURN
    P[0, 0] += TURN_VARIANCE

    angle = x[0] + 0.01
    R = TVE**2 * (1.03**2 + (c.x * after.I) ** 2) / (2 * SPAN.after.Y1)
    K = P[:, 0] / (P[0, 0] + R)
    estimate = Estimate(angle, Vector(0.5, 1.0), turn=TURN, turn_variance=TURN_VARIANCE)
    found, own = kalman.step(floats, kalman.Parameters(), c, rotor, (), SPAN, estimate, Settings(known, 80.0))
    x = x + K * 0.01
    np.testing.assert_allclose(found[:3], [x[0], x[1], 6.9 if known else x[2]], rtol=1e-8)
    P, q = P - np.outer(K, P[0]), found.covariance
    np.testing.assert_allclose(
        [q.dd, q.do, q.oo, q.dp, q.op, q.pp], [P[0, 0], P[0, 1], P[1, 1], *P[2]], rtol=1e-6, atol=1e-15
    )
    assert found.innovation == pytest.approx(
        0.01 / np.sqrt((F @ P0 @ F.T)[0, 0] + Q[0, 0] + TURN_VARIANCE + R), rel=1e-6
    )
    assert own == ()


@pytest.mark.parametrize("known", [True, False])
def test_a_start(known):
    s = SPAN.before
    rotor, own = kalman.start(floats, C, s, Estimate(0.7, Vector(0.5, 1.0)), Settings(known, 80.0))
    assert (rotor.delta, rotor.omega, rotor.P_m, own) == (0.7, 0.0, 6.6 if known else 6.0, ())
    dd = noise.of_phasor(s) / (2 * s.Y1)
    assert rotor.covariance == pytest.approx((dd, 0.0, 9.0, 0.0, 0.0, 0.0 if known else (14.0 / C.b0) ** 2), rel=1e-12)
