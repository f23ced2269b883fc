"""Each rule that decides on a frame, on both sides of its boundary, against values made by hand."""

from math import inf, nan

import numpy as np
import pytest
from scipy.linalg import expm

from fmu_src.pmu_observer import gating, observer
from fmu_src.pmu_observer.angle import Covariance, Estimate
from fmu_src.pmu_observer.carriers import floats
from fmu_src.pmu_observer.gating import Gate, Received, Timing
from fmu_src.pmu_observer.gaussian import Gaussian
from fmu_src.pmu_observer.linear import IDENTITY, Complex, Propagation, Vector
from fmu_src.pmu_observer.machines.data import ieee39_g6
from fmu_src.pmu_observer.machines.two_axis import constants
from fmu_src.pmu_observer.observer_interface import ARRIVAL, ESTIMATED, PHASORS, STAMPED, Inputs, Parameters
from fmu_src.pmu_observer.phasors import Frame, measurement, signals
from fmu_src.pmu_observer.sampling import Interval, Jump, interval
from fmu_src.pmu_observer.speed.rotor import Rotor, RotorCovariance
from fmu_src.pmu_observer.transition import transition

G6 = ieee39_g6()._replace(D=0.0)
C = constants(G6)
TVE = 0.002
V, THETA, I, PHI = 1.03, 0.3, 6.4, 0.1  # noqa: E741 - the paper's name
S = V * I * np.exp(1j * (THETA - PHI))
FRAME = Frame(V, THETA, I, PHI, float(S.real), float(S.imag))
OTHER = FRAME._replace(V_t=1.02)
P_M, E_F = 6.5, 2.2
SIGNALS = signals(floats, C, measurement(floats, FRAME, P_M, E_F, False)._replace(tve=TVE))


def parameters(**values):
    return Parameters(machine=G6)._replace(**values)


def received(frame=FRAME, complete=1.0):
    return Received(SIGNALS, frame, 1.0, complete, 0.0)


# The clock --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("t_frame", "possible"),
    [(100.0, True), (90.001, True), (89.999, False), (100.029, True), (100.031, False), (nan, False), (inf, False)],
)
def test_a_stamp_is_at_most_10_s_old_and_a_step_and_10_ms_ahead(t_frame, possible):
    inputs = Inputs(t_frame=t_frame)
    stamped, arrival = parameters(frame_time=STAMPED), parameters(frame_time=ARRIVAL)
    assert gating.is_of_this_clock(floats, stamped, inputs, 100.0, 0.02) == possible
    assert gating.is_of_this_clock(floats, arrival, inputs, 100.0, 0.02)


@pytest.mark.parametrize(
    ("period", "interval", "learnt"),
    [(0.0, 0.02, 0.02), (1.0, 1.04, 1.03), (1.0, 1.02, 1.0), (1.0, 0.98, 1.0), (1.0, 0.96, 1 / 1.03), (1.0, 9.0, 1.03)],
)
def test_the_period_moves_by_3_percent_at_most(period, interval, learnt):
    assert gating.learnt_period(floats, period, interval) == pytest.approx(learnt, rel=1e-12)


@pytest.mark.parametrize(
    ("given", "learnt", "waited", "overdue"),
    [
        (0.02, 0.0, 0.0301, True),
        (0.02, 0.0, 0.0299, False),
        (0.0, 0.02, 0.0301, True),
        (0.0, 0.02, 0.0299, False),
        (0.05, 0.02, 0.07, False),  # what is given counts
        (0.0, 0.0, 100.0, False),
    ],
)
def test_overdue_after_one_and_a_half_periods(given, learnt, waited, overdue):
    gate = Gate(period=learnt)
    assert gating.is_overdue(floats, parameters(frame_period=given), gate, waited) == overdue


@pytest.mark.parametrize("field", Frame._fields)
def test_a_frame_is_the_same_if_all_of_it_is(field):
    assert gating.is_same(floats, FRAME, Frame(*FRAME))
    assert not gating.is_same(floats, FRAME, FRAME._replace(**{field: 1e-9 + getattr(FRAME, field)}))


# When was it measured, and is it new? -----------------------------------------------------------------------------

GATE = Gate(frame=FRAME, t_frame=4.98, unchanged=0.02, period=0.02)
TURNING, STILL = 6e-3, 4e-3
"""rad/s: in 20 ms more and less than 1e-4 rad."""


@pytest.mark.parametrize("turning", [TURNING, -TURNING, 1.0])
def test_a_frame_that_differs_is_new_at_once(turning):
    for elapsed in (1e-3, 0.02, 3.0):
        found = gating.timing(floats, parameters(), GATE, received(OTHER), 0.0, 5.0, 1e-3, elapsed, turning)
        assert found == Timing(h=elapsed, latency=0.0, new=1.0, doubtful=0.0)


@pytest.mark.parametrize(
    ("elapsed", "h", "omega", "gate", "new", "latency", "doubtful"),
    [
        (0.02, 0.02, TURNING, {}, 0, 0.0, 1),
        (0.02, 0.02, -TURNING, {}, 0, 0.0, 1),
        (0.02, 0.02, STILL, {}, 1, 0.0, 0),
        (0.02, 0.02, -STILL, {}, 1, 0.0, 0),
        # due from 0.95 periods on, if the next communication point is beyond 1.05
        (0.0189, 0.02, 0.0, {}, 0, 0.0, 0),
        (0.0191, 0.02, 0.0, {}, 1, 0.0, 0),
        (0.0199, 1e-3, 0.0, {}, 0, 0.0, 0),
        (0.0201, 1e-3, 0.0, {}, 1, 1e-4, 0),
        # dated a period after the last one, up to 1.5 periods
        (0.0299, 1e-3, 0.0, {}, 1, 0.0099, 0),
        (0.0301, 1e-3, 0.0, {}, 1, 0.0, 0),
        # after a frame that was not believed, and after a second of them
        (0.02, 0.02, 0.0, {"held": 1.0}, 0, 0.0, 1),
        (0.02, 0.02, TURNING, {"unchanged": 0.99}, 0, 0.0, 1),
        (0.02, 0.02, TURNING, {"unchanged": 1.01}, 1, 0.0, 1),
        (0.0189, 0.02, TURNING, {"unchanged": 1.01}, 0, 0.0, 1),
        # frames that never differed
        (0.02, 0.02, TURNING, {"period": 0.0}, 1, 0.0, 0),
        (0.02, 0.02, 0.0, {"period": 0.0, "held": 1.0}, 1, 0.0, 0),
        (0.02, 0.0, 0.0, {"period": 0.0}, 1, 0.0, 0),
    ],
)
def test_the_same_frame_again(elapsed, h, omega, gate, new, latency, doubtful):
    gate = GATE._replace(**gate)
    found = gating.timing(floats, parameters(), gate, received(), 0.0, 5.0, h, elapsed, omega)
    assert (found.new, found.doubtful) == (new, doubtful)
    if new:
        assert found.latency == pytest.approx(latency, abs=1e-12)
        assert found.h == pytest.approx(elapsed - latency, abs=1e-12)


@pytest.mark.parametrize(("later", "new"), [(0.02, 1), (1.1e-5, 1), (0.9e-5, 0), (0.0, 0), (-0.02, 0)])
@pytest.mark.parametrize("frame", [FRAME, OTHER])
def test_a_stamp_that_has_grown_is_new(frame, later, new):
    p, t_frame = parameters(frame_time=STAMPED), 4.98 + later
    found = gating.timing(floats, p, GATE, received(frame), t_frame, 5.1, 0.02, 0.14, 1.0)
    assert (found.new, found.doubtful) == (new, 0)
    assert found.latency == pytest.approx(5.1 - t_frame, abs=1e-12)
    assert found.h == pytest.approx(0.14 - (5.1 - t_frame), abs=1e-12)


# What is remembered -----------------------------------------------------------------------------------------------

NEW = Timing(0.02, 0.0, 1.0, 0.0)


def test_behind_the_first_frame():
    assert gating.first(received(OTHER), 3.0) == Gate(OTHER, 3.0, 0.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("frame_time", "frame", "unchanged", "period"),
    [
        (ARRIVAL, OTHER, 0.0, 0.02 * 1.03),  # it was unchanged for 0.5 s
        (ARRIVAL, FRAME, 0.5, 0.02),
        (STAMPED, OTHER, 0.0, 0.02 / 1.03),  # 10 ms after the last one's stamp
        (STAMPED, FRAME, 0.0, 0.02 / 1.03),
    ],
)
def test_behind_a_new_frame(frame_time, frame, unchanged, period):
    p, gate = parameters(frame_time=frame_time), GATE._replace(unchanged=0.5)
    found = gating.seen(floats, p, gate, received(frame), NEW, 4.99, False)
    assert found._replace(period=0.0) == Gate(frame, 4.99, unchanged, 0.0, 0.0, 0.0)
    assert found.period == pytest.approx(period, rel=1e-12)


@pytest.mark.parametrize(
    ("rejected", "gross", "after"), [(0.0, False, 0.0), (0.1, False, 0.0), (1.5, False, 1.25), (0.75, True, 1.75)]
)
def test_a_good_frame_makes_up_for_a_quarter_of_a_gross_one(rejected, gross, after):
    gate = GATE._replace(rejected=rejected, held=1.0)
    found = gating.seen(floats, parameters(), gate, received(OTHER), NEW, 0.0, gross)
    assert (found.rejected, found.held) == (after, 1.0 if gross else 0.0)


def test_what_is_marked_as_held():
    def held(timing=NEW, complete=1.0):
        return gating.seen(floats, parameters(), GATE, received(OTHER, complete), timing, 0.0, False).held

    assert (held(), held(NEW._replace(doubtful=1.0)), held(complete=0.0)) == (0.0, 1.0, 1.0)


# Gross errors -----------------------------------------------------------------------------------------------------

E = (V + 1j * C.x * I * np.exp(1j * (PHI - THETA))) * np.exp(1j * THETA)
DELTA = 0.9
X = 1j * E * np.exp(-1j * DELTA)  # j E' = e^{j delta} (x3 + j x4)
SURE = Estimate(DELTA, Vector(X.real, X.imag), Covariance(dd=3e-4, qq=5e-4), E_f=E_F)
ROTOR = Rotor(DELTA, 0.0, FRAME.P_t, RotorCovariance(dd=2e-4))


def gross(turned=0.0, estimate=SURE, rotor=ROTOR, rejected=0.0, h=0.0, jump=0.0, shrunk=1.0):
    """Where the estimate is off by an angle and by a factor."""
    jump = Jump(Complex(jump * 0.6, jump * 0.8), 0.0, 0.0)
    interval = Interval(SIGNALS, SIGNALS, h, jump=jump, flow=Propagation(IDENTITY, Vector(0.0, 0.0)))
    estimate = estimate._replace(x=Vector(shrunk * X.real, shrunk * X.imag))
    rotor = rotor._replace(delta=rotor.delta + turned)
    return gating.is_gross(floats, C, Gate(rejected=rejected), interval, estimate, rotor, True)


def standard_deviation(angle=2e-4, h=0.0, jump=0.0):
    """Of j E' from where it is expected, pu: noise of frame, estimate and angle, and half a jump of A."""
    noise = TVE**2 * (V**2 + (C.x * I) ** 2)
    half = max(C.b1, C.b2) * h / 2 * jump
    return (noise + 2 * (3e-4 + 5e-4) + abs(E) ** 2 * (2 * angle + half**2 + 0.002**2)) ** 0.5


@pytest.mark.parametrize(("h", "jump"), [(0.0, 0.0), (1e-3, 0.0), (1e-3, 40.0)])
def test_gross_beyond_5_standard_deviations(h, jump):
    five = 5 * standard_deviation(h=h, jump=jump) / abs(E)
    for factor, expected in ((0.9999, False), (1.0001, True)):
        assert gross(shrunk=1 - factor * five, h=h, jump=jump) == expected
        for sign in (1, -1):
            assert gross(turned=sign * 2 * np.arcsin(factor * five / 2), h=h, jump=jump) == expected


def test_the_jump_counts():
    """Else the test above would be one without it: half the jump is as large as all the rest."""
    assert standard_deviation(h=1e-3, jump=40.0) > 1.2 * standard_deviation()


def test_only_who_is_sure_rejects():
    assert gross(turned=1.0)
    assert gross(turned=1.0, estimate=SURE._replace(capturing=0.4))
    assert not gross(turned=1.0, estimate=SURE._replace(capturing=0.6))
    assert not gross(turned=1.0, estimate=SURE._replace(covariance=Covariance()))
    assert not gross(turned=1.0, rotor=ROTOR._replace(covariance=RotorCovariance()))


def test_the_third_in_a_row_is_believed():
    assert gross(turned=1.0, rejected=1.75)
    assert not gross(turned=1.0, rejected=2.0)


# What has come ----------------------------------------------------------------------------------------------------

LAST = SIGNALS._replace(measured=SIGNALS.measured._replace(P_m=5.0, E_f=1.5))


def receive(p=Parameters(machine=G6), started=True, frame_valid=1.0, P_m=P_M, E_f=E_F, t_frame=0.0, **fields):  # noqa: B008 - immutable
    inputs = Inputs(FRAME._replace(**fields), P_m, E_f, frame_valid, t_frame)
    estimate, rotor = SURE._replace(E_f=1.7), ROTOR._replace(P_m=5.5)
    return gating.receive(floats, p, C, inputs, 100.0, 0.02, started, LAST, estimate, rotor, TVE)


def test_a_good_frame():
    r = receive()
    assert (r.usable, r.complete, r.frame) == (1.0, 1.0, FRAME)
    assert r.signals == SIGNALS
    assert r.power_mismatch == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("field", ["V_t", "theta_t", "I_t", "P_t", "Q_t"])
@pytest.mark.parametrize("value", [nan, inf, 1.1e9])
def test_what_is_used_must_be_a_number(field, value):
    r = receive(**{field: value})
    assert r.usable == 0 and r.frame == Frame(1.0, 1.0, 1.0, 1.0, 1.0, 1.0)


def test_unusable():
    assert receive(frame_valid=0.0).usable == 0
    assert receive(V_t=0.9e-3, P_t=0.0, Q_t=0.0, I_t=0.0).usable == 0
    stamped = Parameters(machine=G6, frame_time=STAMPED)
    assert receive(stamped, t_frame=99.0).usable == 1 and receive(stamped, t_frame=80.0).usable == 0


def test_phasors_alone():
    p = Parameters(machine=G6, power_source=PHASORS)
    r = receive(p, P_t=nan, Q_t=nan)
    assert (r.usable, r.frame, r.power_mismatch) == (1.0, FRAME._replace(P_t=0.0, Q_t=0.0), 0.0)
    np.testing.assert_allclose([r.signals.measured.P, r.signals.measured.Q], [S.real, S.imag], rtol=1e-12)
    assert receive(p, phi_t=nan).usable == 0


def test_the_current_angle_may_be_missing():
    r = receive(phi_t=nan, P_t=6.0)
    assert (r.usable, r.frame, r.power_mismatch) == (1.0, FRAME._replace(phi_t=0.0, P_t=6.0), 0.0)


def test_power_mismatch_is_the_share_of_VI():
    assert receive(P_t=S.real - 0.3, Q_t=S.imag + 0.4).power_mismatch == pytest.approx(0.5 / (V * I), rel=1e-9)


@pytest.mark.parametrize("value", [nan, inf])
def test_a_missing_machine_input(value):
    for missing, last in (("P_m", 5.0), ("E_f", 1.5)):
        r = receive(**{missing: value})
        assert (r.usable, r.complete, getattr(r.signals.measured, missing)) == (1.0, 0.0, last)
        assert receive(started=False, **{missing: value}).usable == 0
    assert receive(started=False).usable == 1


def test_estimated_machine_inputs():
    p = Parameters(machine=G6, field_voltage=ESTIMATED, mechanical_power=ESTIMATED)
    r = receive(p, P_m=nan, E_f=nan)
    m = r.signals.measured
    assert (r.usable, r.complete, m.P_m, m.E_f, m.E_f_known) == (1.0, 1.0, 5.5, 1.7, 0.0)
    assert receive().signals.measured.E_f_known == 1.0


def test_the_machine_sees_its_own_resistance():
    """V + Ra I and the power with the losses in it: what acts on the rotor."""
    machine = G6._replace(Ra=0.01)
    r = receive(Parameters(machine=machine))
    inside = V + 0.01 * I * np.exp(1j * (PHI - THETA))
    m = r.signals.measured
    np.testing.assert_allclose([m.P, m.V], [S.real + 0.01 * I**2, abs(inside)], rtol=1e-12)


# Under a machine model --------------------------------------------------------------------------------------------

MODEL = observer.constants_of("robust", "two_axis", parameters())


@pytest.mark.parametrize("nu", [Complex(3.0, 0.0), Complex(0.0, -4.0), Complex(3.0, -4.0)])
def test_a_jump_of_A_by_the_model(nu):
    """It is wrong by half of it over the interval: (b2 Re, b1 Im) h/2 on either axis, whatever the direction."""
    s = signals(floats, MODEL, SIGNALS.measured)
    h = 1e-6
    span = interval(floats, MODEL, s, s, h)
    jumped = span._replace(flow=transition(floats, MODEL, s, s, h, Jump(nu, 0.0, 0.0), 0.0))
    expected = (C.b1**2 + C.b2**2) * (h / 2) ** 2 * (nu.re**2 + nu.im**2)
    assert gating.by_jump(floats, MODEL, jumped) == pytest.approx(expected, rel=1e-3)
    assert gating.by_jump(floats, MODEL, span) == 0


def test_where_the_model_expects_it():
    """E' after 20 ms of its own equations, from its start: E_f moves E'q, and A both."""
    s, h, E_f = signals(floats, MODEL, SIGNALS.measured), 0.02, 3.0
    s = s._replace(measured=s.measured._replace(E_f=E_f))
    estimate = SURE._replace(gaussian=Gaussian((X.real, X.imag, 0.0), (0.0,) * 6))
    found = gating.expected(floats, MODEL, interval(floats, MODEL, s, s, h).flow, estimate)
    A = np.zeros((3, 3))
    A[:2, :2] = np.reshape(SIGNALS.A, (2, 2))
    A[1, 2] = C.c1
    np.testing.assert_allclose(found, (expm(A * h) @ [X.real, X.imag, E_f])[:2], rtol=1e-8)
