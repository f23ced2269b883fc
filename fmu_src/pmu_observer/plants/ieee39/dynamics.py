"""Ten machines with their controllers: the equations, and the equilibrium that belongs to the power flow.

    machine     delta' = omega                       j E' = e^{j delta} (E'd + j E'q), likewise for V and I
                omega' = omega_s/(2H) (P_m - P)
                T'd0 E'q' = E_f - E'q - (xd - x'd) Id        Vd = E'd + x'q Iq
                T'q0 E'd' =     - E'd + (xq - x'q) Iq        Vq = E'q - x'd Id
    AVR         E_f = KA/(1 + s TA) (1 + s TC)/(1 + s TB) (V_ref + V_s - V/(1 + s TR)), a non-windup limit on E_f
    PSS         V_s = K s Tw/(1 + s Tw) (1 + s T1)/(1 + s T2) (1 + s T3)/(1 + s T4) omega/omega_s, limited
    governor    P_m = P_m0 - P_m0/0.05 1/(1 + 0.2 s) 1/(1 + 0.5 s) omega/omega_s

The tables have no governor (constant P_m): it is our addition, to hold the frequency, which without it integrates every
change of a load.
"""

from functools import cache
from math import pi
from typing import NamedTuple, Tuple

import numpy as np

from ...interface import Scalar
from .. import runge_kutta
from . import network, tables
from .network import Reduction
from .tables import Machines

OMEGA_S = 2 * pi * 60
"""rad/s, synchronous speed."""

DROOP, T_VALVE, T_TURBINE = 0.05, 0.2, 0.5
"""pu speed per dispatched power; s; s."""


class States(NamedTuple):
    """Each with one element a generator."""

    delta: Scalar  # rad
    omega: Scalar  # rad/s
    e1d: Scalar  # pu
    e1q: Scalar  # pu
    V_measured: Scalar  # pu, behind 1/(1 + s TR)
    lag: Scalar  # pu, of (1 + s TC)/(1 + s TB)
    E_f: Scalar  # pu
    washout: Scalar  # pu, of the PSS, like its two lags
    lag1: Scalar
    lag2: Scalar
    valve: Scalar  # pu, what the governor adds to the power
    turbine: Scalar  # pu


E_F = States._fields.index("E_f")


class Setpoints(NamedTuple):
    P_m: np.ndarray  # pu
    V_ref: np.ndarray  # pu


class System(NamedTuple):
    """What the equations need besides the states and the network."""

    machines: Machines
    setpoints: Setpoints
    lags: np.ndarray  # (10, 10) s, the time constants of the states from e1d on
    governors: bool
    pss: bool
    salient: bool


class Terminals(NamedTuple):
    """Complex, one element a generator."""

    V: Scalar  # in the synchronous frame, like I and E
    I: Scalar  # noqa: E741 - the paper's name
    I_dq: Scalar  # in rotor axes, d + jq
    S: Scalar  # P + jQ, generated
    E: Scalar  # behind x'd: what drives the network


def terminals(m: Machines, salient, grid: Reduction, delta, e1d, e1q) -> Terminals:
    """V + j x'd I = E' + (x'q - x'd) Iq along the d axis, I = I_per_E E: without saliency nothing is to be solved."""
    axes = np.exp(1j * delta) / 1j
    E_dq = e1d + 1j * e1q
    if salient:
        # Iq is linear in E_dq, and E_dq in Iq
        in_dq = axes.conj()[:, None] * grid.I_per_E * axes
        saliency = m.xq1 - m.xd1
        Iq = np.linalg.solve(np.eye(len(delta)) - in_dq.imag * saliency, (in_dq @ E_dq).imag)
        E_dq = E_dq + saliency * Iq
    E = axes * E_dq
    current = grid.I_per_E @ E
    V = E - 1j * m.xd1 * current
    return Terminals(V, current, current * axes.conj(), V * current.conj(), E)


def derivative(system: System, grid: Reduction, x: np.ndarray) -> np.ndarray:
    """dx/dt of the states x, (12, 10): all but delta and omega are lags, (target - x)/T."""
    m, s = system.machines, States(*x)
    at = terminals(m, system.salient, grid, s.delta, s.e1d, s.e1q)
    slip = s.omega / OMEGA_S

    washed = m.K * (slip - s.washout)
    lead1 = s.lag1 + m.T1 / m.T2 * (washed - s.lag1)
    lead2 = s.lag2 + m.T3 / m.T4 * (lead1 - s.lag2)
    V_s = np.minimum(np.maximum(lead2, m.V_s_min), m.V_s_max) if system.pss else 0.0
    error = system.setpoints.V_ref + V_s - s.V_measured
    regulated = m.KA * (s.lag + m.TC / m.TB * (error - s.lag))
    E_f = limited(s.E_f, m)  # a stage of the integration may lie beyond
    P_m = system.setpoints.P_m

    dx = np.empty_like(x)
    dx[0] = s.omega
    dx[1] = OMEGA_S / 2 / m.H * (P_m + s.turbine - at.S.real)
    dx[2:] = [  # targets, in the order of States
        (m.xq - m.xq1) * at.I_dq.imag,
        E_f - (m.xd - m.xd1) * at.I_dq.real,
        np.abs(at.V),
        error,
        regulated,
        slip,
        washed,
        lead1,
        P_m * slip / -DROOP if system.governors else np.zeros_like(slip),
        s.valve,
    ]
    dx[2:] -= x[2:]
    dx[2:] /= system.lags
    # at a limit, E_f moves inwards only
    rise = dx[E_F]
    dx[E_F] = np.where(E_f == m.E_f_max, np.minimum(rise, 0), np.where(E_f == m.E_f_min, np.maximum(rise, 0), rise))
    return dx


def advanced(system: System, grid: Reduction, x: np.ndarray, h: float) -> np.ndarray:
    """The states after h; E_f ends within its limits."""
    x = runge_kutta.step(lambda x: derivative(system, grid, x), x, h)
    x[E_F] = limited(x[E_F], system.machines)
    return x


def limited(E_f, m: Machines):
    return np.minimum(np.maximum(E_f, m.E_f_min), m.E_f_max)


@cache
def load_admittances() -> np.ndarray:
    """(39,) of the loads at the operating point: constant impedances."""
    point = network.power_flow()
    return point.S_load.conj() / np.abs(point.V) ** 2


@cache
def equilibrium(governors: bool, pss: bool, salient: bool) -> Tuple[System, np.ndarray]:
    """The system with the set points of the power flow, and its states (12, 10) at rest."""
    machines = tables.machines(salient)
    point = network.power_flow()
    V = point.V[machines.bus - 1]
    current = (point.S_generated[machines.bus - 1] / V).conj()
    delta = np.angle(V + 1j * machines.xq * current)  # the q axis
    V_dq, I_dq = (phasor * 1j * np.exp(-1j * delta) for phasor in (V, current))
    e1d, e1q = V_dq.real - machines.xq1 * I_dq.imag, V_dq.imag + machines.xd1 * I_dq.real

    # from here on with the network's own voltages and currents, so that nothing of the power flow's rounding is left
    loaded = network.admittance() + np.diag(load_admittances())
    grid = network.reduction(loaded, machines.bus, machines.xd1)
    at = terminals(machines, salient, grid, delta, e1d, e1q)
    E_f = e1q + (machines.xd - machines.xd1) * at.I_dq.real
    zero = np.zeros_like(delta)
    lag = E_f / machines.KA
    x = States(delta, zero, e1d, e1q, np.abs(at.V), lag, E_f, *[zero] * 5)
    setpoints = Setpoints(P_m=at.S.real, V_ref=np.abs(at.V) + lag)
    m, every = machines, np.ones_like(delta)
    lags = [m.Tq10, m.Td10, m.TR, m.TB, m.TA, m.Tw, m.T2, m.T4, T_VALVE * every, T_TURBINE * every]
    return System(machines, setpoints, np.array(lags), governors, pss, salient), np.array(x)
