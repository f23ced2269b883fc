"""Proposition 1: one frame of a flux-decay machine gives the load angle and E'q, beyond 90 degrees too."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fmu_src.pmu_observer.carriers import floats
from fmu_src.pmu_observer.machines.data import paper_smib
from fmu_src.pmu_observer.machines.two_axis import constants
from fmu_src.pmu_observer.third_order import flux_decay, observe

H, x, xd, Td10, omega_s = 23.64, 0.0608, 0.146, 8.96, 314.16
V = 1.0


def currents(delta, e1q):
    """E'q along q at a terminal of V = 1 at angle 0."""
    return (1j * (e1q * np.exp(1j * (delta - np.pi / 2))) - V) / (1j * x)


def rates(t, state):
    """The 3rd-order model in textbook form; the driving power makes the machine slip a pole."""
    delta, omega, e1q = state
    I = currents(delta, e1q)  # noqa: E741 - the paper's name
    Id = -(I * np.exp(-1j * (delta - np.pi / 2))).imag
    return [omega, omega_s / (2 * H) * (20.0 - (V * np.conj(I)).real), (1.2 - e1q - (xd - x) * Id) / Td10]


@pytest.fixture(scope="module")
def trajectory():
    return solve_ivp(
        rates, (0, 3), [0.1, 0.0, 1.0], method="DOP853", rtol=1e-10, atol=1e-12, t_eval=np.linspace(0, 3, 61)
    )


def test_the_trajectory_goes_round(trajectory):
    assert trajectory.y[0].max() > 2 * np.pi


def test_load_angle_and_voltage_from_one_frame(trajectory):
    for delta, _, e1q in trajectory.y.T:
        I = currents(delta, e1q)  # noqa: E741 - the paper's name
        S = V * np.conj(I)
        found = observe(floats, V, S.real, S.imag, abs(I), x)
        # algebraic, so exact but for the rounding of numbers of up to V^2/x' = 16
        assert np.exp(1j * found.load_angle) == pytest.approx(np.exp(1j * delta), abs=1e-13)
        assert found.e1q == pytest.approx(e1q, abs=1e-13)


def test_arcsin_as_printed_is_wrong_beyond_90_degrees(trajectory):
    for delta, _, e1q in trajectory.y.T:
        P = (V * np.conj(currents(delta, e1q))).real
        right = abs(np.exp(1j * np.arcsin(np.clip(x * P / (V * e1q), -1, 1))) - np.exp(1j * delta)) < 1e-6
        assert right == (np.cos(delta) > 0)


def test_flux_decay_machine_has_no_q_axis_winding():
    c = constants(flux_decay(paper_smib()))
    assert c.b2 == 0 and c.a2 == pytest.approx(1 / paper_smib().Tq10)  # E'd only decays
    assert c._replace(a2=0, b2=0) == constants(paper_smib())._replace(a2=0, b2=0)
