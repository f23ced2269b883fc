"""From a PMU frame to the signals the observers work with (Lemma 2 of the paper, corrected).

As phasors, the frame gives the internal voltage E' = V + j x' I exactly: j E' = Y2 + j Y3 = e^{j x1} (x3 + j x4).
What no single frame gives is how the angle of j E' divides between x1 and the angle of (x3, x4) (Lemma 1).
"""

from typing import Annotated, Any, NamedTuple

from .interface import Real, Scalar
from .linear import Complex, Matrix
from .machines.axes import form
from .machines.two_axis import Constants

LOWEST_VOLTAGE = 1e-3
"""pu; a frame below it carries no usable angle."""

LOWEST_Y1 = 1e-4
"""pu^2; a machine in operation has an internal voltage of more than 0.01 pu."""

HIGHEST_Y1 = 1e2
"""pu^2; and of less than 10 pu."""

NO_CURRENT = 0.02
"""Of V/x'; a current below it may be noise, and contradicts nothing."""

CONTRADICTION = 0.5
"""Of the larger of two values for the same thing; a gross error of one phasor by 50 % makes no frame useless."""


class Frame(NamedTuple):
    """A PMU frame at the generator terminal; both angles in one reference frame, P + jQ generated."""

    V_t: Annotated[Scalar, Real("pu", "terminal voltage magnitude")] = 0.0
    theta_t: Annotated[Scalar, Real("rad", "angle of the terminal voltage phasor")] = 0.0
    I_t: Annotated[Scalar, Real("pu", "terminal current magnitude")] = 0.0
    phi_t: Annotated[Scalar, Real("rad", "angle of the terminal current phasor, generator convention")] = 0.0
    P_t: Annotated[Scalar, Real("pu", "generated active power")] = 0.0
    Q_t: Annotated[Scalar, Real("pu", "generated reactive power")] = 0.0


class Measurement(NamedTuple):
    """What the equations use of a frame and of the machine's inputs, and how far it is to be trusted."""

    theta: Scalar  # y1, rad
    V: Scalar  # y2, pu
    I: Scalar  # y4, pu  # noqa: E741 - the paper's name
    P: Scalar  # y5, pu
    Q: Scalar  # y6, pu
    P_m: Scalar  # u1, pu
    E_f: Scalar  # u2, pu
    tve: Scalar = 0.01  # assumed noise: E|n|^2 = (tve |.|)^2 on each of the phasors V and I
    E_f_known: Scalar = 1.0  # 0 where E_f is only an estimate


class Signals(NamedTuple):
    """Lemma 2: the measured signals at the time of a frame, next to the measurement they come from."""

    measured: Measurement
    Y1: Scalar  # |F|^2, pu^2; F = V + j x I is E' for the paper's estimators
    Y2: Scalar  # Re j F, pu
    Y3: Scalar  # Im j F, pu
    nu: Complex  # x conj(I/(j F)): what A depends on
    x: Scalar  # pu, the reactance that F is behind
    A: Any  # Matrix, 1/s: d/dt (x3, x4) = A (x3, x4) + (0, c1 E_f); () under a machine model
    form: Any  # machines.axes.Form; () for the paper's estimators
    slope: Scalar  # dS/dY1, 1/pu^2, of the saturation


def measurement(xp, frame: Frame, P_m, E_f, from_phasors) -> Measurement:
    """P and Q from their own inputs, or from the phasors."""
    P, Q = power(xp, frame)
    return Measurement(
        theta=frame.theta_t,
        V=frame.V_t,
        I=frame.I_t,
        P=xp.where(from_phasors, P, frame.P_t),
        Q=xp.where(from_phasors, Q, frame.Q_t),
        P_m=P_m,
        E_f=E_f,
    )


def power(xp, frame: Frame):
    """P + jQ = V conj(I) = V I e^{j (theta - phi)}."""
    S, lag = frame.V_t * frame.I_t, frame.theta_t - frame.phi_t
    return S * xp.cos(lag), S * xp.sin(lag)


def power_mismatch(xp, c: Constants, frame: Frame, m: Measurement):
    """|P + jQ - V conj(I)|/|V I|: what P and Q, and the phasors, say of each other; 0 where they are one and the same.

    An idle machine's current is noise: |V I| below 2 % of V^2/x' counts as that.
    """
    P, Q = power(xp, frame)
    least = NO_CURRENT / c.x * frame.V_t * frame.V_t
    re, im = m.P - P, m.Q - Q
    return xp.sqrt(re * re + im * im) / xp.maximum(frame.V_t * frame.I_t, least)


ABSURD = 1e9
"""In any of the project's units."""


def is_finite(xp, values, limit=ABSURD):
    """False if one of the scalars is a NaN, infinite or absurd: `|x| < limit` is false for NaN on every carrier."""
    finite = xp.abs(values[0]) < limit
    for value in values[1:]:
        finite = xp.logical_and(finite, xp.abs(value) < limit)
    return finite


def signals(xp, c: Constants, m: Measurement) -> Signals:
    """Y1, Y2, Y3 of Lemma 2 and what the machine's linear form is made of.

    Y1 = (x y4)^2 + 2 x y6 + y2^2, Y2 + j Y3 = j F with F = e^{j y1} (y2 + x y6/y2 + j x y5/y2), nu = x conj(I/(j F)).
    """
    S, slope = c.model.seen(xp, c.machine, m.V, m.I, m.Q) if c.model else (0.0, 0.0)
    x = c.model.reactance(xp, c.machine, S) if c.model else c.x
    Y1 = (x * m.I) * (x * m.I) + 2 * x * m.Q + m.V * m.V
    Y1 = xp.maximum(Y1, LOWEST_Y1)  # a wild frame: see is_consistent
    cos, sin = xp.cos(m.theta), xp.sin(m.theta)
    along, across = m.V + x * m.Q / m.V, x * m.P / m.V
    z0 = m.Q + m.V * m.V / x
    nu = Complex(x * z0 / Y1 - 1, x * m.P / Y1)
    return Signals(
        m,
        Y1,
        Y2=-(along * sin + across * cos),
        Y3=along * cos - across * sin,
        nu=nu,
        x=x,
        A=() if c.model else paper_A(c, nu),
        form=machine_form(xp, c, S, x, nu) if c.model else (),
        slope=slope / (2 * xp.sqrt(Y1)),
    )


def machine_form(xp, c: Constants, S, x, nu: Complex):
    """Of the machine model, with S measured, and kappa = conj(nu)/x."""
    kappa = Complex(nu.re / x, -nu.im / x)
    return form(c.model.axes(xp, c.machine, S), c.model.axes(xp, c.machine, S + 1), kappa)


def paper_A(c: Constants, nu: Complex) -> Matrix:
    """A of Lemma 2, with z0 = y6 + y2^2/x':

        A = [ -a2 + b2 x' z0/Y1     b2 x' y5/Y1      ]
            [ -b1 x' y5/Y1         -a1 + b1 x' z0/Y1 ]

    The preprint prints y2 cos(x1 - y1) = (x'/Y1)(z0 x3 - y5 x3); its matrix A is right.
    """
    same, cross = nu.re + 1, nu.im
    return Matrix(-c.a2 + c.b2 * same, c.b2 * cross, -c.b1 * cross, -c.a1 + c.b1 * same)


def is_consistent(xp, c: Constants, s: Signals):
    """False where a frame contradicts itself: |I| is not that of P and Q, or |E'|^2 of V, |I|, Q not that of V, P, Q.

    Where the difference is a CONTRADICTION; currents below NO_CURRENT do not count. False too where no machine has such
    an internal voltage.
    """
    m, from_power = s.measured, s.Y2 * s.Y2 + s.Y3 * s.Y3
    xI, xI_from_power = c.x * m.I, c.x * xp.sqrt(m.P * m.P + m.Q * m.Q) / m.V
    plausible = xp.logical_and(s.Y1 > LOWEST_Y1, s.Y1 < HIGHEST_Y1)
    same_current = xp.abs(xI - xI_from_power) < CONTRADICTION * xp.maximum(xI, xI_from_power) + NO_CURRENT * m.V
    same_voltage = xp.abs(from_power - s.Y1) < CONTRADICTION * xp.maximum(from_power, s.Y1)
    return xp.logical_and(plausible, xp.logical_and(same_current, same_voltage))
