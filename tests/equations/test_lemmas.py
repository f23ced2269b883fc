"""Lemmas 1 to 3 of the paper on states drawn at random, and along a trajectory."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fmu_src.pmu_observer import gpebo
from fmu_src.pmu_observer.carriers import floats
from fmu_src.pmu_observer.linear import Matrix, Vector, apply
from fmu_src.pmu_observer.machines.two_axis import constants
from fmu_src.pmu_observer.phasors import measurement, signals

from . import reference
from .reference import MOVING_CASE, PAPER_CASE, seen
from .sampled import inputs_of, machine_of

angles = st.floats(-10.0, 10.0)
voltages = st.floats(0.1, 2.0)
states = st.tuples(angles, st.floats(-5, 5), st.floats(-1.5, 1.5), st.floats(0.05, 1.5))
cases = st.builds(
    lambda case, V, theta, x_line: case._replace(V_inf=V * np.exp(1j * theta), x_line=x_line),
    st.sampled_from([PAPER_CASE, MOVING_CASE]),
    voltages,
    angles,
    st.floats(0.0, 0.5),
)


def output_map(x, y1, y2, x_prime):
    """y4, y5, y6 as the paper prints them."""
    x1, _, x3, x4 = x
    sin, cos = np.sin(x1 - y1), np.cos(x1 - y1)
    y5 = (y2 / x_prime) * (x4 * sin - x3 * cos)
    y6 = (y2 / x_prime) * (x4 * cos + x3 * sin - y2)
    return np.array([np.hypot(y5, y6) / y2, y5, y6])


@given(states, angles, voltages, angles)
def test_lemma_1_the_fibre_leaves_the_outputs(x, y1, y2, a):
    """(x1 + a, e^{-Ja} (x3, x4)) gives the same y4, y5, y6: one scalar of the state cannot be seen in a frame."""
    turned = complex(x[2], x[3]) * np.exp(-1j * a)
    on_fibre = (x[0] + a, x[1], turned.real, turned.imag)
    # both sides are sums of products of numbers below 2, over x' = 0.05, of angles with an error of 2e-15
    np.testing.assert_allclose(output_map(on_fibre, y1, y2, 0.05), output_map(x, y1, y2, 0.05), atol=1e-11)


def signals_of(case, x):
    s = seen(case, 0.0, x)
    i = inputs_of(s)
    c = constants(machine_of(case.machine))
    return s, c, signals(floats, c, measurement(floats, i.frame, i.P_m, i.E_f, False))


@given(cases, states)
def test_lemma_2_the_frame_gives_the_internal_voltage(case, x):
    s, _, found = signals_of(case, x)
    # E' is a difference of phasors of up to 3 pu and x' I of up to 5 pu; its square is divided by nothing
    assert pytest.approx(x[2] ** 2 + x[3] ** 2, abs=1e-13) == found.Y1
    assert complex(found.Y2, found.Y3) == pytest.approx(np.exp(1j * x[0]) * complex(x[2], x[3]), abs=1e-12)
    assert found.measured[:3] == (np.angle(s.V), abs(s.V), abs(s.I))


@given(cases, states)
def test_lemma_2_the_dynamics_are_linear_given_the_frames(case, x):
    s, c, found = signals_of(case, x)
    moved = apply(found.A, Vector(x[2], x[3]))
    rates = reference.machine_rates(case, 0.0, x)
    scale = max(abs(a) for a in found.A)
    np.testing.assert_allclose([moved.d, moved.q + c.c1 * s.E_f], rates[2:], rtol=0, atol=1e-12 * scale)


@given(cases, states)
def test_lemma_2_the_output_map_as_printed_is_that_of_the_phasors(case, x):
    s = seen(case, 0.0, x)
    printed = output_map(x, np.angle(s.V), abs(s.V), case.machine.x1)
    scale = (1 + abs(s.V)) ** 2 / case.machine.x1
    np.testing.assert_allclose(printed[1:], [s.P, s.Q], atol=1e-14 * scale)
    assert printed[0] * abs(s.V) == pytest.approx(abs(s.I) * abs(s.V), abs=1e-13 * scale)


@pytest.mark.parametrize("case", [PAPER_CASE, MOVING_CASE], ids=["paper", "moving"])
def test_lemma_3_the_state_is_known_but_for_a_constant(case):
    """theta = (x3, x4)(0), because xi(0) = 0 and Phi(0) = I."""
    own = reference.Observer(reference.GPEBO_START, lambda s, x, z: reference.gpebo_rates(case.machine, s, z))
    solution = reference.solve(case, np.linspace(0.0, 5.0, 51), own)
    theta = Vector(*case.start[2:])
    Theta = np.array([theta.d, theta.q, theta.d * theta.q, theta.d**2, theta.q**2])
    for t, x, z in zip(solution.t, solution.machine.T, solution.observer.T):
        state = gpebo.Gpebo(Vector(*z[:2]), Matrix(z[2], z[4], z[3], z[5]))
        # 1e-8: solve_ivp's 1e-10 on xi and Phi, which reach 15 in the paper's case, and squares of them
        assert gpebo.estimate(state, theta) == pytest.approx(x[2:], abs=1e-8)
        Y1 = abs(seen(case, t, x).W) ** 2
        psi, y_E = gpebo.regression(state, Y1)
        assert np.dot(psi, Theta) == pytest.approx(y_E, abs=1e-7)
        np.testing.assert_allclose([*psi, y_E], reference.regression(seen(case, t, x), z), rtol=1e-12, atol=1e-12)
