"""The innovations of a Kalman filter of (delta, omega, dP_m, z) for many candidates.

    delta' = omega     omega' = -a0 omega + b0 (P_m + dP_m - P)     dP_m: constant, or a walk     z' = A z + b E_f
    seen: ln|F| = ln|s|,  arg(j F) = delta + arg s

A, P and what is seen come from the same two phasors, so that one noise, E|n|^2 = (tve |.|)^2 on V and on I, is in all
of them: a frame's noise acts through A and P on the interval before it and on the one after it, and on what is seen.
With e = estimate - truth, e- = e + B n and the innovation nu = D n - H e, D = M - H B:

    S = H P H' + D R D',   K = (P H' - B R D') S^-1,   P+ = P + B R B' - K S K',   E[e+ n'] = (B + K D) R,   R = tve^2/2

An interval in which the network jumps is two, with the phasors of its ends constant up to the instant of the jump.
"""

import numpy as np
from numba import njit

from .model import Linear

STATES = ("delta", "omega", "dP_m")
"""Before z."""

START_ANGLE, START_SPEED, START_Z = 1.0, 10.0, 1e-3
"""rad, rad/s, pu: standard deviations at the first frame; where z starts is fitted."""


def innovations(s: Linear, h, share, E_f, E_f_share, P_m, good, b0, a0, tve, P_m_spread, P_m_walk, start):
    """Normalised innovations (C, T, 2), uncorrelated, of unit variance if right; and states (C, T, 3 + n).

    h (T,) s, of the interval that ends at a frame; share (C, T) of it before a jump, negative where there is none;
    E_f (C, T); E_f_share (C, T) likewise; P_m (T,); good (T,) False: the frame only carries A and P over a gap;
    start (C, 2) is added to p of the quasi-steady first frame. Where a frame is not good, its innovations are 0.
    """
    args = [np.ascontiguousarray(v, dtype=float) for v in (h, share, E_f, E_f_share, P_m)]
    rates = [np.ascontiguousarray(v, dtype=float) for v in (b0, a0)]
    return _filter(
        s.A,
        s.forcing,
        s.saliency,
        s.kappa,
        s.by_kappa,
        s.by_S,
        s.S_slope,
        s.voltage_share,
        s.log_F,
        s.angle_F,
        s.P,
        np.ascontiguousarray(s.start + start),
        args[0],
        args[1],
        args[2],
        args[3],
        args[4],
        np.ascontiguousarray(good),
        rates[0],
        rates[1],
        tve * tve / 2,
        P_m_spread * P_m_spread,
        P_m_walk * P_m_walk,
    )


@njit(cache=True)
def _exponential(A, h, out, term, work):
    """out = exp(A h): Taylor's series to order 7 of A h/2^k, |A h|/2^k < 1/2, squared k times."""
    n = A.shape[0]
    norm = 0.0
    for i in range(n):
        row = 0.0
        for j in range(n):
            row += abs(A[i, j])
        norm = max(norm, row * abs(h))
    k = 0
    while norm > 0.5 and k < 30:
        norm /= 2
        k += 1
    scale = h / 2.0**k
    for i in range(n):
        for j in range(n):
            term[i, j] = out[i, j] = 1.0 if i == j else 0.0
    for order in range(1, 8):
        for i in range(n):
            for j in range(n):
                total = 0.0
                for m in range(n):
                    total += term[i, m] * A[m, j]
                work[i, j] = total * scale / order
        for i in range(n):
            for j in range(n):
                term[i, j] = work[i, j]
                out[i, j] += work[i, j]
    for _ in range(k):
        _product(out, out, work)
        for i in range(n):
            for j in range(n):
                out[i, j] = work[i, j]


@njit(cache=True)
def _product(A, B, out):
    for i in range(A.shape[0]):
        for j in range(B.shape[1]):
            total = 0.0
            for m in range(A.shape[1]):
                total += A[i, m] * B[m, j]
            out[i, j] = total


@njit(cache=True)
def _noise_rates(n, s_d, s_q, kappa, share, mu_d, by_kappa, by_S, S_slope, reduced, G, M):
    """z' (rows 3 on of G) and ln(j F/s) (M) by the real and imaginary parts of v and i, dV = V v and dI = I i.

    dkappa = kappa (V/F)(i - v), d ln F = (V/F) v + (1 - V/F) i; of a two-axis machine s = s(p, kappa) moves too.
    """
    s = s_d + 1j * s_q
    for j in range(4):
        unit = 1.0 + 0j if j % 2 == 0 else 1j
        dkappa = kappa * share * (-unit if j < 2 else unit)
        dF = share * unit if j < 2 else (1 - share) * unit
        ds = 0.0
        turned = dkappa * s
        if reduced:
            ds = mu_d * turned.real / (1 - mu_d * kappa.real)
            turned = turned + kappa * ds
        for r in range(n):
            part = turned.real if r % 2 == 0 else turned.imag
            own = s_d if r % 2 == 0 else s_q
            G[3 + r, j] = by_kappa[r] * part + by_S[r] * own * S_slope * dF.real
        seen = dF - ds / s
        M[0, j], M[1, j] = seen.real, seen.imag


@njit(cache=True)
def _filter(
    A,
    forcing,
    saliency,
    kappa,
    by_kappa,
    by_S,
    S_slope,
    voltage_share,
    log_F,
    angle_F,
    power,
    start,
    h,
    share,
    E_f,
    E_f_share,
    P_m,
    good,
    b0,
    a0,
    R,
    P_m_variance,
    P_m_walk,
):
    candidates, frames, n = A.shape[0], A.shape[1], A.shape[2]
    N = 3 + n
    reduced = n == 2
    r = np.zeros((candidates, frames, 2))
    states = np.zeros((candidates, frames, N))
    x, moved = np.zeros(N), np.zeros(N)
    P, Q, T, FP = np.zeros((N, N)), np.zeros((N, N)), np.zeros((N, N)), np.zeros((N, N))
    G, B, BKD = np.zeros((N, 4)), np.zeros((N, 4)), np.zeros((N, 4))
    M, D = np.zeros((2, 4)), np.zeros((2, 4))
    H, HP, K = np.zeros((2, N)), np.zeros((2, N)), np.zeros((N, 2))
    F, half, one, two = np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, n))
    term, work, mean = np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, n))
    g = np.zeros(n)
    for c in range(candidates):
        mu_d, mu_q = saliency[c, 0], saliency[c, 1]
        # s of the first frame, from p
        kr, ki = kappa[c, 0].real, kappa[c, 0].imag
        p_d, p_q = start[c, 0], start[c, 1]
        det = (1 - mu_d * kr) * (1 - mu_q * kr) + mu_d * mu_q * ki * ki
        s_d = ((1 - mu_q * kr) * p_d - mu_d * ki * p_q) / det
        s_q = (mu_q * ki * p_d + (1 - mu_d * kr) * p_q) / det
        P[:] = 0.0
        P[0, 0], P[1, 1], P[2, 2] = START_ANGLE**2, START_SPEED**2, P_m_variance
        for i in range(n):
            P[3 + i, 3 + i] = START_Z**2
        x[0], x[1], x[2] = angle_F[c, 0] - np.arctan2(s_q, s_d), 0.0, 0.0
        if reduced:
            x[3], x[4] = p_d, p_q
        else:
            x[3], x[4], x[5], x[6] = s_d, s_q, p_d, p_q
        for k in range(frames):
            before = 0.5
            if k > 0:
                span = h[k]
                jumped = share[c, k] > -1.0
                before = share[c, k] if jumped else 0.5
                Ef0, Ef1 = E_f[c, k - 1], E_f[c, k]
                if E_f_share[c, k] > -1.0:
                    Ef0 = E_f_share[c, k] * Ef0 + (1 - E_f_share[c, k]) * Ef1
                    Ef1 = Ef0
                # what the noise of the frame before does in this interval
                for i in range(N):
                    for j in range(4):
                        B[i, j] = before * span * G[i, j]
                for i in range(N):
                    for j in range(N):
                        total = 0.0
                        for m in range(4):
                            total += BKD[i, m] * B[j, m] + B[i, m] * BKD[j, m] + B[i, m] * B[j, m]
                        P[i, j] += R * total
                if jumped:
                    _exponential(A[c, k - 1], before * span, one, term, work)
                    _exponential(A[c, k], (1 - before) * span, two, term, work)
                    _product(two, one, F)
                    # the forcing by the trapezoidal rule over both parts
                    for i in range(n):
                        total = 0.0
                        for m in range(n):
                            total += (before * (F[i, m] + two[i, m]) * Ef0 + (1 - before) * two[i, m] * Ef1) * forcing[
                                c, m
                            ]
                        g[i] = span / 2 * (total + (1 - before) * forcing[c, i] * Ef1)
                else:
                    for i in range(n):
                        for j in range(n):
                            mean[i, j] = (A[c, k - 1, i, j] + A[c, k, i, j]) / 2
                    _exponential(mean, span / 2, half, term, work)
                    _product(half, half, F)
                    for i in range(n):
                        total = 0.0
                        for m in range(n):
                            total += (F[i, m] * Ef0 + 2 * half[i, m] * (Ef0 + Ef1)) * forcing[c, m]
                        g[i] = span / 6 * (total + forcing[c, i] * Ef1)
                # the whole transition
                decay = np.exp(-a0[c] * span)
                slower = 1 - a0[c] * span / 2
                T[:] = 0.0
                T[0, 0], T[0, 1], T[0, 2] = 1.0, span * slower, b0[c] * span * span / 2
                T[1, 1], T[1, 2], T[2, 2] = decay, b0[c] * span * slower, 1.0
                for i in range(n):
                    for j in range(n):
                        T[3 + i, 3 + j] = F[i, j]
                push0, push1 = P_m[k - 1] - power[c, k - 1], P_m[k] - power[c, k]
                if jumped:
                    f_angle = push0 * before * (1 - before / 2) + push1 * (1 - before) ** 2 / 2
                    f_speed = before * push0 + (1 - before) * push1
                else:
                    f_angle, f_speed = push0 / 3 + push1 / 6, (push0 + push1) / 2
                for i in range(N):
                    total = 0.0
                    for j in range(N):
                        total += T[i, j] * x[j]
                    moved[i] = total
                moved[0] += b0[c] * span * span * f_angle
                moved[1] += b0[c] * span * slower * f_speed
                for i in range(n):
                    moved[3 + i] += g[i]
                for i in range(N):
                    x[i] = moved[i]
                _product(T, P, FP)
                for i in range(N):
                    for j in range(i, N):
                        total = 0.0
                        for m in range(N):
                            total += FP[i, m] * T[j, m]
                        P[i, j] = P[j, i] = total
                P[2, 2] += P_m_walk * span

            # s, and what the noise of this frame does
            kr, ki = kappa[c, k].real, kappa[c, k].imag
            if reduced:
                c_dd = 1 / (1 - mu_d * kr)
                c_dq = -mu_d * ki * c_dd
                s_d, s_q = c_dd * x[3] + c_dq * x[4], x[4]
            else:
                c_dd, c_dq = 1.0, 0.0
                s_d, s_q = x[3], x[4]
            _noise_rates(
                n,
                s_d,
                s_q,
                kappa[c, k],
                voltage_share[c, k],
                mu_d,
                by_kappa[c],
                by_S[c],
                S_slope[c, k],
                reduced,
                G,
                M,
            )
            # P + jQ = V I*, relative to the air-gap power: d(V I*) = V I* (v + i*)
            a = voltage_share[c, k]
            # V I* = |F|^2 (V/F) (j kappa)*
            S_VI = np.exp(2 * log_F[c, k]) * a * (-1j * kappa[c, k].conjugate())
            loss = power[c, k] - S_VI.real
            G[1, 0], G[1, 1] = -b0[c] * S_VI.real, b0[c] * S_VI.imag
            G[1, 2], G[1, 3] = -b0[c] * (S_VI.real + 2 * loss), -b0[c] * S_VI.imag
            if k > 0:
                for i in range(N):
                    for j in range(4):
                        B[i, j] = (1 - before) * h[k] * G[i, j]
            else:
                B[:] = 0.0
            for i in range(N):
                for j in range(N):
                    total = 0.0
                    for m in range(4):
                        total += B[i, m] * B[j, m]
                    Q[i, j] = R * total
            if not good[k]:
                for i in range(N):
                    for j in range(N):
                        P[i, j] += Q[i, j]
                    for j in range(4):
                        BKD[i, j] = B[i, j]
                    states[c, k, i] = x[i]
                continue

            size2 = s_d * s_d + s_q * s_q
            H[:] = 0.0
            H[0, 3] = s_d / size2 * c_dd
            H[0, 4] = (s_d * c_dq + s_q) / size2
            H[1, 0] = 1.0
            H[1, 3] = -s_q / size2 * c_dd
            H[1, 4] = (-s_q * c_dq + s_d) / size2
            _product(H, P, HP)
            for i in range(2):
                for j in range(4):
                    total = M[i, j]
                    for m in range(N):
                        total -= H[i, m] * B[m, j]
                    D[i, j] = total
            s00 = s01 = s11 = 0.0
            for m in range(N):
                s00 += HP[0, m] * H[0, m]
                s01 += HP[0, m] * H[1, m]
                s11 += HP[1, m] * H[1, m]
            for m in range(4):
                s00 += R * D[0, m] * D[0, m]
                s01 += R * D[0, m] * D[1, m]
                s11 += R * D[1, m] * D[1, m]
            det = s00 * s11 - s01 * s01
            nu0 = log_F[c, k] - np.log(size2) / 2
            nu1 = angle_F[c, k] - x[0] - np.arctan2(s_q, s_d)
            nu1 -= 2 * np.pi * np.floor(nu1 / (2 * np.pi) + 0.5)
            for i in range(N):
                u0, u1 = HP[0, i], HP[1, i]
                for m in range(4):
                    u0 -= R * B[i, m] * D[0, m]
                    u1 -= R * B[i, m] * D[1, m]
                K[i, 0] = (u0 * s11 - u1 * s01) / det
                K[i, 1] = (u1 * s00 - u0 * s01) / det
            for i in range(N):
                x[i] += K[i, 0] * nu0 + K[i, 1] * nu1
                for j in range(N):
                    KSK = (K[i, 0] * s00 + K[i, 1] * s01) * K[j, 0] + (K[i, 0] * s01 + K[i, 1] * s11) * K[j, 1]
                    P[i, j] += Q[i, j] - KSK
                for j in range(4):
                    BKD[i, j] = B[i, j] + K[i, 0] * D[0, j] + K[i, 1] * D[1, j]
                states[c, k, i] = x[i]
            first = np.sqrt(s00)
            r[c, k, 0] = nu0 / first
            r[c, k, 1] = (nu1 - s01 / s00 * nu0) / np.sqrt(max(s11 - s01 * s01 / s00, 1e-300))
    return r, states
