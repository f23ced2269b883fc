"""What every machine model comes down to for an observer: two axes that meet in the stator only.

The windings of one axis are linear in what a PMU measures:

    z' = M z + k i + e E_f          z: voltages of this axis, pu, the stator's own first; E_f in the q axis only
    f = z[0] + X i                  f = (f_d, f_q): the voltage F = V + (Ra + j x) I as the rotor sees it

M, k and X depend on the saturation S alone, which a PMU measures. Per axis i is I_q in d and -I_d in q, since "in d"
means with q-axis data: E'd belongs to the winding of the q axis. With j F = e^{j delta} (f_d + j f_q) measured, so is
kappa = -j I/F, and

    i_d + j i_q = I_q - j I_d = kappa (f_d + j f_q)

makes all of it linear, time-varying and known: z' = A(t) z + e E_f, f = C(t) z, |f|^2 = |F|^2. That is the
reparameterisation of Bobtsov et al. (2020), Lemmas 1 and 2, where A(t) is that of the two-axis machine.
"""

from typing import NamedTuple, Tuple

from ..interface import Scalar
from ..linear import Complex

Column = Tuple[Scalar, ...]
Rows = Tuple[Column, ...]


class Axis(NamedTuple):
    M: Rows  # 1/s
    k: Column  # 1/s, by i
    e: Column  # 1/s, by E_f
    drop: Column  # pu: z = f - drop i while the damper windings are at rest; the first is X


class Axes(NamedTuple):
    d: Axis
    q: Axis


class Form(NamedTuple):
    """The linear time-varying form at a frame; n states, those of d first."""

    A: Rows  # n x n, 1/s
    e: Column  # n, 1/s
    C: Rows  # 2 x 2: f = C (z[0] of d, z[0] of q)
    rest: Rows  # n x 2: z = rest f while the damper windings are at rest
    by_d: Column  # n, 1/s: what an error of kappa does, times Re(dkappa f),
    by_q: Column  # n, 1/s: and times Im(dkappa f)
    by_S: Rows  # n x 2, 1/s: what an error of S does, times f
    CX: Rows  # 2 x 2: what an error of kappa does to f = C z, times (Re, Im)(dkappa f)


def form(axes: Axes, with_more: Axes, kappa: Complex) -> Form:
    """A(t), C(t) and so on at a frame; `with_more` are the axes at S + 1 (they are affine in S, but for X)."""
    (d, q), (re, im) = axes, kappa
    C = inverse_stator(d.drop[0], q.drop[0], kappa)
    (C_dd, C_dq), (C_qd, C_qq) = C
    # (i_d, i_q) = L (z[0] of d, z[0] of q)
    L_d = (re * C_dd - im * C_qd, re * C_dq - im * C_qq)
    L_q = (im * C_dd + re * C_qd, im * C_dq + re * C_qq)
    n, n_d = len(d.k) + len(q.k), len(d.k)
    A = []
    for axis, (by_zd, by_zq), at in ((d, L_d, 0), (q, L_q, n_d)):
        for row, k in zip(axis.M, axis.k):
            whole = [0.0] * n
            whole[at : at + len(row)] = row
            whole[0] = whole[0] + k * by_zd
            whole[n_d] = whole[n_d] + k * by_zq
            A.append(tuple(whole))
    # an error di of kappa f makes one of f, CX di, which kappa turns into one of i again: (1 + kappa CX) di in all
    CX = ((C_dd * d.drop[0], C_dq * q.drop[0]), (C_qd * d.drop[0], C_qq * q.drop[0]))
    (X_dd, X_dq), (X_qd, X_qq) = CX
    by_d = [k * (1 + re * X_dd - im * X_qd) for k in d.k] + [k * (im * X_dd + re * X_qd) for k in q.k]
    by_q = [k * (re * X_dq - im * X_qq) for k in d.k] + [k * (1 + im * X_dq + re * X_qq) for k in q.k]
    return Form(
        A=tuple(A),
        e=(0.0,) * n_d + q.e,
        C=C,
        rest=tuple((1 - c * re, c * im) for c in d.drop) + tuple((-c * im, 1 - c * re) for c in q.drop),
        by_d=tuple(by_d),
        by_q=tuple(by_q),
        by_S=tuple((of_f + of_i * re, -of_i * im) for of_f, of_i in by_saturation(d, with_more.d))
        + tuple((of_i * im, of_f + of_i * re) for of_f, of_i in by_saturation(q, with_more.q)),
        CX=CX,
    )


def inverse_stator(X_d, X_q, kappa: Complex) -> Rows:
    """C of f = C s, from f = s + (X_d i_d, X_q i_q) and i_d + j i_q = kappa (f_d + j f_q)."""
    re, im = kappa
    determinant = (1 - X_d * re) * (1 - X_q * re) + X_d * X_q * im * im
    return (
        ((1 - X_q * re) / determinant, -X_d * im / determinant),
        (X_q * im / determinant, (1 - X_d * re) / determinant),
    )


def by_saturation(axis: Axis, with_more: Axis):
    """(by f, by i) of each row of (dM/dS) z + (dk/dS) i, with z = f - drop i."""
    found = []
    for row, more, k, more_k in zip(axis.M, with_more.M, axis.k, with_more.k):
        change = [b - a for a, b in zip(row, more)]
        found.append((sum(change), more_k - k - sum(c * drop for c, drop in zip(change, axis.drop))))
    return found
