"""What the observer shows, term by term, of a state made by hand, against phasors and closed forms."""

import numpy as np
import pytest

from fmu_src.pmu_observer import observer
from fmu_src.pmu_observer.angle import Covariance
from fmu_src.pmu_observer.carriers import floats
from fmu_src.pmu_observer.confidence import MeanSquares
from fmu_src.pmu_observer.gating import Gate
from fmu_src.pmu_observer.gaussian import Gaussian
from fmu_src.pmu_observer.linear import Vector
from fmu_src.pmu_observer.machines.data import ieee39_g6
from fmu_src.pmu_observer.machines.two_axis import constants
from fmu_src.pmu_observer.observer_interface import CAPTURING, ESTIMATED, HOLDING, TRACKING, Inputs, Outputs
from fmu_src.pmu_observer.phasors import Frame
from fmu_src.pmu_observer.prediction import predict
from fmu_src.pmu_observer.speed import adaptive
from fmu_src.pmu_observer.speed.rotor import OMEGA_WALK, RotorCovariance

RA = 0.01
MACHINE = ieee39_g6()._replace(Ra=RA, D=0.5)
TERMINAL, CURRENT = 1.03 * np.exp(0.3j), 6.4 * np.exp(0.1j)
S = TERMINAL * np.conj(CURRENT)
FRAME = Frame(1.03, 0.3, 6.4, 0.1, float(S.real), float(S.imag))
P = observer.Parameters(machine=MACHINE, frame_period=0.02, field_voltage=ESTIMATED, mechanical_power=ESTIMATED)
C = observer.constants_of("robust", "two_axis", P)
X, DELTA, OMEGA, P_M, E_F = Vector(0.58, 1.04), 0.9, 0.7, 6.2, 2.3
COVARIANCE, E_F_VARIANCE = Covariance(3e-4, 1e-4, 5e-4), 4e-2
GAUSSIAN = Gaussian((*X, E_F), (COVARIANCE.dd, COVARIANCE.dq, 2e-5, COVARIANCE.qq, 1e-5, E_F_VARIANCE))
ROTOR = RotorCovariance(2e-4, 1e-4, 3e-2, 1e-5, 2e-5, 7e-3)


def state(elapsed=0.0, **values):
    s, _ = observer.start("robust", floats, P, Inputs(FRAME, P_M, E_F), 0.0)
    s, _ = observer.step("robust", floats, P, s, Inputs(FRAME, P_M, E_F), 0.0, elapsed)
    s = s._replace(
        estimate=s.estimate._replace(
            delta=DELTA,
            x=X,
            covariance=COVARIANCE,
            gaussian=GAUSSIAN,
            E_f=E_F,
            E_f_walk=0.0,
            innovation=1.2,
            capturing=0.0,
        ),
        rotor=s.rotor._replace(delta=DELTA, omega=OMEGA, P_m=P_M, covariance=ROTOR, innovation=-1.5),
        gate=Gate(frame=FRAME, period=0.02),
        mean_squares=MeanSquares(radial=4.0, angle=9.0),
        power_mismatch=0.25,
    )
    return s._replace(**values)


def shown(s, p=P) -> Outputs:
    return predict("robust", floats, p, C, s)


def test_at_the_frame_the_estimate_itself():
    o = shown(state())
    found = (o.delta, o.omega, o.e1d, o.e1q, o.e2d, o.e2q, o.E_f_hat, o.P_m_hat)
    assert found == pytest.approx((DELTA, OMEGA, X.d, X.q, 0.0, 0.0, E_F, P_M), rel=1e-9)
    # the load angle is that to the terminal, before the resistance
    assert o.load_angle == pytest.approx(DELTA - 0.3, rel=1e-9)
    assert (o.innovation, o.angle_innovation, o.power_mismatch, o.status) == (1.2, -1.5, 0.25, TRACKING)


def test_standard_deviations_at_the_frame_grow_with_the_innovations():
    o = shown(state())
    direction = np.array([X.q, -X.d]) / (X.d**2 + X.q**2)
    dense = np.array([[COVARIANCE.dd, COVARIANCE.dq], [COVARIANCE.dq, COVARIANCE.qq]])
    variances = {
        "delta_std": 9 * ROTOR.dd + 4 * direction @ dense @ direction,
        "omega_std": 9 * ROTOR.oo,
        "P_m_std": 9 * ROTOR.pp,
        "e1d_std": 4 * COVARIANCE.dd,
        "e1q_std": 4 * COVARIANCE.qq,
        "E_f_std": 4 * E_F_VARIANCE,
    }
    for name, variance in variances.items():
        assert getattr(o, name) ** 2 == pytest.approx(variance, rel=1e-9), name
    perfect = shown(state(mean_squares=MeanSquares(radial=0.5, angle=0.5)))  # not smaller than the covariance says
    assert perfect.omega_std**2 == pytest.approx(ROTOR.oo, rel=1e-9)
    assert perfect.e1d_std**2 == pytest.approx(COVARIANCE.dd, rel=1e-9)


@pytest.mark.parametrize(("held", "unchanged", "repeated"), [(1.0, 0.8, 0.8), (0.0, 0.8, 0.0), (1.0, 0.0, 0.0)])
def test_a_repeated_frame_that_is_believed_leaves_a_doubt(held, unchanged, repeated):
    """omega walks while the frames repeat: q t in it, q t^3/3 in delta."""
    before = shown(state())
    after = shown(state(gate=Gate(frame=FRAME, period=0.02, unchanged=unchanged, held=held)))
    q = OMEGA_WALK**2
    assert after.omega_std**2 - before.omega_std**2 == pytest.approx(q * repeated, rel=1e-9)
    assert after.delta_std**2 - before.delta_std**2 == pytest.approx(q * repeated**3 / 3, rel=1e-9)


def test_only_the_time_before_the_frame_was_repeated():
    """What has elapsed since is in the covariance's own prediction."""
    gate = Gate(frame=FRAME, period=0.02, held=1.0)
    base, later = (shown(state(elapsed=0.3, gate=gate._replace(unchanged=u))) for u in (0.3, 0.8))
    assert later.omega_std**2 - base.omega_std**2 == pytest.approx(OMEGA_WALK**2 * 0.5, rel=1e-9)


def test_who_does_not_know_shows_no_standard_deviation():
    s = state()
    o = shown(s._replace(estimate=s.estimate._replace(covariance=Covariance())))
    assert (o.e1d_std, o.e1q_std, o.E_f_std) == (0.0, 0.0, 0.0) and o.omega_std > 0
    o = shown(s._replace(rotor=s.rotor._replace(covariance=RotorCovariance())))
    assert (o.delta_std, o.omega_std, o.P_m_std) == (0.0, 0.0, 0.0) and o.e1d_std > 0


def test_a_measured_field_voltage_has_none():
    s = state()
    measured = s.signals._replace(measured=s.signals.measured._replace(E_f_known=1.0))
    assert shown(s._replace(signals=measured)).E_f_std == 0 < shown(s).E_f_std


def test_an_estimated_field_voltage_walks_on():
    s = state(elapsed=0.05)
    walking = s._replace(estimate=s.estimate._replace(E_f_walk=0.3))
    assert shown(walking).E_f_std ** 2 == pytest.approx(4 * (E_F_VARIANCE + 0.3 * 0.05), rel=1e-9)


def test_the_papers_estimators_see_the_transient_saliency():
    """Behind x'd they see E'd + (x'q - x'd) Iq; the q axis leads by delta, and the current is that of P + jQ."""
    salient = P._replace(machine=MACHINE._replace(xq1=0.08))
    s, _ = observer.start("gradient", floats, salient, Inputs(FRAME, P_M, E_F), 0.0)
    s, _ = observer.step("gradient", floats, salient, s, Inputs(FRAME, P_M, E_F), 0.0, 0.0)
    s = s._replace(estimate=s.estimate._replace(x=X), rotor=s.rotor._replace(delta=DELTA))
    o = predict("gradient", floats, salient, constants(salient.machine), s)
    I_q = (CURRENT * np.exp(-1j * DELTA)).real
    assert (o.e1d, o.e1q) == pytest.approx((X.d - (0.08 - MACHINE.xd1) * I_q, X.q), rel=1e-9)
    assert (o.e1d_std, o.e1q_std, o.E_f_std) == (0.0, 0.0, 0.0)


def test_the_rotor_goes_on():
    """delta'' = -a0 delta' + b0 (P_m - P), P behind the resistance."""
    h = 0.05
    o = shown(state(elapsed=h))
    f, a0 = C.b0 * (P_M - S.real - RA * 6.4**2), C.a0
    assert o.omega == pytest.approx(OMEGA * np.exp(-a0 * h) + f * (1 - np.exp(-a0 * h)) / a0, rel=1e-9)
    mean = (1 - np.exp(-a0 * h)) / a0
    assert o.delta == pytest.approx(DELTA + OMEGA * mean + f * (h - mean) / a0, rel=1e-7)
    assert o.P_m_hat == P_M


def test_the_constants_are_those_that_a_speed_observer_estimates():
    h, s = 0.05, state(elapsed=0.05)
    s = s._replace(speed=s.speed._replace(adaptive=adaptive.State(a0=2.0, b0=9.0)))
    o = shown(s)
    f = 9.0 * (P_M - S.real - RA * 6.4**2)
    assert o.omega == pytest.approx(OMEGA * np.exp(-2 * h) + f * (1 - np.exp(-2 * h)) / 2, rel=1e-9)
    assert (o.speed.adaptive.a0, o.speed.adaptive.b0) == (2.0, 9.0)


@pytest.mark.parametrize(
    ("values", "capturing", "status"),
    [
        ({}, 0.4, TRACKING),
        ({}, 0.6, CAPTURING),
        ({"gate": Gate(held=1.0)}, 0.0, HOLDING),
        ({"gate": Gate(held=1.0)}, 1.0, HOLDING),
        ({"elapsed": 0.029}, 0.0, TRACKING),
        ({"elapsed": 0.031}, 0.0, HOLDING),
        ({"elapsed": 0.131, "latency": 0.1}, 0.0, HOLDING),  # 31 ms after it came
        ({"elapsed": 0.129, "latency": 0.1}, 0.0, TRACKING),
    ],
)
def test_status(values, capturing, status):
    s = state(**values)
    assert shown(s._replace(estimate=s.estimate._replace(capturing=capturing))).status == status


def test_nothing_before_the_first_frame():
    assert shown(state(started=0.0)) == Outputs()
