"""GENSAE, a salient-pole machine with a field and two dampers: GENROU without E'd, and with exponential saturation.

    T'd0 E'q' = E_f - E'q - (xd - x'd)[Id + (x'd - x'')/(x'd - xl)^2 (E'q - psi_kd - (x'd - xl) Id)] - S E''q
    T''d0 psi_kd' = E'q - psi_kd - (x'd - xl) Id
    T''q0 E''d' = - E''d + (xq - x'') Iq - S E''d (xq - xl)/(xd - xl)
    E''q = g E'q + (1 - g) psi_kd,  g = (x'' - xl)/(x'd - xl),  S = S(1.0) |E''|^X

x''d = x''q = x'' =: xd2. PowerWorld, "Machine Model GENSAE". There is no E'd: e1d is 0.
"""

from typing import List, NamedTuple

from ..interface import Rule, Scalar
from ..linear import Vector
from .axes import Axes, Axis
from .data import Machine
from .genrou import axis as genrou_axis
from .saturation import Saturation, exponential, saturation_rule
from .stator import Field, Stator, behind, magnitude, magnitude_behind

STATES = ("e2d", "e2q", "e1q")
D_STATES = 1
SALIENT = False


class Windings(NamedTuple):
    """States of the nonlinear form, pu."""

    e1q: Scalar
    psi_kd: Scalar
    e2d: Scalar


# The nonlinear form ---------------------------------------------------------------------------------------------------


def subtransient(m: Machine, x: Windings) -> Vector:
    """(E''d, E''q)."""
    g = (m.xd2 - m.xl) / (m.xd1 - m.xl)
    return Vector(x.e2d, g * x.e1q + (1 - g) * x.psi_kd)


def stator(xp, m: Machine, x: Windings, S) -> Stator:
    return Stator(subtransient(m, x), m.xd2, m.xd2)


def saturation(xp, m: Machine, v: Vector, i: Vector):
    """S, from the voltage behind Ra and the current, both in the rotor's frame."""
    return exponential(xp, m.S10, m.S12, magnitude(xp, behind(v, i, m.xd2))).S


def rates(xp, m: Machine, x: Windings, i: Vector, S, E_f) -> Windings:
    e2, leak = subtransient(m, x), m.xd1 - m.xl
    S_q = S * (m.xq - m.xl) / (m.xd - m.xl)
    psi_kd = x.e1q - x.psi_kd - leak * i.d
    field = i.d + (m.xd1 - m.xd2) / (leak * leak) * psi_kd
    return Windings(
        e1q=(E_f - x.e1q - (m.xd - m.xd1) * field - S * e2.q) / m.Td10,
        psi_kd=psi_kd / m.Td20,
        e2d=(-x.e2d + (m.xq - m.xd2) * i.q - S_q * x.e2d) / m.Tq20,
    )


def at_rest(xp, m: Machine, S) -> Field:
    S_q = S * (m.xq - m.xl) / (m.xd - m.xl)
    return Field(1 + S, m.xd2 + (m.xd - m.xd2) / (1 + S), m.xd2 + (m.xq - m.xd2) / (1 + S_q))


def windings_at_rest(xp, m: Machine, v: Vector, i: Vector, S) -> Windings:
    e2 = behind(v, i, m.xd2)
    e1q = e2.q + (m.xd1 - m.xd2) * i.d
    return Windings(e1q, e1q - (m.xd1 - m.xl) * i.d, e2.d)


def voltages(xp, m: Machine, x: Windings, i: Vector, S):
    """(E'd, E'q) and (E''d, E''q), as the observer gives them."""
    return Vector(0.0, x.e1q), subtransient(m, x)


# The linear, time-varying form ----------------------------------------------------------------------------------------


field_of_saturation = None
"""Every saturation is one that a PMU sees."""


def seen(xp, m: Machine, V, I, Q) -> Saturation:  # noqa: E741 - the paper's name
    """S and its slope from a frame, with the terminal moved behind Ra."""
    return exponential(xp, m.S10, m.S12, magnitude_behind(xp, V, I, Q, m.xd2))


def reactance(xp, m: Machine, S):
    """x of the measured voltage F = V + (Ra + j x) I."""
    return m.xd2


def axes(xp, m: Machine, S) -> Axes:
    S_q = S * (m.xq - m.xl) / (m.xd - m.xl)
    damper = Axis(M=((-(1 + S_q) / m.Tq20,),), k=((m.xq - m.xd2) / m.Tq20,), e=(0.0,), drop=(0.0,))
    return Axes(damper, genrou_axis(m.xd, m.xd1, m.xd2, m.xl, m.Td10, m.Td20, S))


def rules(xp, m: Machine) -> List[Rule]:
    """xl < x'' <= x'd <= xd, x'' <= xq."""
    return [
        Rule(m.xd1 <= m.xd, "xd1 = {xd1} is not allowed; it must be in (0, xd = {xd}] pu"),
        Rule(m.xd2 > m.xl, "xd2 = {xd2} is not allowed; it must be above xl = {xl} pu"),
        Rule(m.xd2 <= m.xd1, "xd2 = {xd2} is not allowed; it must be at most xd1 = {xd1} pu"),
        Rule(m.xd2 <= m.xq, "xd2 = {xd2} is not allowed; it must be at most xq = {xq} pu"),
        saturation_rule(m),
    ]
