"""The paper's constants against numbers worked out by hand, and against the machine's equations in currents."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fmu_src.pmu_observer.machines.data import Machine, ieee39_g6, paper_smib
from fmu_src.pmu_observer.machines.two_axis import constants

# b0 = 314.16/47.28, a0 = 2 b0, a1 = .146/(.0608*8.96), b1 = .0852/(.0608*8.96), c1 = 1/8.96,
# a2 = .146/(.0608*.31), b2 = .0852/(.0608*.31)
PAPER = {
    "a0": 13.28934010152,
    "b0": 6.64467005076,
    "a1": 0.26800399436,
    "b1": 0.15639685151,
    "c1": 0.11160714286,
    "a2": 7.74617996604,
    "b2": 4.52037351443,
    "x": 0.0608,
}

# b0 = 2 pi 60/69.6, a1 = .254/(.05*7.3), b1 = .204/(.05*7.3), c1 = 1/7.3, a2 = .241/.02, b2 = .191/.02
G6 = {
    "a0": 0.0,
    "b0": 5.41653905793,
    "a1": 0.69589041096,
    "b1": 0.55890410959,
    "c1": 0.13698630137,
    "a2": 12.05,
    "b2": 9.55,
    "x": 0.05,
}


@pytest.mark.parametrize(("machine", "by_hand"), [(paper_smib(), PAPER), (ieee39_g6(), G6)])
def test_constants_of_the_presets(machine, by_hand):
    found = constants(machine)._asdict()
    assert {name: found[name] for name in by_hand} == pytest.approx(by_hand, rel=1e-10)  # the digits written above


def test_the_default_machine_is_the_papers():
    assert Machine() == paper_smib()


positive = st.floats(0.05, 10.0)


@given(positive, positive, positive, positive, positive, positive, st.floats(-2, 2), st.floats(-2, 2), st.floats(-3, 3))
def test_constants_write_the_flux_equations_in_terms_of_voltage(x, above_d, above_q, Td10, Tq10, V, e1d, e1q, E_f):
    """With Vd = E'd + x' Iq and Vq = E'q - x' Id the paper's form is the textbook's in currents."""
    machine = Machine(xd=x + above_d, xd1=x, xq=x + above_q, xq1=x, Td10=Td10, Tq10=Tq10)
    c = constants(machine)
    Vd, Vq = 0.6 * V, 0.8 * V
    Id, Iq = (e1q - Vq) / x, (Vd - e1d) / x
    d_axis, q_axis = (E_f - e1q - above_d * Id) / Td10, (-e1d + above_q * Iq) / Tq10
    scale = (1 + x + above_d + above_q) / (x * min(Td10, Tq10)) * 30  # of the terms that cancel
    assert -c.a1 * e1q + c.b1 * Vq + c.c1 * E_f == pytest.approx(d_axis, abs=1e-14 * scale)
    assert -c.a2 * e1d + c.b2 * Vd == pytest.approx(q_axis, abs=1e-14 * scale)
