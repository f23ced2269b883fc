"""The two-axis machine of the paper, here with saturation and transient saliency: a field in d, one damper in q.

    T'd0 E'q' = E_f - E'q - (xd - x'd) Id - S f_q
    T'q0 E'd' =     - E'd + (xq - x'q) Iq - S f_d (xq - xr)/(xd - xr)
    f_d = E'd + (x'q - xr) Iq,  f_q = E'q - (x'd - xr) Id,  S = S(|f|), quadratic

f is the voltage behind xr that saturates: xr = x''d makes this GENROU with damper windings that are fast. Without
saturation xr is of no effect, and x'd for x'd = x'q gives the paper's form, with its constants:

    x1' = x2                                          x = (delta, omega, E'd, E'q)     rad, rad/s, pu, pu
    x2' = -a0 x2 + b0 (u1 - y5)                       u = (Pm, Ef)                     pu, pu
    x3' = -a2 x3 + b2 y2 sin(x1 - y1)                 y = (theta, V, phi, I, P, Q)     rad, pu, rad, pu, pu, pu
    x4' = -a1 x4 + b1 y2 cos(x1 - y1) + c1 u2

x2 is the deviation from synchronous speed. Bobtsov et al. (2020), eq. (1)-(3); x'd = x'q and zero stator resistance.
"""

from typing import Any, List, NamedTuple

from ..interface import Rule, Scalar
from ..linear import Vector
from .axes import Axes, Axis
from .data import Machine, reactance_rules
from .saturation import Saturation, quadratic, saturation_rule
from .stator import Field, Stator, behind, magnitude, magnitude_behind

STATES = ("e1d", "e1q")
"""Of the linear form, those of the d axis first."""

D_STATES = 1
SALIENT = True


class Windings(NamedTuple):
    """States of the nonlinear form, pu."""

    e1d: Scalar
    e1q: Scalar


# The nonlinear form ---------------------------------------------------------------------------------------------------


def saturates(m: Machine):
    return m.S10 + m.S12 > 0


def behind_which_saturates(xp, m: Machine):
    """xr, pu."""
    return xp.where(saturates(m), m.xd2, m.xd1)


def ratio(xp, m: Machine):
    """(xq - xr)/(xd - xr): how the field's saturation carries over to the q axis."""
    xr = behind_which_saturates(xp, m)
    return xp.where(saturates(m), (m.xq - xr) / xp.maximum(m.xd - xr, 1e-6), 0.0)


def stator(xp, m: Machine, x: Windings, S) -> Stator:
    return Stator(Vector(x.e1d, x.e1q), m.xd1, m.xq1)


def saturation(xp, m: Machine, v: Vector, i: Vector):
    """S, from the voltage behind Ra and the current, both in the rotor's frame."""
    return quadratic(xp, m.S10, m.S12, magnitude(xp, behind(v, i, behind_which_saturates(xp, m)))).S


def rates(xp, m: Machine, x: Windings, i: Vector, S, E_f) -> Windings:
    xr = behind_which_saturates(xp, m)
    f_d, f_q = x.e1d + (m.xq1 - xr) * i.q, x.e1q - (m.xd1 - xr) * i.d
    return Windings(
        e1d=(-x.e1d + (m.xq - m.xq1) * i.q - S * ratio(xp, m) * f_d) / m.Tq10,
        e1q=(E_f - x.e1q - (m.xd - m.xd1) * i.d - S * f_q) / m.Td10,
    )


def at_rest(xp, m: Machine, S) -> Field:
    xr, S_q = behind_which_saturates(xp, m), S * ratio(xp, m)
    return Field(1 + S, xr + (m.xd - xr) / (1 + S), xr + (m.xq - xr) / (1 + S_q))


def windings_at_rest(xp, m: Machine, v: Vector, i: Vector, S) -> Windings:
    return Windings(v.d - m.xq1 * i.q, v.q + m.xd1 * i.d)


def voltages(xp, m: Machine, x: Windings, i: Vector, S):
    """(E'd, E'q), and no subtransient ones."""
    return Vector(x.e1d, x.e1q), Vector(0.0, 0.0)


# The linear, time-varying form ----------------------------------------------------------------------------------------


field_of_saturation = None
"""Every saturation is one that a PMU sees."""


def seen(xp, m: Machine, V, I, Q) -> Saturation:  # noqa: E741 - the paper's name
    """S and its slope from a frame, with the terminal moved behind Ra."""
    return quadratic(xp, m.S10, m.S12, magnitude_behind(xp, V, I, Q, behind_which_saturates(xp, m)))


def reactance(xp, m: Machine, S):
    """x of the measured voltage F = V + (Ra + j x) I."""
    return behind_which_saturates(xp, m)


def axis(x, x1, T1, xr, saturating) -> Axis:
    """p' = [E_f - p + (x - x') i - S f]/T' with f = p + (x' - xr) i, and S times `saturating`."""
    X = x1 - xr
    return Axis(((-(1 + saturating) / T1,),), k=((x - x1 - saturating * X) / T1,), e=(1 / T1,), drop=(X,))


def axes(xp, m: Machine, S) -> Axes:
    xr = behind_which_saturates(xp, m)
    return Axes(axis(m.xq, m.xq1, m.Tq10, xr, S * ratio(xp, m)), axis(m.xd, m.xd1, m.Td10, xr, S))


def rules(xp, m: Machine) -> List[Rule]:
    """x' <= x on both axes; with saturation x'' <= x'd < xd."""
    linear = xp.logical_not(saturates(m))
    return [
        *reactance_rules(m),
        Rule(m.xd1 <= m.xq, "xd1 = {xd1} is not allowed; it must be in (0, xq = {xq}] pu"),  # b2 >= 0
        Rule(
            xp.logical_or(linear, m.xd2 <= m.xd1),
            "xd2 = {xd2} is not allowed with saturation; it must be at most xd1 = {xd1} pu",
        ),
        Rule(
            xp.logical_or(linear, m.xd1 < m.xd),
            "xd1 = {xd1} is not allowed with saturation; it must be below xd = {xd} pu",
        ),
        saturation_rule(m),
    ]


# The paper's constants ------------------------------------------------------------------------------------------------


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
    machine: Any = None  # its data, and
    model: Any = None  # its MachineModel, for the estimators that work with any


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
