"""The data of a machine, and its bases.

One list of data for all models: each takes what it needs of it, and its rules look at nothing else.
"""

from math import pi
from typing import Annotated, List, NamedTuple

from ..interface import Real, Rule, Scalar


class Machine(NamedTuple):
    """Physical data of a machine, per unit on one common base; the names are those of ANDES and OpenIPSL (1 = prime).

    The defaults are the machine of the paper's single-machine study. What its Table 1 leaves out is solved back
    from the table's a2 and b2: xq = xd, x'q = x'd, T'q0 = 0.31 s. The subtransient data are plausible, not the paper's.
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
    xd2: Annotated[
        Scalar,
        Real("pu", "d-axis subtransient reactance x''d; not gentpj: x''q as well", min=1e-4, max=1e2),
    ] = 0.05
    xq2: Annotated[Scalar, Real("pu", "q-axis subtransient reactance x''q; gentpj only", min=1e-4, max=1e2)] = 0.05
    xl: Annotated[Scalar, Real("pu", "leakage reactance; not two_axis", min=0.0, max=1e2)] = 0.03
    Td20: Annotated[
        Scalar, Real("s", "d-axis open-circuit subtransient time constant T''d0; not two_axis", min=1e-3, max=1e2)
    ] = 0.03
    Tq20: Annotated[
        Scalar, Real("s", "q-axis open-circuit subtransient time constant T''q0; not two_axis", min=1e-3, max=1e2)
    ] = 0.05
    S10: Annotated[Scalar, Real("1", "saturation S(1.0) at a flux of 1 pu; 0: none", min=0.0, max=10.0)] = 0.0
    S12: Annotated[Scalar, Real("1", "saturation S(1.2) at a flux of 1.2 pu", min=0.0, max=10.0)] = 0.0
    Kis: Annotated[
        Scalar, Real("pu", "flux that a current of 1 pu adds to the saturating one; gentpj only", min=0.0, max=10.0)
    ] = 0.0


def paper_smib() -> Machine:
    """The machine of the paper's single-machine study (its Table 1)."""
    return Machine()


def ieee39_g6() -> Machine:
    """Generator 6 of the IEEE 39-bus system (Hiskens 2013), pu on 100 MVA, with x'q := x'd as the paper has it."""
    return Machine(34.8, 0.0, 0.254, 0.05, 0.241, 0.05, 7.3, 0.4, 0.0, 2 * pi * 60)


def on_system_base(machine: Machine, S_n, S_base) -> Machine:
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
        xd2=machine.xd2 * up,
        xq2=machine.xq2 * up,
        xl=machine.xl * up,
        Kis=machine.Kis * up,
    )


def reactance_rules(machine: Machine) -> List[Rule]:
    """No transient reactance is above its synchronous one: no machine is so, and A would be unstable."""
    return [
        Rule(machine.xd1 <= machine.xd, "xd1 = {xd1} is not allowed; it must be in (0, xd = {xd}] pu"),
        Rule(machine.xq1 <= machine.xq, "xq1 = {xq1} is not allowed; it must be in (0, xq = {xq}] pu"),
    ]
