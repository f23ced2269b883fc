"""A machine with subtransient circuits (Sauer and Pai, 6th order) behind a line at an infinite bus, with a fault.

    T'd0 E'q'  = E_f - E'q - (xd - x'd)(Id - (x'd - x''d)/(x'd - xl)^2 (psi1d + (x'd - xl) Id - E'q))
    T''d0 psi1d' = -psi1d + E'q - (x'd - xl) Id
    T'q0 E'd'  = -E'd + (xq - x'q)(Iq - (x'q - x''q)/(x'q - xl)^2 (psi2q + (x'q - xl) Iq + E'd))
    T''q0 psi2q' = -psi2q - E'd - (x'q - xl) Iq

What the observer's 4th-order model leaves out; P. W. Sauer, M. A. Pai, "Power System Dynamics and Stability", ch. 3.
"""

from typing import NamedTuple

import numpy as np

from fmu_src.pmu_observer.plants import runge_kutta

from . import smib_fault
from .frames import PERIOD, Truth

SUBSTEPS = 16
"""Steps between two frames, about 1 ms."""


class Subtransient(NamedTuple):
    """Of the record's 6th-order generator 6, pu on 100 MVA and s."""

    x2: float = 0.04
    xl: float = 0.0224
    Td20: float = 0.05
    Tq20: float = 0.035


class Grid(NamedTuple):
    V: float
    X: float


def simulate(seconds: float, fault: smib_fault.Fault) -> Truth:
    """The machine of smib_fault with these circuits, from the same equilibrium, E_f constant."""
    m, s, machines = smib_fault.machine(), Subtransient(), smib_fault.plant()
    P, V_t, x_line = machines.inputs.P_m, machines.parameters.V_t_start, machines.parameters.x_line
    t_fault, t_clear, x_fault = fault
    theta = np.arcsin(P * x_line / V_t)  # the infinite bus has 1 pu
    V = V_t * np.exp(1j * theta)
    I = (V - 1.0) / (1j * x_line)  # noqa: E741 - the paper's name
    delta = np.angle(V + 1j * m.xq * I)
    Id, Iq = parts(1j * I * np.exp(-1j * delta))
    Vq = parts(1j * V * np.exp(-1j * delta))[1]
    E_f = Vq + m.xd * Id
    e1d, e1q = (m.xq - m.xq1) * Iq, E_f - (m.xd - m.xd1) * Id
    psi1d, psi2q = e1q - (m.xd1 - s.xl) * Id, -e1d - (m.xq1 - s.xl) * Iq
    state = np.array([delta, 0.0, e1d, e1q, psi1d, psi2q])
    healthy = Grid(1.0, x_line)
    share = x_fault / (x_line + x_fault)
    faulted = Grid(share, share * x_line)
    h = PERIOD / SUBSTEPS
    events = [t_fault, t_clear, np.inf]

    def advance(state, t, span):
        """Runge-Kutta of order 4, with a stop at every event."""
        end = t + span
        while end - t > 1e-12:
            until = min([end, *[e for e in events if e > t + 1e-12]])
            grid = faulted if t_fault <= t + 1e-12 < t_clear else healthy
            state = runge_kutta.step(lambda x, g=grid: derivative(m, s, g, P, E_f, x), state, until - t)
            t = until
        return state

    rows = []
    for k in range(round(seconds / PERIOD) + 1):
        t = k * PERIOD
        grid = faulted if t_fault <= t + 1e-9 < t_clear else healthy
        rows.append(row(m, s, grid, P, E_f, state))
        for i in range(SUBSTEPS):
            state = advance(state, t + i * h, h)
    V, I, *rest = [np.array(column) for column in zip(*rows, strict=True)]  # noqa: E741 - the paper's name
    return Truth(m, V, I, *rest)


def parts(z):
    return z.real, z.imag


def currents(m, s: Subtransient, grid: Grid, state):
    """Id, Iq and the subtransient voltages: V sin a = e''d + (x'' + X) Iq, V cos a = e''q - (x'' + X) Id."""
    angle, _, e1d, e1q, psi1d, psi2q = state
    gd, gq = (s.x2 - s.xl) / (m.xd1 - s.xl), (s.x2 - s.xl) / (m.xq1 - s.xl)
    e2d, e2q = gq * e1d - (1 - gq) * psi2q, gd * e1q + (1 - gd) * psi1d
    X = s.x2 + grid.X
    return (e2q - grid.V * np.cos(angle)) / X, (grid.V * np.sin(angle) - e2d) / X, e2d, e2q


def derivative(m, s: Subtransient, grid: Grid, P, E_f, state):
    _, omega, e1d, e1q, psi1d, psi2q = state
    Id, Iq, e2d, e2q = currents(m, s, grid, state)
    torque = e2d * Id + e2q * Iq
    b0 = m.omega_s / (2 * m.H)
    leak_d, leak_q = m.xd1 - s.xl, m.xq1 - s.xl
    field = Id - (m.xd1 - s.x2) / leak_d**2 * (psi1d + leak_d * Id - e1q)
    rotor = Iq - (m.xq1 - s.x2) / leak_q**2 * (psi2q + leak_q * Iq + e1d)
    return np.array(
        [
            omega,
            b0 * (P - torque - m.D * omega),
            (-e1d + (m.xq - m.xq1) * rotor) / m.Tq10,
            (E_f - e1q - (m.xd - m.xd1) * field) / m.Td10,
            (-psi1d + e1q - leak_d * Id) / s.Td20,
            (-psi2q - e1d - leak_q * Iq) / s.Tq20,
        ]
    )


def row(m, s, grid: Grid, P, E_f, state):
    angle, omega, e1d, e1q, *_ = state
    Id, Iq, e2d, e2q = currents(m, s, grid, state)
    turn = -1j * np.exp(1j * angle)
    V = turn * (e2d + s.x2 * Iq + 1j * (e2q - s.x2 * Id))
    return V, turn * (Id + 1j * Iq), P, E_f, angle, omega, e1d, e1q
