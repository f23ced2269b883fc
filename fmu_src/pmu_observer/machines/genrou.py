"""GENROU, the round-rotor machine of PSS/E, PowerWorld, ANDES and OpenIPSL: a field, a damper in d, two in q.

    T'd0 E'q' = E_f - E'q - (xd - x'd)[Id + (x'd - x'')/(x'd - xl)^2 (E'q - psi_kd - (x'd - xl) Id)] - S E''q
    T'q0 E'd' =     - E'd + (xq - x'q)[Iq - (x'q - x'')/(x'q - xl)^2 (E'd - psi_kq + (x'q - xl) Iq)]
                          - S E''d (xq - xl)/(xd - xl)
    T''d0 psi_kd' = E'q - psi_kd - (x'd - xl) Id          T''q0 psi_kq' = E'd - psi_kq + (x'q - xl) Iq
    E''q = gd E'q + (1 - gd) psi_kd    E''d = gq E'd + (1 - gq) psi_kq    g = (x'' - xl)/(x' - xl)

S = S(|E''|), quadratic; x''d = x''q = x'' =: xd2, so that E'' = V + (Ra + j x'') I is measured.
PowerWorld, "Machine Model GENROU"; ANDES, class GENROU; both agree term by term.
"""

from typing import List, NamedTuple

from ..interface import Rule, Scalar
from ..linear import Vector
from .axes import Axes, Axis
from .data import Machine, reactance_rules
from .saturation import Saturation, quadratic, saturation_rule
from .stator import Field, Stator, behind, magnitude, magnitude_behind

STATES = ("e2d", "e1d", "e2q", "e1q")
"""Of the linear form, those of the d axis first."""

D_STATES = 2
SALIENT = False


class Windings(NamedTuple):
    """States of the nonlinear form, pu."""

    e1d: Scalar
    e1q: Scalar
    psi_kd: Scalar
    psi_kq: Scalar


# The nonlinear form ---------------------------------------------------------------------------------------------------


def subtransient(m: Machine, x: Windings) -> Vector:
    """(E''d, E''q)."""
    gd, gq = (m.xd2 - m.xl) / (m.xd1 - m.xl), (m.xd2 - m.xl) / (m.xq1 - m.xl)
    return Vector(gq * x.e1d + (1 - gq) * x.psi_kq, gd * x.e1q + (1 - gd) * x.psi_kd)


def stator(xp, m: Machine, x: Windings, S) -> Stator:
    return Stator(subtransient(m, x), m.xd2, m.xd2)


def saturation(xp, m: Machine, v: Vector, i: Vector):
    """S, from the voltage behind Ra and the current, both in the rotor's frame."""
    return quadratic(xp, m.S10, m.S12, magnitude(xp, behind(v, i, m.xd2))).S


def rates(xp, m: Machine, x: Windings, i: Vector, S, E_f) -> Windings:
    e2 = subtransient(m, x)
    leak_d, leak_q = m.xd1 - m.xl, m.xq1 - m.xl
    psi_kd = x.e1q - x.psi_kd - leak_d * i.d
    psi_kq = x.e1d - x.psi_kq + leak_q * i.q
    field = i.d + (m.xd1 - m.xd2) / (leak_d * leak_d) * psi_kd
    rotor = i.q - (m.xq1 - m.xd2) / (leak_q * leak_q) * psi_kq
    return Windings(
        e1d=(-x.e1d + (m.xq - m.xq1) * rotor - S * e2.d * (m.xq - m.xl) / (m.xd - m.xl)) / m.Tq10,
        e1q=(E_f - x.e1q - (m.xd - m.xd1) * field - S * e2.q) / m.Td10,
        psi_kd=psi_kd / m.Td20,
        psi_kq=psi_kq / m.Tq20,
    )


def at_rest(xp, m: Machine, S) -> Field:
    S_q = S * (m.xq - m.xl) / (m.xd - m.xl)
    return Field(1 + S, m.xd2 + (m.xd - m.xd2) / (1 + S), m.xd2 + (m.xq - m.xd2) / (1 + S_q))


def windings_at_rest(xp, m: Machine, v: Vector, i: Vector, S) -> Windings:
    e2 = behind(v, i, m.xd2)
    e1d, e1q = e2.d - (m.xq1 - m.xd2) * i.q, e2.q + (m.xd1 - m.xd2) * i.d
    return Windings(e1d, e1q, e1q - (m.xd1 - m.xl) * i.d, e1d + (m.xq1 - m.xl) * i.q)


def voltages(xp, m: Machine, x: Windings, i: Vector, S):
    """(E'd, E'q) and (E''d, E''q), as the observer gives them."""
    return Vector(x.e1d, x.e1q), subtransient(m, x)


# The linear, time-varying form ----------------------------------------------------------------------------------------


field_of_saturation = None
"""Every saturation is one that a PMU sees."""


def seen(xp, m: Machine, V, I, Q) -> Saturation:  # noqa: E741 - the paper's name
    """S and its slope from a frame, with the terminal moved behind Ra."""
    return quadratic(xp, m.S10, m.S12, magnitude_behind(xp, V, I, Q, m.xd2))


def reactance(xp, m: Machine, S):
    """x of the measured voltage F = V + (Ra + j x) I."""
    return m.xd2


def axis(x, x1, x2, xl, T1, T2, saturating) -> Axis:
    """The two windings of an axis in the coordinates (E'', E') = (s, p), with i and S times `saturating`:

    p' = [E_f - (1 + alpha) p + (alpha - S) s + alpha (x'' - xl) i]/T',   alpha = (x - x')/(x' - xl)
    s' = g p' + [p - s + (x' - x'') i]/T'',                             g = (x'' - xl)/(x' - xl)
    """
    alpha, g = (x - x1) / (x1 - xl), (x2 - xl) / (x1 - xl)
    ps, pp, pi = (alpha - saturating) / T1, -(1 + alpha) / T1, alpha * (x2 - xl) / T1
    return Axis(
        M=((g * ps - 1 / T2, g * pp + 1 / T2), (ps, pp)),
        k=(g * pi + (x1 - x2) / T2, pi),
        e=(g / T1, 1 / T1),
        drop=(0.0, x1 - x2),
    )


def axes(xp, m: Machine, S) -> Axes:
    return Axes(
        axis(m.xq, m.xq1, m.xd2, m.xl, m.Tq10, m.Tq20, S * (m.xq - m.xl) / (m.xd - m.xl)),
        axis(m.xd, m.xd1, m.xd2, m.xl, m.Td10, m.Td20, S),
    )


def rules(xp, m: Machine) -> List[Rule]:
    """xl < x'' <= x' <= x on both axes."""
    return [
        *reactance_rules(m),
        Rule(m.xd2 > m.xl, "xd2 = {xd2} is not allowed; it must be above xl = {xl} pu"),
        Rule(m.xd2 <= m.xd1, "xd2 = {xd2} is not allowed; it must be at most xd1 = {xd1} pu"),
        Rule(m.xd2 <= m.xq1, "xd2 = {xd2} is not allowed; it must be at most xq1 = {xq1} pu"),
        saturation_rule(m),
    ]
