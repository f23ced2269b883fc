"""The step-up transformer and Ra, against complex arithmetic, and through the whole observer."""

import cmath
from math import pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fmu_src.pmu_observer import observer
from fmu_src.pmu_observer.carriers import floats
from fmu_src.pmu_observer.machines.data import ieee39_g6
from fmu_src.pmu_observer.phasors import Frame, measurement
from fmu_src.pmu_observer.terminal import Transformer, at_machine, behind_impedance
from scenarios import loader
from scenarios.records import standard

POLAR = st.tuples(st.floats(0.5, 1.5), st.floats(-pi, pi))


def frame_of(V: complex, I: complex) -> Frame:  # noqa: E741 - the paper's name
    S = V * I.conjugate()
    return Frame(abs(V), cmath.phase(V), abs(I), cmath.phase(I), S.real, S.imag)


@given(POLAR, POLAR, st.floats(0, 0.3), st.floats(0, 0.05), st.floats(0.9, 1.1), st.floats(-pi, pi))
def test_transformer_by_complex_arithmetic(V, I, x_T, r_T, tap, shift):  # noqa: E741 - the paper's name
    V_h, I_h = cmath.rect(*V), cmath.rect(*I)
    I_t = I_h * cmath.exp(-1j * shift) / tap
    V_t = tap * V_h * cmath.exp(-1j * shift) + (r_T + 1j * x_T) * I_t
    S_t = V_t * I_t.conjugate()
    m = at_machine(floats, measurement(floats, frame_of(V_h, I_h), 0.0, 0.0, False), Transformer(x_T, r_T, tap, shift))
    assert cmath.rect(m.V, m.theta) == pytest.approx(V_t, abs=1e-12)
    assert pytest.approx(abs(I_t), abs=1e-12) == m.I
    assert complex(m.P, m.Q) == pytest.approx(S_t, abs=1e-12)


@given(POLAR, POLAR, st.floats(0, 0.05), st.floats(0, 0.3))
def test_an_impedance_and_back(V, I, r, x):  # noqa: E741 - the paper's name
    m = measurement(floats, frame_of(cmath.rect(*V), cmath.rect(*I)), 0.0, 0.0, False)
    there = behind_impedance(floats, m, r, x)
    back = behind_impedance(floats, there, -r, -x)
    assert pytest.approx(m.V, abs=1e-12) == back.V and complex(back.P, back.Q) == pytest.approx(complex(m.P, m.Q))


@given(POLAR, POLAR)
def test_no_transformer_changes_nothing_to_the_last_bit(V, I):  # noqa: E741 - the paper's name
    m = measurement(floats, frame_of(cmath.rect(*V), cmath.rect(*I)), 0.7, 1.8, False)
    assert at_machine(floats, m, Transformer()) == m


TRANSFORMER = Transformer(x_T=0.0143, r_T=0.0004, tap=1.025, shift=pi / 6)
S_N = 1000.0
"""MVA; the machine's data and the transformer's are given on it, the record is on 100 MVA."""


@pytest.fixture(scope="module")
def record() -> standard.StandardRecord:
    return standard.read(loader.FOLDER / "data" / "record_g6.csv")


def at_high_side(record: standard.StandardRecord) -> tuple[np.ndarray, np.ndarray]:
    """(V_h, I_h) of a PMU above the transformer, whose data are here on 100 MVA."""
    t = TRANSFORMER
    turn = np.exp(1j * t.shift)
    return turn / t.tap * (record.V - (t.r_T + 1j * t.x_T) * record.I), t.tap * turn * record.I


def estimates(V, I, record, transformer):  # noqa: E741 - the paper's name
    """delta, E'd, E'q after each frame; the machine's base is its own."""
    up = S_N / 100
    machine = ieee39_g6()
    own = machine._replace(H=machine.H / up, xd=machine.xd * up, xd1=machine.xd1 * up, xq=machine.xq * up, xq1=0.5)
    transformer = transformer._replace(x_T=transformer.x_T * up, r_T=transformer.r_T * up)
    p = observer.Parameters(machine=own, transformer=transformer, S_n=S_N)
    found, state = [], None
    for k in range(600):
        inputs = observer.Inputs(frame_of(complex(V[k]), complex(I[k])), record.P_m[k], record.E_f[k])
        if state is None:
            state, _ = observer.start("robust", floats, p, inputs, 0.0)
        state, out = observer.step("robust", floats, p, state, inputs, k / 60, 1 / 60)
        found.append((out.delta, out.load_angle, out.e1d, out.e1q))
    return np.array(found)


@pytest.fixture(scope="module")
def at_terminal(record):
    return estimates(record.V, record.I, record, Transformer())


def test_the_observer_at_the_high_side_sees_what_it_sees_at_the_terminal(record, at_terminal):
    high = estimates(*at_high_side(record), record, TRANSFORMER)
    np.testing.assert_allclose(high, at_terminal, atol=1e-6)


def test_a_forgotten_transformer_shows(record, at_terminal):
    """In delta: its shift. In E'd and E'q: what x_T and the ratio are worth."""
    V, I = at_high_side(record)  # noqa: E741 - the paper's name
    error = np.abs(estimates(V, I, record, Transformer()) - at_terminal)[-1]
    assert error[0] > 0.4 and error[3] > 0.01
    no_ratio = np.abs(estimates(V, I, record, TRANSFORMER._replace(tap=1.0)) - at_terminal)[-1]
    assert no_ratio[3] > 0.01
