"""The two-axis machine: physical data, and the constants that the paper writes the equations with.

    x1' = x2                                          x = (delta, omega, E'd, E'q)     rad, rad/s, pu, pu
    x2' = -a0 x2 + b0 (u1 - y5)                       u = (Pm, Ef)                     pu, pu
    x3' = -a2 x3 + b2 y2 sin(x1 - y1)                 y = (theta, V, phi, I, P, Q)     rad, pu, rad, pu, pu, pu
    x4' = -a1 x4 + b1 y2 cos(x1 - y1) + c1 u2

x2 is the deviation from synchronous speed. Bobtsov et al. (2020), eq. (1)-(3); x'd = x'q and zero stator resistance.
"""

from typing import NamedTuple

from ..interface import Scalar
from .data import Machine


class Constants(NamedTuple):
    """The paper's constants of a machine; `x` is its x', the transient reactance."""

    a0: Scalar  # 1/s
    b0: Scalar  # rad/s^2 per pu
    a1: Scalar  # 1/s
    b1: Scalar  # 1/s
    c1: Scalar  # 1/s
    a2: Scalar  # 1/s
    b2: Scalar  # 1/s
    x: Scalar  # pu


def constants(machine: Machine) -> Constants:
    """The constants a0 ... c1 below eq. (3) of the paper, with x' := x'd (for x'q see `observer.predict`)."""
    x = machine.xd1
    b0 = machine.omega_s / (2 * machine.H)
    c1 = 1 / machine.Td10
    return Constants(
        a0=machine.D * b0,
        b0=b0,
        a1=c1 * machine.xd / x,
        b1=c1 * (machine.xd - x) / x,
        c1=c1,
        a2=machine.xq / (x * machine.Tq10),
        b2=(machine.xq - x) / (x * machine.Tq10),
        x=x,
    )
