"""The SMIB plant against scipy's solve_ivp: the paper's equations, and the textbook's in dq currents."""

from math import ceil

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from fmu_src.pmu_observer import tree
from fmu_src.pmu_observer.carriers import floats
from fmu_src.pmu_observer.interface import broken, variables
from fmu_src.pmu_observer.machines.data import ieee39_g6, paper_smib
from fmu_src.pmu_observer.plants import smib

from . import reference
from .sampled import machine_of

G6 = ieee39_g6()
PAPER = smib.Parameters()
LINE = smib.Parameters(machine=G6, x_line=0.03, start_mode=smib.P_M_V_T)
LOADED = smib.Inputs(P_m=5.5, E_f=2.5, V_inf=1.0, theta_inf=0.3)
ACCURACY = 1e-8  # what issue and docstring promise over a communication step of any size


def advance(p, state, inputs, t, h):
    """One communication step, divided at the plant's MAX_STEP as the runtime does."""
    n = max(1, ceil(h / smib.MAX_STEP - 1e-9))
    state, outputs = smib.step(floats, p, state, inputs, t, h / n)
    for k in range(1, n):
        state, outputs = smib.step(floats, p, state, inputs, t + k * h / n, h / n)
    return state, outputs


def simulate(p, inputs, h, duration):
    """(delta, omega, E'd, E'q) at the start and after every step, and the outputs there."""
    state, outputs = smib.start(floats, p, inputs, 0.0)
    shown = [outputs]
    for k in range(round(duration / h)):
        state, outputs = advance(p, state, inputs, k * h, h)
        shown.append(outputs)
    return np.array([[o.delta, o.omega, o.e1d, o.e1q] for o in shown]), shown


def network(p, inputs, t, faulted):
    """Thevenin voltage, as a phasor at time t, and reactance behind the terminal."""
    frequency = 2 * np.pi * inputs.f_inf - p.machine.omega_s if inputs.f_inf > 0 else 0.0
    V, X = inputs.V_inf * np.exp(1j * (inputs.theta_inf + frequency * t)), p.x_line
    share = p.x_fault / (p.x_fault + X) if faulted else 1.0
    return V * share, X * share


def currents(p, inputs, t, x, faulted):
    """(Id, Iq), from the stator's two equations with the line in series."""
    m = p.machine
    V, X = network(p, inputs, t, faulted)
    v = 1j * V * np.exp(-1j * x[0])  # vd + j vq
    stator = np.array([[m.Ra, -(m.xq1 + X)], [m.xd1 + X, m.Ra]])
    return np.linalg.solve(stator, [x[2] - v.real, x[3] - v.imag])


def dq_rates(p, inputs, t, x, faulted):
    """The textbook's two-axis machine (Sauer and Pai), on currents."""
    m = p.machine
    _, omega, e1d, e1q = x
    Id, Iq = currents(p, inputs, t, x, faulted)
    torque = e1d * Id + e1q * Iq + (m.xq1 - m.xd1) * Id * Iq
    return [
        omega,
        m.omega_s / (2 * m.H) * (inputs.P_m - torque - m.D * omega),
        (-e1d + (m.xq - m.xq1) * Iq) / m.Tq10,
        (inputs.E_f - e1q - (m.xd - m.xd1) * Id) / m.Td10,
    ]


def dq_solution(p, inputs, start, times):
    """The dq equations with a fault from t_fault to t_clear, solved in three pieces."""
    x, found = np.array(start), np.empty((len(times), 4))
    limits = [0.0, *np.minimum([p.t_fault, p.t_clear], times[-1]), times[-1]]
    for begin, end, faulted in zip(limits, limits[1:], (False, True, False)):
        if end > begin:
            piece = solve_ivp(
                lambda t, x, faulted=faulted: dq_rates(p, inputs, t, x, faulted),
                (begin, end),
                x,
                method="DOP853",
                rtol=1e-12,
                atol=1e-13,
                dense_output=True,
            )
            for k in np.flatnonzero((times >= begin) & (times <= end)):
                found[k] = piece.sol(times[k])
            x = piece.y[:, -1]
    return found


@pytest.mark.parametrize("h", [3e-4, 0.05, 1.0])
@pytest.mark.parametrize("x_line", [0.0, 0.1])
def test_the_papers_equations(h, x_line):
    """The paper's study, and the same behind a line: eq. (1) to (3) with the constants a0 to c1."""
    case = reference.PAPER_CASE._replace(x_line=x_line)
    duration = 0.3 if h < 1e-3 else 5.0
    found, _ = simulate(PAPER._replace(x_line=x_line), smib.Inputs(), h, duration)
    expected = reference.solve(case, np.arange(len(found)) * h, rtol=1e-12).machine.T
    np.testing.assert_allclose(found, expected, rtol=0, atol=ACCURACY)


FAULT = LINE._replace(t_fault=0.5037, t_clear=0.6111, x_fault=0.01)
VARIANTS = {
    "none": (FAULT, LOADED),
    "resistance": (FAULT._replace(machine=G6._replace(Ra=0.01)), LOADED),
    "damping": (FAULT._replace(machine=G6._replace(D=0.1)), LOADED._replace(f_inf=60.02)),
    "x'd != x'q": (FAULT._replace(machine=G6._replace(xq1=0.08, Ra=0.005)), LOADED),
    "off nominal frequency": (FAULT, LOADED._replace(f_inf=59.7)),
    "a mode of 0.01 s": (FAULT._replace(machine=G6._replace(Tq10=0.05)), LOADED),
}


@pytest.mark.parametrize("variant", VARIANTS.values(), ids=VARIANTS)
@pytest.mark.parametrize("h", [0.05, 1.0])
def test_a_fault_between_communication_points(variant, h):
    p, inputs = variant
    inputs = inputs._replace(E_f=smib.start(floats, p, inputs, 0.0)[1].E_f_start)
    found, _ = simulate(p, inputs, h, 2.0)
    expected = dq_solution(p, inputs, found[0], np.arange(len(found)) * h)
    assert np.ptp(expected[:, 1]) > 0.05  # the fault is felt
    np.testing.assert_allclose(found, expected, rtol=0, atol=ACCURACY)


def test_the_fault_is_on_at_t_fault_and_off_at_t_clear():
    p = LINE._replace(t_fault=0.1, t_clear=0.2, x_fault=0.01)
    _, shown = simulate(p, LOADED, 0.05, 0.3)
    seen_on = [o.frame.V_t < 0.5 for o in shown]
    assert seen_on == [False, False, True, True, False, False, False]


@pytest.mark.parametrize("variant", VARIANTS.values(), ids=VARIANTS)
def test_every_frame_is_that_of_the_network(variant):
    """P + jQ = V conj(I), V = V_Thevenin + j X I, I as the stator says: at t0, before, in and after the fault."""
    p, inputs = variant
    h = 0.05
    _, shown = simulate(p, inputs, h, 1.0)
    for k, o in enumerate(shown):
        t, f = k * h, o.frame
        faulted = p.t_fault <= t < p.t_clear
        V, I = f.V_t * np.exp(1j * f.theta_t), f.I_t * np.exp(1j * f.phi_t)  # noqa: E741 - the paper's name
        infinite, X = network(p, inputs, t, faulted)
        Id, Iq = currents(p, inputs, t, [o.delta, o.omega, o.e1d, o.e1q], faulted)
        # algebra on currents of up to 20 pu
        assert V * np.conj(I) == pytest.approx(complex(f.P_t, f.Q_t), abs=1e-12)
        assert infinite + 1j * X * I == pytest.approx(V, abs=1e-12)
        assert pytest.approx(-1j * np.exp(1j * o.delta) * complex(Id, Iq), abs=1e-11) == I
        assert np.exp(1j * o.load_angle) == pytest.approx(np.exp(1j * (o.delta - f.theta_t)), abs=1e-12)
        assert -np.pi < o.load_angle <= np.pi


def messages(p, inputs):
    leaves = tree.leaves(p) + tree.leaves(inputs)
    names = [variable.name for variable in variables(p) + variables(inputs)]
    return broken(smib.rules(floats, p, inputs), dict(zip(names, leaves)))


def residual(p, inputs, outputs):
    """The largest derivative in the frame of the infinite bus."""
    x = [outputs.delta, outputs.omega, outputs.e1d, outputs.e1q]
    slip = 2 * np.pi * inputs.f_inf - p.machine.omega_s if inputs.f_inf > 0 else 0.0
    return np.abs(np.array(dq_rates(p, inputs, 0.0, x, False)) - [slip, 0, 0, 0]).max()


machines = st.builds(
    lambda m, Ra, D, xq1: m._replace(Ra=Ra, D=D, xq1=xq1),
    st.sampled_from([G6, paper_smib()]),
    st.floats(0, 0.01),
    st.floats(0, 0.2),
    st.floats(0.03, 0.14),
)


@given(machines, st.floats(0.01, 0.2), st.floats(-2, 6), st.floats(0.9, 1.1), st.sampled_from([0.0, 49.99, 60.01]))
def test_equilibrium_for_power_and_terminal_voltage(machine, x_line, P_m, V_t, f_inf):
    machine = machine._replace(omega_s=2 * np.pi * (60 if f_inf > 55 else 50))
    p = smib.Parameters(machine=machine, x_line=x_line, start_mode=smib.P_M_V_T, V_t_start=V_t)
    inputs = LOADED._replace(P_m=P_m, f_inf=f_inf)
    assume(abs(P_m) * x_line < 0.8 * V_t)  # below the most that the line carries
    assert messages(p, inputs) == []
    _, outputs = smib.start(floats, p, inputs, 0.0)
    assert outputs.frame.V_t == pytest.approx(V_t, abs=1e-9)  # the fixed point on the stator's losses
    slip = 2 * np.pi * f_inf - machine.omega_s if f_inf > 0 else 0.0
    losses = machine.Ra * outputs.frame.I_t**2 + machine.D * slip
    assert outputs.frame.P_t == pytest.approx(P_m - losses, abs=1e-8)
    assert residual(p, inputs._replace(E_f=outputs.E_f_start), outputs) < 1e-6


@given(machines, st.floats(0.0, 0.2), st.floats(-0.9, 0.9), st.floats(0.5, 3.0))
def test_equilibrium_for_power_and_field(machine, x_line, share, E_f):
    p = smib.Parameters(machine=machine, x_line=x_line, start_mode=smib.P_M_E_F)
    P_m = share * E_f / (machine.xd + x_line) * 0.9  # of the most that a round rotor without resistance gives
    inputs = LOADED._replace(P_m=P_m, E_f=E_f)
    assert messages(p, inputs) == []
    _, outputs = smib.start(floats, p, inputs, 0.0)
    assert outputs.E_f_start == E_f
    assert outputs.frame.P_t + machine.Ra * outputs.frame.I_t**2 == pytest.approx(P_m, abs=1e-8)
    assert residual(p, inputs, outputs) < 1e-6


def test_an_equilibrium_stays():
    p, inputs = LINE, LOADED
    inputs = inputs._replace(E_f=smib.start(floats, p, inputs, 0.0)[1].E_f_start)
    found, _ = simulate(p, inputs, 1.0, 5.0)
    np.testing.assert_allclose(found, found[:1].repeat(len(found), axis=0), atol=1e-10)


@pytest.mark.parametrize(
    ("p", "P_m"),
    [
        (LINE, 40.0),  # the line carries at most 33 pu
        (LINE._replace(start_mode=smib.P_M_E_F), 12.0),  # the machine gives at most 9
        (LINE._replace(start_mode=smib.P_M_E_F), -12.0),
    ],
)
def test_no_equilibrium(p, P_m):
    (message,) = messages(p, LOADED._replace(P_m=P_m))
    assert message.startswith(f"P_m = {P_m:g} is not allowed") and "no equilibrium" in message


def test_parameters_that_do_not_go_together():
    (message,) = messages(LINE._replace(x_line=0.0), LOADED)
    assert message.startswith("x_line = 0 is not allowed with start_mode = 3 (P_m_V_t)")
    (message,) = messages(LINE._replace(t_fault=2.0, t_clear=1.0), LOADED)
    assert message.startswith("t_clear = 1 is not allowed") and "t_fault = 2" in message


def test_the_rotor_turns_with_an_infinite_bus_off_nominal_frequency():
    """60.2 Hz for 6 s: 1.2 revolutions more, all of them in delta, none in the load angle."""
    inputs = LOADED._replace(f_inf=60.2)
    inputs = inputs._replace(E_f=smib.start(floats, LINE, inputs, 0.0)[1].E_f_start)
    found, shown = simulate(LINE, inputs, 1.0, 6.0)
    assert found[-1, 0] - found[0, 0] == pytest.approx(2 * np.pi * 1.2, abs=1e-8)
    assert found[-1, 1] == pytest.approx(2 * np.pi * 0.2, abs=1e-9)
    assert shown[-1].load_angle == pytest.approx(shown[0].load_angle, abs=1e-8)


def test_a_jump_of_the_infinite_bus_leaves_the_rotor_where_it_is():
    inputs = LOADED._replace(E_f=smib.start(floats, LINE, LOADED, 0.0)[1].E_f_start)
    state, before = smib.start(floats, LINE, inputs, 0.0)
    jumped = inputs._replace(theta_inf=inputs.theta_inf - 0.2)
    state, after = advance(LINE, state, jumped, 0.0, 0.5)
    start = [before.delta, before.omega, before.e1d, before.e1q]
    expected = dq_solution(LINE, jumped, start, np.array([0.0, 0.5]))[-1]
    assert [after.delta, after.omega, after.e1d, after.e1q] == pytest.approx(list(expected), abs=ACCURACY)
    assert abs(after.omega) > 0.1  # and the machine swings


def test_the_papers_machine_of_the_reference_is_that_of_the_package():
    assert machine_of(reference.PAPER) == paper_smib()
    assert machine_of(reference.G6) == ieee39_g6()
