"""What a step does with a frame, rule by rule: not usable, the first, not new, gross, taken; and who starts again."""

from math import pi

import numpy as np
import pytest

from fmu_src.pmu_observer import confidence, noise, observer
from fmu_src.pmu_observer.carriers import floats
from fmu_src.pmu_observer.estimators import gradient
from fmu_src.pmu_observer.gating import Gate
from fmu_src.pmu_observer.linear import Vector
from fmu_src.pmu_observer.machines.data import ieee39_g6
from fmu_src.pmu_observer.observer_interface import (
    ESTIMATED,
    HOLDING,
    STAMPED,
    TRACKING,
    WAITING,
    Inputs,
    Outputs,
    Parameters,
    number,
)
from fmu_src.pmu_observer.phasors import Frame
from fmu_src.pmu_observer.sampling import change
from fmu_src.pmu_observer.speed import SPEED_OBSERVERS

MACHINE, H = ieee39_g6()._replace(D=0.5), 0.02
P = Parameters(machine=MACHINE, frame_period=H, tve=0.002)
C = observer.constants_of("robust", "two_axis", P)


def inputs(turned=0.0, share=1.0, t_frame=0.0, **values):
    """A frame of a machine whose angles and power may be other ones."""
    V, I = 1.03 * np.exp(1j * (0.3 + turned)), share * 6.4 * np.exp(1j * (0.1 + turned))  # noqa: E741 - the paper's name
    S = V * np.conj(I)
    frame = Frame(*map(float, (abs(V), np.angle(V), abs(I), np.angle(I), S.real, S.imag)))
    return Inputs(frame, 6.5, 2.2, t_frame=t_frame)._replace(**values)


def begun(p=P, name="robust", t=0.0, **values):
    state, _ = observer.start(name, floats, p, inputs(**values), t)
    return observer.step(name, floats, p, state, inputs(**values), t, H)[0]


def step(state, i, p=P, name="robust", t=H, h=H):
    return observer.step(name, floats, p, state, i, t, h)


# Not taken --------------------------------------------------------------------------------------------------------


def test_before_the_first_frame_no_time_passes():
    state, o = observer.start("robust", floats, P, inputs(), 0.0)
    assert (state.started, state.elapsed, state.latency, state.gate) == (0.0, 0.0, 0.0, Gate())
    assert (state.power_mismatch, state.rotor.delta, state.noise) == (0.0, 0.0, noise.Estimate())
    assert o.status != WAITING  # the outputs show the first frame at once
    bad, o = step(state, inputs(frame_valid=0.0))
    assert (bad.started, bad.elapsed, bad.gate.unchanged, o) == (0.0, 0.0, 0.0, Outputs())


def test_a_frame_that_is_not_usable_makes_a_longer_interval():
    state = begun()
    bad, o = step(state, inputs(turned=0.01, frame_valid=0.0), h=0.003)
    assert bad == state._replace(
        elapsed=state.elapsed + 0.003, gate=state.gate._replace(held=1.0, unchanged=state.gate.unchanged + 0.003)
    )
    assert o.status == HOLDING


def test_so_does_one_that_is_not_new():
    state = begun(turned=0.0)
    state = state._replace(gate=state.gate._replace(period=H), rotor=state.rotor._replace(omega=1.0))
    again, _ = step(state, inputs(), h=0.003)
    assert again == state._replace(
        elapsed=state.elapsed + 0.003, gate=state.gate._replace(unchanged=state.gate.unchanged + 0.003)
    )


def sure(state):
    """As of a tracker that knows where it is."""
    d, q, E_f = state.estimator.tracker.x
    scale = (state.signals.Y1 / (d * d + q * q)) ** 0.5
    x = d * scale, q * scale, E_f
    tracker = state.estimator.tracker._replace(x=x, P=(1e-6, 0.0, 0.0, 1e-6, 0.0, 0.0))
    small = observer.Rotor(state.rotor.delta, 0.0, 6.5, state.rotor.covariance._replace(dd=1e-6, oo=1e-6))
    e = state.estimate._replace(gaussian=tracker, covariance=state.estimate.covariance._replace(dd=1e-3, qq=1e-3))
    e = e._replace(capturing=0.0, x=Vector(x[0], x[1]))
    return state._replace(estimator=state.estimator._replace(tracker=tracker, tracking=1.0), estimate=e, rotor=small)


def test_a_gross_error_is_counted_and_not_taken():
    state = sure(begun())
    after, o = step(state, inputs(turned=1.0))
    gate = after.gate
    assert (gate.rejected, gate.held, gate.unchanged, gate.frame) == (1.0, 1.0, H, inputs(turned=1.0).frame)
    assert after._replace(gate=gate, elapsed=state.elapsed, power_mismatch=0.0) == state._replace(
        gate=gate, power_mismatch=0.0
    )
    assert after.elapsed == state.elapsed + H and o.status == HOLDING
    assert step(state, inputs(turned=1e-3))[1].status == TRACKING


# Taken ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("p", "latency"), [(P, 0.0), (P._replace(frame_time=STAMPED), 0.05)])
def test_the_first_frame(p, latency):
    state = begun(p, t=3.0, t_frame=2.95)
    assert state.started == 1.0
    assert (state.elapsed, state.latency) == pytest.approx((latency + H, latency), abs=1e-12)
    gate = state.gate
    assert (gate.frame, gate.t_frame, gate.unchanged) == (inputs().frame, 2.95 if latency else 0.0, H)
    F = 1.03 * np.exp(0.3j) + 1j * MACHINE.xd1 * 6.4 * np.exp(0.1j)
    f = complex(*state.estimate.x)
    assert np.exp(1j * state.rotor.delta) == pytest.approx(1j * F / abs(F) * abs(f) / f, abs=1e-9)
    assert abs(state.rotor.delta - 0.3) < pi  # of all turns, the one that is nearest to theta
    assert (state.rotor.omega, state.rotor.P_m) == (0.0, 6.5)


def test_the_first_frame_with_power_estimated():
    """It balances the electrical power."""
    p = P._replace(mechanical_power=ESTIMATED, frame_time=1)
    assert begun(p).rotor.P_m == pytest.approx(1.03 * 6.4 * np.cos(0.2), rel=1e-12)


@pytest.mark.parametrize("late", [0.0, 0.012])
def test_a_frame_taken(late):
    p = P._replace(frame_time=STAMPED)
    state = begun(p)
    i = inputs(turned=0.002, share=1.01, t_frame=H - late)
    after, _ = step(state, i, p)
    assert (after.elapsed, after.latency) == pytest.approx((H + late, late), abs=1e-12)
    assert (after.gate.frame, after.gate.t_frame, after.started) == (i.frame, H - late, 1.0)
    m, before = after.signals, state.signals
    expected = change(floats, before, m, H - late)
    assert tuple(after.change.nu) == pytest.approx(tuple(expected.nu), rel=1e-9)
    assert pytest.approx((m.measured.P - before.measured.P) / (H - late), rel=1e-9) == after.change.P
    assert after.mean_squares == confidence.observed(
        floats,
        state.mean_squares,
        after.estimate.innovation,
        after.rotor.innovation,
        after.estimate.capturing,
        H - late,
    )
    assert after.signals.measured.tve == 0.002 and after.noise == state.noise


def test_the_noise_is_learnt_where_it_is_not_given():
    p = P._replace(tve=0.0)
    state = begun(p)
    after, _ = step(state, inputs(turned=0.002), p)
    assert after.noise == noise.learn(floats, state.noise, after.signals)
    assert after.signals.measured.tve == pytest.approx(np.exp(noise.AT_FIRST / 2))
    small = state._replace(noise=noise.Estimate(log_tve2=-30.0, frames=100.0))
    assert step(small, inputs(turned=0.002), p)[0].signals.measured.tve == noise.LEAST_TVE
    assert step(begun(), inputs(turned=0.002), P._replace(tve=1e-6))[0].signals.measured.tve == noise.LEAST_TVE


@pytest.mark.parametrize("turns", [-2, 0, 1])
def test_the_angle_is_the_one_nearest_to_the_rotors(turns):
    state = begun(P._replace(speed_observer=1), "gradient")
    state = state._replace(rotor=state.rotor._replace(delta=state.rotor.delta + 2 * pi * turns, omega=2 * pi * 20))
    after, _ = step(state, inputs(turned=0.4 * 2 * pi), P._replace(speed_observer=1), "gradient")
    # predicted: 0.4 turns in 20 ms
    assert after.estimate.delta == pytest.approx(state.rotor.delta + 0.4 * 2 * pi, abs=0.2)


# Who starts again -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("size", "again"), [(0.99e3, False), (1.01e3, True)])
def test_an_estimator_that_ran_away_starts_again(size, again):
    p = P._replace(speed_observer=1)
    p = p._replace(estimators=p.estimators._replace(gradient=gradient.Parameters(Gamma=0.0)))
    state = begun(p, "gradient")
    state = state._replace(estimator=gradient.State(Vector(size, 0.0)), elapsed=1e-9)
    after, _ = step(state, inputs(turned=0.002), p, "gradient", h=1e-9)
    assert (after.estimator.x == Vector(0.0, 0.0)) == again
    assert (abs(after.estimate.x.d) < 1) == again


UNDAMPED = P._replace(machine=MACHINE._replace(D=0.0))


def restarted(omega, p=UNDAMPED, h=H, covariance=1e-4, **gate):
    """Has the Kalman filter of the speed begun afresh, with a deviation of 3 rad/s?"""
    state = begun(p, "gradient")
    # so sure of its speed that no frame changes it
    sure = state.rotor.covariance._replace(dd=covariance, oo=1e-9, do=0.0)
    state = state._replace(
        rotor=state.rotor._replace(omega=omega, covariance=sure), elapsed=h, gate=state.gate._replace(**gate)
    )
    turned = omega * h  # what the rotor turns, the frame does
    after, _ = step(state, inputs(turned=turned), p, "gradient", t=h)
    return after.rotor.covariance.oo == 9.0 and after.rotor.omega == 0.0


@pytest.mark.parametrize("sign", [1, -1])
def test_the_rotor_starts_again_beyond_half_a_turn_a_frame(sign):
    assert not restarted(sign * 0.47 * 2 * pi / H)
    assert restarted(sign * 0.53 * 2 * pi / H)


def test_half_a_turn_of_the_frame_period_after_a_gap():
    """Lost frames do not make it ambiguous, frames that were rejected do: over the whole interval."""
    assert not restarted(0.3 * 2 * pi / H, h=2 * H)
    assert restarted(0.3 * 2 * pi / H, h=2 * H, rejected=1.0)
    assert restarted(0.53 * 2 * pi / H, h=2 * H)
    assert not restarted(0.53 * 2 * pi / H, h=H / 2)  # a frame that came early


def test_the_one_that_forgets_by_itself_goes_on():
    p = P._replace(speed_observer=1, k_speed=0.0)
    state = begun(p, "gradient")
    state = state._replace(rotor=state.rotor._replace(omega=0.6 * 2 * pi / H))
    after, _ = step(state, inputs(turned=0.01), p, "gradient")
    assert after.rotor.omega > 0.5 * 2 * pi / H
    fast = state._replace(rotor=state.rotor._replace(omega=1.1e3))
    after, _ = step(fast, inputs(turned=0.01), UNDAMPED._replace(speed_observer=1, k_speed=0.0), "gradient")
    assert after.rotor.omega == 0.0  # beyond any machine


# Which one --------------------------------------------------------------------------------------------------------


def test_the_selected_speed_observer_is_the_one_that_moves():
    for key in SPEED_OBSERVERS:
        p = P._replace(speed_observer=number(key, SPEED_OBSERVERS))
        state = begun(p, "gradient")
        after, _ = step(state, inputs(turned=0.002), p, "gradient")
        knows = after.rotor.covariance.dd > 0
        assert knows == (key == "kalman")
        moved = after.speed.adaptive.rate.first != 0
        assert moved == (key == "adaptive")
        assert (after.speed.adaptive.a0, after.speed.adaptive.b0) == pytest.approx((C.a0, C.b0), rel=1e-3)


def test_choose():
    functions = [lambda: "one", lambda: "two", lambda: "three"]
    assert [observer.choose(floats, k, functions) for k in (1, 2, 3)] == ["one", "two", "three"]


def test_the_constants_of_robust_know_the_machine():
    assert C.machine == MACHINE and C.model is not None
    assert observer.constants_of("gradient", "two_axis", P).model is None
    own = P._replace(S_n=800.0)
    assert pytest.approx(8 * MACHINE.H) == observer.constants_of("robust", "two_axis", own).machine.H
