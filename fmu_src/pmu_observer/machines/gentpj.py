"""GENTPJ, the machine that WECC asks for; with Kis = 0 it is GENTPF. Saturation scales reactances; x''d != x''q.

    Sd = 1 + S(psi),  Sq = 1 + (xq/xd) S(psi),  psi = |V + (Ra + j xl) I| + Kis |I|
    T'd0 E'q' = E_f - Sd [(1 + bd) E'q - bd E''q]            b = (x - x')/(x' - x'')
    T'q0 E'd' =     - Sq [(1 + bq) E'd - bq E''d]
    T''d0 E''q' = Sd (E'q - E''q) - (x'd - x''d) Id          T''q0 E''d' = Sq (E'd - E''d) + (x'q - x''q) Iq
    V_d = E''d + X''q Iq - Ra Id,  V_q = E''q - X''d Id - Ra Iq,   X'' = xl + (x'' - xl)/Sat

PowerWorld, "Machine Model GENTPF" and "GENTPJ"; WECC, "GENTPJ specification". Both reactances of the subtransient
voltages depend on psi alone, so that F = V + (Ra + j X''q) I is measured.
"""

from typing import List, NamedTuple

from ..interface import Rule, Scalar
from ..linear import Vector
from .axes import Axes, Axis
from .data import Machine, reactance_rules
from .saturation import Saturation, quadratic, saturation_rule
from .stator import Field, Stator, behind, magnitude, magnitude_behind

STATES = ("e2d", "e1d", "e2q", "e1q")
D_STATES = 2
SALIENT = True


class Windings(NamedTuple):
    """States of the nonlinear form, pu."""

    e1d: Scalar
    e1q: Scalar
    e2d: Scalar
    e2q: Scalar


# The nonlinear form ---------------------------------------------------------------------------------------------------


def stator(xp, m: Machine, x: Windings, S) -> Stator:
    return Stator(
        Vector(x.e2d, x.e2q),
        m.xl + (m.xd2 - m.xl) / (1 + S),
        m.xl + (m.xq2 - m.xl) / (1 + S * m.xq / m.xd),
    )


def saturation(xp, m: Machine, v: Vector, i: Vector):
    """S, from the voltage behind Ra and the current, both in the rotor's frame."""
    return quadratic(xp, m.S10, m.S12, magnitude(xp, behind(v, i, m.xl)) + m.Kis * magnitude(xp, i)).S


def rates(xp, m: Machine, x: Windings, i: Vector, S, E_f) -> Windings:
    S_d, S_q = 1 + S, 1 + S * m.xq / m.xd
    b_d, b_q = (m.xd - m.xd1) / (m.xd1 - m.xd2), (m.xq - m.xq1) / (m.xq1 - m.xq2)
    return Windings(
        e1d=-S_q * ((1 + b_q) * x.e1d - b_q * x.e2d) / m.Tq10,
        e1q=(E_f - S_d * ((1 + b_d) * x.e1q - b_d * x.e2q)) / m.Td10,
        e2d=(S_q * (x.e1d - x.e2d) + (m.xq1 - m.xq2) * i.q) / m.Tq20,
        e2q=(S_d * (x.e1q - x.e2q) - (m.xd1 - m.xd2) * i.d) / m.Td20,
    )


def at_rest(xp, m: Machine, S) -> Field:
    return Field(1 + S, m.xl + (m.xd - m.xl) / (1 + S), m.xl + (m.xq - m.xl) / (1 + S * m.xq / m.xd))


def windings_at_rest(xp, m: Machine, v: Vector, i: Vector, S) -> Windings:
    S_d, S_q = 1 + S, 1 + S * m.xq / m.xd
    e2d = v.d - (m.xl + (m.xq2 - m.xl) / S_q) * i.q
    e2q = v.q + (m.xl + (m.xd2 - m.xl) / S_d) * i.d
    return Windings(e2d - (m.xq1 - m.xq2) * i.q / S_q, e2q + (m.xd1 - m.xd2) * i.d / S_d, e2d, e2q)


def voltages(xp, m: Machine, x: Windings, i: Vector, S):
    """(E'd, E'q) and (E''d, E''q), as the observer gives them."""
    return Vector(x.e1d, x.e1q), Vector(x.e2d, x.e2q)


# The linear, time-varying form ----------------------------------------------------------------------------------------


field_of_saturation = None
"""Every saturation is one that a PMU sees."""


def seen(xp, m: Machine, V, I, Q) -> Saturation:  # noqa: E741 - the paper's name
    """S and its slope from a frame, with the terminal moved behind Ra."""
    return quadratic(xp, m.S10, m.S12, magnitude_behind(xp, V, I, Q, m.xl) + m.Kis * I)


def reactance(xp, m: Machine, S):
    """x of the measured voltage F = V + (Ra + j x) I: X''q."""
    return m.xl + (m.xq2 - m.xl) / (1 + S * m.xq / m.xd)


def axis(x, x1, x2, T1, T2, Sat, X) -> Axis:
    b = (x - x1) / (x1 - x2)
    return Axis(
        M=((-Sat / T2, Sat / T2), (b * Sat / T1, -(1 + b) * Sat / T1)),
        k=((x1 - x2) / T2, 0.0),
        e=(0.0, 1 / T1),
        drop=(X, X + (x1 - x2) / Sat),
    )


def axes(xp, m: Machine, S) -> Axes:
    """In the coordinates (E'', E'), behind X''q."""
    S_d, S_q = 1 + S, 1 + S * m.xq / m.xd
    X = (m.xd2 - m.xl) / S_d - (m.xq2 - m.xl) / S_q
    return Axes(
        axis(m.xq, m.xq1, m.xq2, m.Tq10, m.Tq20, S_q, 0.0),
        axis(m.xd, m.xd1, m.xd2, m.Td10, m.Td20, S_d, X),
    )


def rules(xp, m: Machine) -> List[Rule]:
    """xl < x'' < x' <= x on both axes."""
    return [
        *reactance_rules(m),
        Rule(m.xd2 > m.xl, "xd2 = {xd2} is not allowed; it must be above xl = {xl} pu"),
        Rule(m.xq2 > m.xl, "xq2 = {xq2} is not allowed; it must be above xl = {xl} pu"),
        Rule(m.xd2 < m.xd1, "xd2 = {xd2} is not allowed with gentpj; it must be below xd1 = {xd1} pu"),
        Rule(m.xq2 < m.xq1, "xq2 = {xq2} is not allowed with gentpj; it must be below xq1 = {xq1} pu"),
        saturation_rule(m),
    ]
