"""The two-axis machine: physical data, and the constants that the paper writes the equations with.

    x1' = x2                                          x = (delta, omega, E'd, E'q)     rad, rad/s, pu, pu
    x2' = -a0 x2 + b0 (u1 - y5)                       u = (Pm, Ef)                     pu, pu
    x3' = -a2 x3 + b2 y2 sin(x1 - y1)                 y = (theta, V, phi, I, P, Q)     rad, pu, rad, pu, pu, pu
    x4' = -a1 x4 + b1 y2 cos(x1 - y1) + c1 u2

x2 is the deviation from synchronous speed. Bobtsov et al. (2020), eq. (1)-(3); x'd = x'q and zero stator resistance.
"""

from math import pi
from typing import Annotated, List, NamedTuple

from .interface import Real, Rule, Scalar


class TwoAxisMachine(NamedTuple):
    """Physical data of a machine, per unit on one common base; the names are those of ANDES and OpenIPSL (1 = prime).

    The defaults are the machine of the paper's single-machine study. What its Table 1 leaves out is solved back
    from the table's a2 and b2: xq = xd, x'q = x'd, T'q0 = 0.31 s.
    """

    H: Annotated[Scalar, Real("s", "inertia constant", min=1e-2, max=1e4)] = 23.64
    D: Annotated[
        Scalar,
        Real(
            "s/rad",
            "damping as in the paper: pu torque per rad/s (a D in pu torque per pu speed is divided by omega_s)",
            min=0.0,
            max=1e4,
        ),
    ] = 2.0
    xd: Annotated[Scalar, Real("pu", "d-axis synchronous reactance", min=1e-4, max=1e2)] = 0.146
    xd1: Annotated[Scalar, Real("pu", "d-axis transient reactance x'd", min=1e-4, max=1e2)] = 0.0608
    xq: Annotated[Scalar, Real("pu", "q-axis synchronous reactance", min=1e-4, max=1e2)] = 0.146
    xq1: Annotated[Scalar, Real("pu", "q-axis transient reactance x'q", min=1e-4, max=1e2)] = 0.0608
    Td10: Annotated[Scalar, Real("s", "d-axis open-circuit transient time constant T'd0", min=1e-2, max=1e3)] = 8.96
    Tq10: Annotated[Scalar, Real("s", "q-axis open-circuit transient time constant T'q0", min=1e-2, max=1e3)] = 0.31
    Ra: Annotated[Scalar, Real("pu", "stator resistance", min=0.0, max=1.0)] = 0.0
    omega_s: Annotated[Scalar, Real("rad/s", "synchronous speed", min=1.0, max=1e4, nominal=314.16)] = 314.16


def paper_smib() -> TwoAxisMachine:
    """The machine of the paper's single-machine study (its Table 1)."""
    return TwoAxisMachine()


def ieee39_g6() -> TwoAxisMachine:
    """Generator 6 of the IEEE 39-bus system (Hiskens 2013), pu on 100 MVA, with x'q := x'd as the paper has it."""
    return TwoAxisMachine(34.8, 0.0, 0.254, 0.05, 0.241, 0.05, 7.3, 0.4, 0.0, 2 * pi * 60)


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


def constants(machine: TwoAxisMachine) -> Constants:
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


def on_system_base(machine: TwoAxisMachine, S_n, S_base) -> TwoAxisMachine:
    """Data in pu of the machine's own S_n, MVA, in pu of S_base: reactances by S_base/S_n, H and D by S_n/S_base."""
    up = S_base / S_n
    return machine._replace(
        H=machine.H / up,
        D=machine.D / up,
        xd=machine.xd * up,
        xd1=machine.xd1 * up,
        xq=machine.xq * up,
        xq1=machine.xq1 * up,
        Ra=machine.Ra * up,
    )


def reactance_rules(machine: TwoAxisMachine) -> List[Rule]:
    """No transient reactance is above its synchronous one: no machine is so, and A would be unstable."""
    return [
        Rule(machine.xd1 <= machine.xd, "xd1 = {xd1} is not allowed; it must be in (0, xd = {xd}] pu"),
        Rule(machine.xq1 <= machine.xq, "xq1 = {xq1} is not allowed; it must be in (0, xq = {xq}] pu"),
    ]
