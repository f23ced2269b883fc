"""The 39-bus network: admittances, power flow, and what the machines see of it.

Bus n is row n - 1. Phasors are in the synchronous frame, pu on 100 MVA; the angle of bus 31 (slack) is 0 at the start.
"""

from functools import cache
from typing import NamedTuple, Tuple

import numpy as np

from . import tables

BUSES = 39


class OperatingPoint(NamedTuple):
    """The power flow's solution."""

    V: np.ndarray  # (39,) bus voltages
    S_load: np.ndarray  # (39,) P + jQ drawn by the loads
    S_generated: np.ndarray  # (39,) P + jQ generated; 0 where there is no generator


class Reduction(NamedTuple):
    """Loads are admittances, so that currents and voltages are linear in the voltages E' behind x'd of the machines."""

    I_per_E: np.ndarray  # (10, 10)
    V_per_E: np.ndarray  # (39, 10)


@cache
def admittance(skipped: int = -1) -> np.ndarray:
    """The bus admittance matrix (39, 39), without the branch in row `skipped` of the table."""
    branches = tables.branches()
    Y = np.zeros((BUSES, BUSES), dtype=complex)
    for row, (fbus, tbus, r, x, b, tap) in enumerate(zip(*branches)):
        if row == skipped:
            continue
        f, t = fbus - 1, tbus - 1
        y = 1 / complex(r, x)
        Y[f, f] += (y + 0.5j * b) / tap**2
        Y[t, t] += y + 0.5j * b
        Y[f, t] -= y / tap
        Y[t, f] -= y / tap
    return Y


@cache
def find_branch(bus1: int, bus2: int) -> int:
    """The row of the branch between two buses in the table, or -1."""
    branches = tables.branches()
    ends = [{f, t} for f, t in zip(branches.fbus.tolist(), branches.tbus.tolist())]
    return ends.index({bus1, bus2}) if {bus1, bus2} in ends else -1


def separated(skipped: int) -> Tuple[int, ...]:
    """The buses that have no path to bus 1 without one branch."""
    connected = admittance(skipped) != 0
    reached = np.eye(1, BUSES, dtype=bool)[0]
    for _ in range(BUSES):
        reached = reached | connected[reached].any(axis=0)
    return tuple((np.flatnonzero(~reached) + 1).tolist())


@cache
def power_flow() -> OperatingPoint:
    """Newton's method in polar coordinates, from the generators' set points (V, P) and the loads (P, Q)."""
    bus, setpoints = tables.BUS, tables.SETPOINTS
    S_load = np.array(bus["Pload"], dtype=float) + 1j * np.array(bus["Qload"], dtype=float)
    kind = np.array(bus["type"])
    V_set = np.ones(BUSES)
    P_generated = np.zeros(BUSES)
    for at, V, P in zip(setpoints["bus"], setpoints["V"], setpoints["P"]):
        V_set[int(at) - 1] = float(V)
        P_generated[int(at) - 1] = 0.0 if P == "slack" else float(P)

    Y = admittance()
    S_set = P_generated - S_load
    angles, magnitudes = np.flatnonzero(kind != "slack"), np.flatnonzero(kind == "PQ")
    V = V_set.astype(complex)
    for _ in range(10):
        current = Y @ V
        mismatch = S_set - V * current.conj()
        # columns: by angle, by relative magnitude
        dS_dangle = 1j * np.diag(V) @ (np.diag(current) - Y @ np.diag(V)).conj()
        dS_dmagnitude = np.diag(V) @ (np.diag(current) + Y @ np.diag(V)).conj()
        jacobian = np.block(
            [
                [dS_dangle.real[np.ix_(angles, angles)], dS_dmagnitude.real[np.ix_(angles, magnitudes)]],
                [dS_dangle.imag[np.ix_(magnitudes, angles)], dS_dmagnitude.imag[np.ix_(magnitudes, magnitudes)]],
            ]
        )
        error = np.concatenate([mismatch.real[angles], mismatch.imag[magnitudes]])
        change = np.linalg.solve(jacobian, error)
        turn, growth = np.zeros(BUSES), np.zeros(BUSES)
        turn[angles], growth[magnitudes] = change[: len(angles)], change[len(angles) :]
        V = V * (1 + growth) * np.exp(1j * turn)
    S = V * (Y @ V).conj()
    return OperatingPoint(V, S_load, np.where(kind == "PQ", 0, S + S_load))


def reduction(Y: np.ndarray, bus: np.ndarray, xd1: np.ndarray) -> Reduction:
    """From the admittances of network and loads. The machines inject (E' - V)/(j x'd): V = (Y + Y')^-1 Y' E'."""
    own = 1 / (1j * xd1)
    Y = Y.copy()
    Y[bus - 1, bus - 1] += own
    injected = np.zeros((BUSES, len(bus)), dtype=complex)
    injected[bus - 1, np.arange(len(bus))] = own
    V_per_E = np.linalg.solve(Y, injected)
    return Reduction(own[:, None] * (np.eye(len(bus)) - V_per_E[bus - 1]), V_per_E)
