"""GENSAL, the salient-pole machine of PSS/E: GENSAE with the saturation on E'q alone, quadratic, in the field.

    T'd0 E'q' = E_f - S(E'q) E'q - E'q
                - (xd - x'd)[Id + (x'd - x'')/(x'd - xl)^2 (E'q - psi_kd - (x'd - xl) Id)]
    T''d0 psi_kd' = E'q - psi_kd - (x'd - xl) Id
    T''q0 E''d' = - E''d + (xq - x'') Iq

No PMU measures E'q, but its saturation only takes from the field voltage: with E_f - S(E'q) E'q in the place of E_f all
is linear. PowerWorld, "Machine Model GENSAL".
"""

from typing import List

from ..interface import Rule
from ..linear import Vector
from . import gensae
from .axes import Axes
from .data import Machine
from .gensae import D_STATES, SALIENT, STATES, Windings, reactance, stator, voltages, windings_at_rest
from .saturation import Saturation, quadratic
from .stator import Field

__all__ = ["D_STATES", "SALIENT", "STATES", "Windings", "reactance", "stator", "voltages", "windings_at_rest"]


# The nonlinear form ---------------------------------------------------------------------------------------------------


def saturation(xp, m: Machine, v: Vector, i: Vector):
    """S(E'q) at rest, where E'q = V_q + Ra I_q + x'd Id."""
    return quadratic(xp, m.S10, m.S12, v.q + m.xd1 * i.d).S


def rates(xp, m: Machine, x: Windings, i: Vector, S, E_f) -> Windings:
    leak = m.xd1 - m.xl
    psi_kd = x.e1q - x.psi_kd - leak * i.d
    field = i.d + (m.xd1 - m.xd2) / (leak * leak) * psi_kd
    return Windings(
        e1q=(E_f - field_of_saturation(xp, m.S10, m.S12, x.e1q) - x.e1q - (m.xd - m.xd1) * field) / m.Td10,
        psi_kd=psi_kd / m.Td20,
        e2d=(-x.e2d + (m.xq - m.xd2) * i.q) / m.Tq20,
    )


def field_of_saturation(xp, S10, S12, e1q):
    """S(E'q) E'q, pu: what the iron takes of the field voltage."""
    return quadratic(xp, S10, S12, e1q).S * e1q


def at_rest(xp, m: Machine, S) -> Field:
    return Field(1 + S, m.xd1 + (m.xd - m.xd1) / (1 + S), m.xq)


# The linear, time-varying form ----------------------------------------------------------------------------------------


def seen(xp, m: Machine, V, I, Q) -> Saturation:  # noqa: E741 - the paper's name
    """A PMU sees no saturation."""
    return Saturation(0.0, 0.0)


def axes(xp, m: Machine, S) -> Axes:
    return gensae.axes(xp, m, 0.0)


def rules(xp, m: Machine) -> List[Rule]:
    return gensae.rules(xp, m)
