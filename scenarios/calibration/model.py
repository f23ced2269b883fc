"""Both orders of the machine as one linear, time-varying system, for many candidates of its data at once.

With F = V + (Ra + j xr) I, kappa = -j I/F, j F = e^{j delta} s, s = s_d + j s_q, and p = E'd + j E'q, all known but s,
p and delta ("in d" means with the data of the q-axis winding: E'd belongs to it):

    two_axis, xr = x'd:   z = p          p' = [j E_f - p + (x - x') kappa s]/T'        p = s - (x' - xr) kappa s
    genrou,   xr = x'':   z = (s, p)     p' = [j E_f - (1 + alpha) p + (alpha - sigma) s + alpha (x'' - xl) kappa s]/T'
                                         s' = g p' + [p - s + (x' - x'') kappa s]/T''
    alpha = (x - x')/(x' - xl), g = (x'' - xl)/(x' - xl), sigma = S(|F|), in d times (xq - xl)/(xd - xl)

The products of real parameters with d + jq are taken component by component. Arrays have the axes (candidate, frame).
"""

from typing import NamedTuple

import numpy as np

from fmu_src.pmu_observer.interface import Scalar

ORDERS = ("two_axis", "genrou")

TIGHT = 0.99
"""x'' stays below TIGHT times x'd and x'q, and these below xd and xq: a machine cannot have more."""


class Machine(NamedTuple):
    """Data of a machine, pu on one common base; what only genrou has is 0 for a two-axis machine."""

    H: Scalar  # s
    D: Scalar  # pu torque per rad/s
    xd: Scalar
    xd1: Scalar
    xq: Scalar
    xq1: Scalar
    Td10: Scalar  # s
    Tq10: Scalar  # s
    Ra: Scalar
    omega_s: Scalar  # rad/s
    xd2: Scalar = 0.0  # x''d = x''q
    xl: Scalar = 0.0
    Td20: Scalar = 0.0  # s
    Tq20: Scalar = 0.0  # s
    S10: Scalar = 0.0  # saturation at 1.0 and 1.2 pu of |E''|
    S12: Scalar = 0.0


class Linear(NamedTuple):
    """The system for C candidates and T frames; n = 2 or 4 states z."""

    A: np.ndarray  # (C, T, n, n) 1/s
    forcing: np.ndarray  # (C, n) 1/s: z' by E_f
    saliency: np.ndarray  # (C, 2): x'q - xr, x'd - xr of p = s - (x' - xr) kappa s
    kappa: np.ndarray  # (C, T)
    by_kappa: np.ndarray  # (C, n) 1/s: z' by the component of kappa s
    by_S: np.ndarray  # (C, n) 1/s: z' by the component of s, for the saturation S
    S_slope: np.ndarray  # (C, T) dS/d ln|F|
    voltage_share: np.ndarray  # (C, T) V/F
    log_F: np.ndarray  # (C, T)
    angle_F: np.ndarray  # (C, T) of j F, rad
    P: np.ndarray  # (C, T) air-gap power
    start: np.ndarray  # (C, 2) p of the quasi-steady state of the first frame


def linear(order: str, m: Machine, V, I) -> Linear:  # noqa: E741 - the paper's name
    """The system that the phasors `V`, `I` (C or 1, T) and the candidates' data (C,) make."""
    m = Machine(*[np.atleast_1d(np.asarray(value, float)) for value in m])
    subtransient = order == "genrou"
    xd1, xq1 = np.minimum(m.xd1, TIGHT * m.xd), np.minimum(m.xq1, TIGHT * m.xq)
    xr = np.minimum(m.xd2, TIGHT * np.minimum(xd1, xq1)) if subtransient else xd1
    F = V + (m.Ra + 1j * xr)[:, None] * I
    kappa = -1j * I / F
    psi = np.abs(F)
    S, S_slope = saturation(m, psi) if subtransient else (np.zeros_like(psi), np.zeros_like(psi))

    x, x1, T1 = (np.stack(pair, -1) for pair in ((m.xq, m.xd), (xq1, xd1), (m.Tq10, m.Td10)))  # (C, 2): d, q
    mu = x1 - xr[:, None]
    in_d = (m.xq - m.xl) / (m.xd - m.xl) if subtransient else np.ones_like(m.xd)
    sigma = np.stack([in_d[:, None] * S, S], -1)  # (C, T, 2)
    K = turning(kappa)
    zero = np.zeros_like(x)
    if subtransient:
        leak = x1 - m.xl[:, None]
        alpha, g = (x - x1) / leak, (xr - m.xl)[:, None] / leak
        T2 = np.stack([m.Tq20, m.Td20], -1)
        by_kappa_p = alpha * (xr - m.xl)[:, None] / T1
        by_kappa_s = g * by_kappa_p + mu / T2
        p_by_s = by_kappa_p[:, None, :, None] * K + diagonal((alpha[:, None] - sigma) / T1[:, None])
        p_by_p = -(1 + alpha) / T1
        A = np.zeros((*np.broadcast_shapes(kappa.shape, (len(xd1), 1)), 4, 4))
        A[..., :2, :2] = g[:, None, :, None] * p_by_s + (mu / T2)[:, None, :, None] * K - diagonal(1 / T2[:, None])
        A[..., :2, 2:] = diagonal((g * p_by_p + 1 / T2)[:, None])
        A[..., 2:, :2] = p_by_s
        A[..., 2:, 2:] = diagonal(p_by_p[:, None])
        forcing = np.stack([zero[:, 0], g[:, 1] / T1[:, 1], zero[:, 0], 1 / T1[:, 1]], -1)
        by_S = -np.stack([in_d, np.ones_like(in_d)], -1) / T1
        by_kappa, by_S = np.concatenate([by_kappa_s, by_kappa_p], -1), np.concatenate([g * by_S, by_S], -1)
    else:
        by_kappa = (x - x1) / T1
        A = by_kappa[:, None, :, None] * (K @ to_s(mu, kappa)) - diagonal(1 / T1[:, None])
        forcing, by_S = np.stack([zero[:, 0], 1 / T1[:, 1]], -1), zero

    W = 1j * F
    P = (V * np.conj(I)).real + m.Ra[:, None] * np.abs(I) ** 2
    shape = np.broadcast_shapes(A.shape[:2], P.shape)
    full = [np.ascontiguousarray(np.broadcast_to(v, shape)) for v in (kappa, S_slope, V / F, np.log(psi))]
    return Linear(
        np.ascontiguousarray(np.broadcast_to(A, (*shape, *A.shape[2:]))),
        forcing,
        mu,
        full[0],
        by_kappa,
        by_S,
        full[1],
        full[2],
        full[3],
        np.ascontiguousarray(np.broadcast_to(np.unwrap(np.angle(W)), shape)),
        np.ascontiguousarray(np.broadcast_to(P, shape)),
        quasi_steady(m.xq, xr, mu, sigma[:, 0, 0], kappa[:, 0], psi[:, 0]),
    )


def saturation(m: Machine, psi):
    """S = B (psi - A)^2/psi above A, and dS/d ln psi;  a = sqrt(1.2 S12/S10), A = 1 - 0.2/(a - 1),

    B = S10/(1 - A)^2.
    """
    saturates = (m.S10 > 0) & (1.2 * m.S12 > m.S10)
    a = np.sqrt(1.2 * np.where(saturates, m.S12, 2.0) / np.where(saturates, m.S10, 1.0))
    A = (1 - 0.2 / (a - 1))[:, None]
    B = np.where(saturates, m.S10, 0.0)[:, None] / (1 - A) ** 2
    above = np.maximum(psi - A, 0.0)
    return B * above**2 / psi, B * above * (psi + A) / psi


def turning(kappa):
    """The matrix (..., 2, 2) that multiplies (s_d, s_q) by kappa."""
    return np.stack([np.stack([kappa.real, -kappa.imag], -1), np.stack([kappa.imag, kappa.real], -1)], -2)


def diagonal(values):
    """(..., 2) on the diagonal of (..., 2, 2)."""
    return values[..., None] * np.eye(2)


def to_s(mu, kappa):
    """(C, T, 2, 2): s of p, the inverse of 1 - mu K(kappa)."""
    return np.linalg.inv(np.eye(2) - mu[:, None, :, None] * turning(kappa))


def quasi_steady(xq, xr, mu, sigma_d, kappa, psi):
    """p (C, 2) at rest: (1 + sigma) s_d = (xq - xr) Re(kappa s), |s| = |F|, p = s - mu kappa s."""
    s = -(xq - xr) * kappa.imag + 1j * (1 + sigma_d - (xq - xr) * kappa.real)
    s = s / np.abs(s) * psi
    turned = kappa * s
    return np.stack([s.real - mu[:, 0] * turned.real, s.imag - mu[:, 1] * turned.imag], -1)
