"""A two-axis machine behind a line at an infinite bus (SMIB); x_line = 0 is the paper's case.

    Td10 E'q' = E_f - E'q - (xd - x'd) Id        stator and line, with R = Ra, X'd = x'd + X, X'q = x'q + X:
    Tq10 E'd' =     - E'd + (xq - x'q) Iq          V sin(a) = E'd + X'q Iq - R Id
    omega' = -a0 omega + b0 (P_m - T_e)            V cos(a) = E'q - X'd Id - R Iq
    T_e = E'd Id + E'q Iq + (x'q - x'd) Id Iq    a: rotor angle from the infinite bus

With x'd = x'q and Ra = 0 this is the paper's eq. (1)-(3), written here with currents instead of its constants, so
that plant and observer share no equation. A three-phase fault through x_fault at the terminal turns line and infinite
bus into their Thevenin equivalent.
"""

from math import pi
from typing import Annotated, List, NamedTuple

from ..clock import NEVER, resolution
from ..interface import INLINE, Enumeration, Real, Rule, Scalar
from ..machines.data import Machine, reactance_rules
from ..machines.two_axis import constants
from ..phasors import Frame
from . import runge_kutta

STATES, P_M_E_F, P_M_V_T = 1, 2, 3

MAX_STEP = 5e-4
"""s; a mode of 0.01 s (T'q0 x'q/xq) is still integrated to 1e-8, also in a fault."""


class Inputs(NamedTuple):
    P_m: Annotated[Scalar, Real("pu", "mechanical power")] = 0.1
    E_f: Annotated[Scalar, Real("pu", "field voltage (open circuit: E_f = 1 gives V = 1)")] = 0.1
    V_inf: Annotated[Scalar, Real("pu", "voltage of the infinite bus")] = 1.0
    theta_inf: Annotated[Scalar, Real("rad", "angle of the infinite bus, before what f_inf adds")] = 0.0
    f_inf: Annotated[Scalar, Real("Hz", "frequency of the infinite bus; 0: omega_s/(2 pi)", min=0.0)] = 0.0


class Parameters(NamedTuple):
    machine: Annotated[Machine, INLINE] = Machine()
    x_line: Annotated[Scalar, Real("pu", "reactance between terminal and infinite bus", min=0.0, max=10.0)] = 0.0
    start_mode: Annotated[
        Scalar,
        Enumeration(
            "StartMode",
            "start from the given states, or from the equilibrium for (P_m, E_f) or for (P_m, V_t_start)",
            ("states", "P_m_E_f", "P_m_V_t"),
        ),
    ] = STATES
    delta_start: Annotated[Scalar, Real("rad", "rotor angle at the start", min=-1e3, max=1e3)] = 0.1
    omega_start: Annotated[Scalar, Real("rad/s", "speed deviation at the start", min=-1e2, max=1e2)] = 0.2
    e1d_start: Annotated[Scalar, Real("pu", "E'd at the start", min=-10.0, max=10.0)] = 0.4
    e1q_start: Annotated[Scalar, Real("pu", "E'q at the start", min=-10.0, max=10.0)] = 0.3
    V_t_start: Annotated[Scalar, Real("pu", "terminal voltage of the equilibrium", min=0.1, max=2.0)] = 1.0
    t_fault: Annotated[Scalar, Real("s", "a three-phase fault at the terminal begins")] = NEVER
    t_clear: Annotated[Scalar, Real("s", "the fault is cleared")] = NEVER
    x_fault: Annotated[Scalar, Real("pu", "reactance of the fault", min=1e-4, max=1e2)] = 0.05


class Outputs(NamedTuple):
    frame: Annotated[Frame, INLINE] = Frame()
    delta: Annotated[Scalar, Real("rad", "rotor angle, unwrapped")] = 0.0
    load_angle: Annotated[Scalar, Real("rad", "delta - theta_t, in (-pi, pi]")] = 0.0
    omega: Annotated[Scalar, Real("rad/s", "deviation from synchronous speed")] = 0.0
    e1d: Annotated[Scalar, Real("pu", "E'd, d-axis transient voltage")] = 0.0
    e1q: Annotated[Scalar, Real("pu", "E'q, q-axis transient voltage")] = 0.0
    E_f_start: Annotated[Scalar, Real("pu", "field voltage that the equilibrium at the start needs")] = 0.0
    t_frame: Annotated[Scalar, Real("s", "time of these values on the simulation's clock")] = 0.0
    P_m_out: Annotated[Scalar, Real("pu", "the input P_m, for what travels with a frame")] = 0.0
    E_f_out: Annotated[Scalar, Real("pu", "the input E_f, for what travels with a frame")] = 0.0


class Rotor(NamedTuple):
    delta: Scalar  # rad; in the equations it is the angle from the infinite bus
    omega: Scalar  # rad/s
    e1d: Scalar  # pu
    e1q: Scalar  # pu


class State(NamedTuple):
    rotor: Rotor
    grid: Scalar  # rad, what f_inf has added to the angle of the infinite bus
    E_f_start: Scalar  # pu


class Grid(NamedTuple):
    """Thevenin equivalent of what the terminal sees."""

    V: Scalar  # pu
    X: Scalar  # pu
    omega: Scalar  # rad/s, its frequency's deviation from synchronous speed


class Currents(NamedTuple):
    d: Scalar
    q: Scalar


def start(xp, p: Parameters, inputs: Inputs, t):
    """State and outputs at time t: given states, or one of the two equilibria."""
    by_field = from_field_voltage(xp, p, inputs)
    by_voltage, E_f = from_terminal_voltage(xp, p, inputs)
    given = Rotor(p.delta_start, p.omega_start, p.e1d_start, p.e1q_start)
    equilibrium = Rotor(*[xp.where(p.start_mode == P_M_V_T, v, f) for v, f in zip(by_voltage, by_field)])
    equilibrium = turned(equilibrium, inputs.theta_inf)
    rotor = Rotor(*[xp.where(p.start_mode == STATES, g, e) for g, e in zip(given, equilibrium)])
    state = State(rotor, 0.0, xp.where(p.start_mode == P_M_V_T, E_f, inputs.E_f))
    return state, outputs(xp, p, state, inputs, t)


def step(xp, p: Parameters, state: State, inputs: Inputs, t, h):
    """From t to t + h in three sub-intervals, before, during and after the fault, some of them empty."""
    end = t + h
    fault = xp.minimum(xp.maximum(p.t_fault, t), end)
    clear = xp.minimum(xp.maximum(p.t_clear, fault), end)
    healthy, faulted = thevenin(p, inputs, False), thevenin(p, inputs, True)
    # the state holds the rotor's own angle, which stays where it is when theta_inf jumps
    state = state._replace(rotor=turned(state.rotor, -inputs.theta_inf - state.grid))
    for grid, duration in ((healthy, fault - t), (faulted, clear - fault), (healthy, end - clear)):
        state = integrate(xp, p, grid, inputs, state, duration)
    state = state._replace(rotor=turned(state.rotor, inputs.theta_inf + state.grid))
    return state, outputs(xp, p, state, inputs, end)


def turned(rotor: Rotor, angle) -> Rotor:
    return rotor._replace(delta=rotor.delta + angle)


def integrate(xp, p, grid: Grid, inputs: Inputs, state: State, h) -> State:
    """An empty interval changes nothing."""

    def moved():
        rotor = runge_kutta.step(lambda rotor: derivative(xp, p, grid, inputs, rotor), state.rotor, h)
        return state._replace(rotor=rotor, grid=state.grid + h * grid.omega)

    return xp.cond(h > 0, moved, lambda: state)


def derivative(xp, p: Parameters, grid: Grid, inputs: Inputs, rotor: Rotor) -> Rotor:
    m = p.machine
    i = currents(xp, m.Ra, m.xd1 + grid.X, m.xq1 + grid.X, rotor.e1d, rotor.e1q, grid.V, rotor.delta)
    torque = rotor.e1d * i.d + rotor.e1q * i.q + (m.xq1 - m.xd1) * i.d * i.q
    c = constants(m)
    return Rotor(
        delta=rotor.omega - grid.omega,
        omega=-c.a0 * rotor.omega + c.b0 * (inputs.P_m - torque),
        e1d=(-rotor.e1d + (m.xq - m.xq1) * i.q) / m.Tq10,
        e1q=(inputs.E_f - rotor.e1q - (m.xd - m.xd1) * i.d) / m.Td10,
    )


def currents(xp, R, Xd, Xq, Ed, Eq, V, angle) -> Currents:
    """V sin = Ed + Xq Iq - R Id, V cos = Eq - Xd Id - R Iq, solved for (Id, Iq)."""
    d, q = V * xp.sin(angle) - Ed, V * xp.cos(angle) - Eq
    determinant = R * R + Xd * Xq
    return Currents((-R * d - Xq * q) / determinant, (Xd * d - R * q) / determinant)


def thevenin(p: Parameters, inputs: Inputs, faulted: bool) -> Grid:
    omega = (inputs.f_inf > 0) * (2 * pi * inputs.f_inf - p.machine.omega_s)
    share = p.x_fault / (p.x_line + p.x_fault) if faulted else 1.0
    return Grid(inputs.V_inf * share, p.x_line * share, omega)


def outputs(xp, p: Parameters, state: State, inputs: Inputs, t) -> Outputs:
    """The PMU frame and the true states at time t; at t_fault the fault is on, at t_clear it is off."""
    now = t + resolution(xp, t)
    faulted = xp.logical_and(now >= p.t_fault, now < p.t_clear)
    grid = Grid(*[xp.where(faulted, f, h) for f, h in zip(thevenin(p, inputs, True), thevenin(p, inputs, False))])
    m, (delta, omega, e1d, e1q) = p.machine, state.rotor
    angle = delta - inputs.theta_inf - state.grid
    i = currents(xp, m.Ra, m.xd1 + grid.X, m.xq1 + grid.X, e1d, e1q, grid.V, angle)
    Vd, Vq = e1d + m.xq1 * i.q - m.Ra * i.d, e1q - m.xd1 * i.d - m.Ra * i.q
    load_angle = xp.atan2(Vd, Vq)
    frame = Frame(
        V_t=xp.sqrt(Vd * Vd + Vq * Vq),
        theta_t=delta - load_angle,
        I_t=xp.sqrt(i.d * i.d + i.q * i.q),
        phi_t=delta - xp.atan2(i.d, i.q),
        P_t=Vd * i.d + Vq * i.q,
        Q_t=Vq * i.d - Vd * i.q,
    )
    return Outputs(frame, delta, load_angle, omega, e1d, e1q, state.E_f_start, t, inputs.P_m, inputs.E_f)


def from_field_voltage(xp, p: Parameters, inputs: Inputs) -> Rotor:
    """The equilibrium for (P_m, E_f): E'q = E_f - (xd - x'd) Id, E'd = (xq - x'q) Iq, T_e(angle) = P_m.

    Newton's method from angle 0, on the rising side of T_e, where it is concave: no step passes the solution.
    """
    m, V, X = p.machine, inputs.V_inf, p.x_line
    omega = thevenin(p, inputs, False).omega
    P = inputs.P_m - m.D * omega
    Xd, Xq = m.xd + X, m.xq + X
    determinant = m.Ra * m.Ra + Xd * Xq
    angle = 0.0
    for _ in range(40):
        sin, cos = xp.sin(angle), xp.cos(angle)
        i = currents(xp, m.Ra, Xd, Xq, 0.0, inputs.E_f, V, angle)
        E = inputs.E_f - (m.xd - m.xq) * i.d
        slope_d = V * (Xq * sin - m.Ra * cos) / determinant
        slope_q = V * (Xd * cos + m.Ra * sin) / determinant
        slope = E * slope_q - (m.xd - m.xq) * slope_d * i.q
        slope = xp.maximum(slope, 1e-6)
        angle = xp.minimum(xp.maximum(angle + (P - E * i.q) / slope, -pi / 2), pi / 2)
    i = currents(xp, m.Ra, Xd, Xq, 0.0, inputs.E_f, V, angle)
    return Rotor(angle, omega, (m.xq - m.xq1) * i.q, inputs.E_f - (m.xd - m.xd1) * i.d)


def from_terminal_voltage(xp, p: Parameters, inputs: Inputs):
    """The equilibrium for (P_m, V_t_start), and the E_f that it needs; x_line > 0.

    P = V_t V sin(theta)/x_line, by fixed-point iteration on the stator's losses; the q axis is along
    V_t + (Ra + j xq) I.
    """
    m, V, V_t = p.machine, inputs.V_inf, p.V_t_start
    X = xp.maximum(p.x_line, 1e-9)  # x_line = 0 is refused where this start is asked for
    omega = thevenin(p, inputs, False).omega
    P_air = inputs.P_m - m.D * omega
    P = P_air
    theta = along = across = 0.0
    for _ in range(20):
        sin = xp.minimum(xp.maximum(P * X / (V_t * xp.maximum(V, 1e-9)), -1.0), 1.0)
        theta = xp.atan2(sin, xp.sqrt(1 - sin * sin))
        along, across = P / V_t, (V_t - V * xp.cos(theta)) / X  # of I = (P - jQ)/V_t, with Q = V_t across
        P = P_air - m.Ra * (along * along + across * across)
    load_angle = xp.atan2(m.xq * along - m.Ra * across, V_t + m.Ra * along + m.xq * across)
    Iq = along * xp.cos(load_angle) - across * xp.sin(load_angle)
    Id = along * xp.sin(load_angle) + across * xp.cos(load_angle)
    e1q = V_t * xp.cos(load_angle) + m.Ra * Iq + m.xd1 * Id
    rotor = Rotor(theta + load_angle, omega, (m.xq - m.xq1) * Iq, e1q)
    return rotor, e1q + (m.xd - m.xd1) * Id


def rules(xp, p: Parameters, inputs: Inputs) -> List[Rule]:
    """What must hold of parameters that are each in range; the start from an equilibrium needs one that exists."""
    by_voltage = p.start_mode == P_M_V_T
    has_line = xp.logical_or(p.start_mode != P_M_V_T, p.x_line > 0)
    voltage, E_f = from_terminal_voltage(xp, p, inputs)
    field = from_field_voltage(xp, p, inputs)
    rotor = Rotor(*[xp.where(by_voltage, v, f) for v, f in zip(voltage, field)])
    driven = inputs._replace(E_f=xp.where(by_voltage, E_f, inputs.E_f))
    rates = derivative(xp, p, thevenin(p, inputs, False), driven, rotor)
    at_rest = sum(xp.abs(rate) for rate in rates) < 1e-6
    return [
        *reactance_rules(p.machine),
        Rule(p.t_clear >= p.t_fault, "t_clear = {t_clear} is not allowed; it must be in [t_fault = {t_fault}, inf] s"),
        Rule(has_line, "x_line = {x_line} is not allowed with start_mode = 3 (P_m_V_t); it must be above 0 pu"),
        Rule(
            xp.logical_or(p.start_mode == STATES, xp.logical_or(xp.logical_not(has_line), at_rest)),
            "P_m = {P_m} is not allowed with start_mode = {start_mode}: there is no equilibrium; "
            "lower P_m, or raise E_f, V_t_start or V_inf",
        ),
    ]
