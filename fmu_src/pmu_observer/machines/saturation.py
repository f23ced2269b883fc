"""Magnetic saturation: how much more field current than on the air-gap line a flux needs, S(psi), per unit of psi.

S(1.0) and S(1.2) are read off the open-circuit curve of the data sheet; both 0: the iron does not saturate.
"""

from typing import NamedTuple

from ..interface import Rule, Scalar
from .data import Machine

LEAST_FLUX = 0.05
"""pu; no iron saturates below it, and S is divided by psi."""


class Saturation(NamedTuple):
    S: Scalar  # 1
    slope: Scalar  # dS/dpsi, 1/pu


def quadratic(xp, S10, S12, psi) -> Saturation:
    """S = B (psi - A)^2/psi above psi = A, else 0, through S(1.0) = S10 and S(1.2) = S12 (PSS/E, PowerWorld, ANDES).

    With a = sqrt(S10) and b = sqrt(1.2 S12): sqrt(B) (psi - A) = a + (psi - 1)(b - a)/0.2, which needs no A.
    """
    a, b = xp.sqrt(S10), xp.sqrt(1.2 * S12)
    root_B = (b - a) * 5
    psi = xp.maximum(psi, LEAST_FLUX)
    above = xp.maximum(a + (psi - 1) * root_B, 0.0)
    S = above * above / psi
    return Saturation(S, (2 * above * root_B - S) / psi)


LOG_1_2 = 0.1823215567939546
"""log 1.2"""


def exponential(xp, S10, S12, psi) -> Saturation:
    """S = S10 psi^X with X = log(S12/S10)/log 1.2 (GENSAE of PSS/E); none for S10 below 1e-6."""
    psi = xp.maximum(psi, LEAST_FLUX)
    saturates = S10 > 1e-6
    X = xp.where(saturates, xp.log(xp.maximum(S12, 1e-6) / xp.where(saturates, S10, 1.0)) / LOG_1_2, 0.0)
    # e^50 for a wild frame
    S = xp.where(saturates, S10 * xp.exp(xp.minimum(X * xp.log(psi), 50.0)), 0.0)
    return Saturation(S, X * S / psi)


def saturation_rule(m: Machine) -> Rule:
    return Rule(m.S12 >= m.S10, "S12 = {S12} is not allowed; it must be at least S10 = {S10}: iron saturates")
