"""The preprint's misprints: what it prints fails, and what stands here in its place holds."""

import numpy as np
import pytest

from fmu_src.pmu_observer.angle import rotor_angle
from fmu_src.pmu_observer.carriers import floats
from fmu_src.pmu_observer.estimators import drem, overparameterised
from fmu_src.pmu_observer.linear import Vector
from fmu_src.pmu_observer.machines.two_axis import constants
from fmu_src.pmu_observer.phasors import measurement, signals

from . import reference
from .reference import PAPER, PAPER_CASE, seen
from .sampled import inputs_along, inputs_of, machine_of, parameters_of, run

th1, th2 = 0.4, 0.3


def frame_signals(x):
    i = inputs_of(seen(PAPER_CASE, 0.0, x))
    return signals(floats, constants(machine_of(PAPER)), measurement(floats, i.frame, i.P_m, i.E_f, False))


def test_voltage_in_the_rotor_frame():
    """y2 cos(x1 - y1) = (x'/Y1)(z0 x4 - y5 x3); the preprint has x3 twice."""
    x1, _, x3, x4 = x = (0.7, 0.0, 0.4, 0.9)
    s = frame_signals(x)
    z0, y5 = s.measured.Q + s.measured.V**2 / PAPER.x1, s.measured.P
    right = PAPER.x1 / s.Y1 * (z0 * x4 - y5 * x3)
    printed = PAPER.x1 / s.Y1 * (z0 * x3 - y5 * x3)
    assert right == pytest.approx(np.cos(x1), abs=1e-14)
    assert abs(printed - np.cos(x1)) > 0.1


def test_consistency_errors():
    """e = (Th1 Th2 - Th3, Th4 - Th1^2, Th5 - Th2^2) is zero at the true Theta; the preprint's e2 and e3 are not."""
    Theta = overparameterised.Overparameters(th1, th2, th1 * th2, th1**2, th2**2)
    shown = overparameterised.outputs(floats, overparameterised.State(Theta=Theta))
    assert (shown.e1, shown.e2, shown.e3) == (0, 0, 0)
    assert abs(Theta.th1 - Theta.th4**2) > 0.1 and abs(Theta.th2 - Theta.th5**2) > 0.1


@pytest.mark.parametrize("degrees", [-170, -100, 30, 100, 170])
def test_rotor_angle_beyond_90_degrees(degrees):
    """atan2 finds the angle on the whole circle; arcsin only from -90 to 90 degrees."""
    x1, pair = np.radians(degrees), Vector(0.2, 0.9)
    s = frame_signals((x1, 0.0, *pair))
    assert rotor_angle(floats, s, pair, 0.0).delta == pytest.approx(x1, abs=1e-13)
    arcsin = np.arcsin((pair.d * s.Y3 - pair.q * s.Y2) / s.Y1)
    assert (abs(arcsin - x1) < 1e-6) == (abs(degrees) < 90)


def test_cramers_rule_replaces_a_column():
    """Delta theta_k = det(Psi with column k replaced by Y_E); with row k, as printed, it is something else."""
    Theta = np.array([th1, th2, th1 * th2, th1**2, th2**2])
    Psi = np.random.default_rng(1).normal(size=(5, 5))
    Y_E = Psi @ Theta
    found = drem.mix([drem.Row(*row, y_E=y) for row, y in zip(Psi.tolist(), Y_E.tolist())])
    assert (found.calY1 / found.Delta, found.calY2 / found.Delta) == pytest.approx((th1, th2), rel=1e-10)
    by_row = Psi.copy()
    by_row[0] = Y_E
    assert abs(np.linalg.det(by_row) / found.Delta - th1) > 0.1


def test_phi_starts_from_the_identity():
    """With all initial conditions zero, as printed, Phi would stay zero and nothing would be estimated."""
    assert drem.State().gpebo.Phi == (1, 0, 0, 1)


def test_delta_is_square_integrable_in_the_papers_own_example():
    """A is stable, hence Phi -> 0 and the excitation ends: the integral of Delta^2 saturates at 7.588e-15 by 3 s."""
    h = 2e-3
    solution = reference.solve(PAPER_CASE, np.arange(0, 6 + h / 2, h))
    states = run("drem", parameters_of(PAPER), inputs_along(PAPER_CASE, solution), h).states
    at_3_s, at_6_s = (states[round(t / h)].estimator.int_Delta2 for t in (3, 6))
    assert at_3_s == pytest.approx(7.588e-15, rel=1e-3)  # four digits, and the second order of a 2 ms step
    assert at_6_s == pytest.approx(at_3_s, rel=1e-3)
