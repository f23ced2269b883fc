"""What the interval between two frames does to an estimate under a machine model, and what their noise does to it.

    z' = A(t) z + e E_f,  f = C(t) z,  |f|^2 = Y1        (see machines.axes)

A(t) is measured: the noise of kappa and of the saturation S, and what both do between the frames when the network
jumps, are process noise. Nothing else is, and there is nothing to tune.
"""

from typing import Any, NamedTuple

from . import noise
from .interface import Scalar
from .linear import Complex
from .matrix import Column, Rows, Symmetric, apply, columns, exponential_halves, outer, plus, scaled
from .phasors import Signals

UNSEEN_NU = 0.002
"""1/s/sqrt(s): how fast x'd kappa may change in a gap between frames, besides what the frames at its ends show: load
changes of some percent."""


class Transition(NamedTuple):
    """Over an interval: z+ = F z + G E_f + g. Matrices of two columns are by (f_d, f_q)."""

    F: Rows
    G: Column
    g: Column  # what E_f, if it is measured, adds by having changed
    E_f: Scalar  # pu, measured, at the end
    E_f_known: Scalar
    Q: Symmetric  # variances that do not depend on z, pu^2
    jump: Rows  # A is wrong by half a jump over the whole interval,
    when: Rows  # and by where in the interval the jump is
    common: Rows  # pu^2: covariance of the errors of z and of Y1,
    by_kappa: Rows  # and the part of it that comes from kappa
    per_R: Scalar  # 1/pu^4, one over the variance of Y1
    C: Rows  # at the end; () where f = (z[0] of d, z[0] of q)
    C_before: Rows  # at the start, likewise
    output: Any  # OutputNoise, or () as C
    iron: Column  # (S10, S12) where a saturation takes of the field that no PMU sees, else ()


class OutputNoise(NamedTuple):
    """What the noise of kappa does to C z itself."""

    CX: Rows
    variance: Scalar  # E|dkappa f|^2/2, on each axis, pu^2
    common: Complex  # E[dkappa dY1], pu
    u_d: Column
    u_q: Column


def transition(xp, c, before: Signals, after: Signals, h, jump, gap) -> Transition:
    """Of an interval of length h, `gap` s of which are unseen.

    An error of kappa at a frame acts over half the interval before it and half of that after it: on z by u, the
    integral of exp(A t) w, per pu of i; w are the columns by_d and by_q of the form. E|dkappa|^2 = v then adds
    v Y1/2 (u_d u_d' + u_q u_q'). An error of S is one of Y1, so that what it adds follows from what they have in
    common (see `gaussian`).
    """
    s, form = after, after.form
    half, F = exponential_halves(scaled(0.5, plus(before.form.A, form.A)), h)
    e = form.e
    first, middle, last = [[h / 6 * x for x in v] for v in (apply(F, e), apply(half, e), e)]  # Simpson's rule
    G = tuple([x + 4 * y + z for x, y, z in zip(first, middle, last)])
    # E_f is linear in between, where it is measured: what it is at the end, less what it was
    known = s.measured.E_f_known > 0
    change = xp.where(known, before.measured.E_f - s.measured.E_f, 0.0)
    g = tuple([change * (x + 2 * y) for x, y in zip(first, middle)])

    def integrated(w: Column) -> Column:
        return tuple([h / 6 * (x + 4 * y + z) for x, y, z in zip(w, apply(half, w), apply(F, w))])

    u_d, u_q = integrated(form.by_d), integrated(form.by_q)
    u_S = columns(*[integrated(w) for w in zip(*form.by_S)])
    to_kappa = 1 / s.x  # nu = x conj(kappa)
    variance = noise.of_nu(s) * to_kappa * to_kappa
    unseen = UNSEEN_NU / c.machine.xd1
    spread = (variance / 2 + unseen * unseen * gap * gap * gap / (3 * xp.maximum(h * h, 1e-12))) * s.Y1
    forcing = h / 2 * jump.E_f
    Q = [spread * (d + q) + forcing * forcing * f for d, q, f in zip(outer(u_d), outer(u_q), outer(e))]

    both = noise.of_nu_and_Y1(s)
    both = Complex(both.re * to_kappa, -both.im * to_kappa)
    _, R = noise.of_Y1(s)
    by_kappa = by_f(u_d, u_q, both)
    jump_kappa = Complex(jump.nu.re * to_kappa, -jump.nu.im * to_kappa)
    when_d, when_q = [tuple([h / 4 * (x - y) for x, y in zip(w, apply(F, w))]) for w in (form.by_d, form.by_q)]
    salient = c.model.SALIENT
    return Transition(
        F=F,
        G=G,
        g=g,
        E_f=s.measured.E_f,
        E_f_known=s.measured.E_f_known,
        Q=tuple(Q),
        jump=scaled(0.5, by_f(u_d, u_q, jump_kappa)),
        when=by_f(when_d, when_q, jump_kappa),
        common=plus(by_kappa, scaled(s.slope * R, u_S)),
        by_kappa=by_kappa,
        per_R=1 / R,
        C=form.C if salient else (),
        C_before=before.form.C if salient else (),
        output=OutputNoise(form.CX, variance * s.Y1 / 2, both, u_d, u_q) if salient else (),
        iron=(c.machine.S10, c.machine.S12) if c.model.field_of_saturation else (),
    )


def by_f(u_d: Column, u_q: Column, c: Complex) -> Rows:
    """The matrix of u_d Re(c f) + u_q Im(c f), f = f_d + j f_q."""
    return tuple([(d * c.re + q * c.im, q * c.re - d * c.im) for d, q in zip(u_d, u_q)])
