"""GPEBO + DREM: the paper's observer (Proposition 2).

    Psi = H[psi^T], Y_E = H[y_E],  H = (1, d2/(s + d2), ..., d5/(s + d5));     Delta = det Psi
    calY_k = det Psi with column k replaced by Y_E (the preprint says row)
    theta_k' = -gamma Delta (Delta theta_k - calY_k),  k = 1, 2

Delta is small (1e-7 in the paper's own example), so that gamma has to be huge, and noise above 1e-5 of a phasor is
enough to spoil the estimate: this is the method of the paper, not one for measured data.
"""

from typing import Annotated, NamedTuple

from .. import gpebo
from ..angle import rotor_angle
from ..gpebo import Gpebo
from ..interface import Real, Scalar
from ..linear import Vector, decay_mean, relax


def pole(name):
    return Real("1/s", f"pole {name} of the regressor extension", min=1e-3, max=1e4)


class Parameters(NamedTuple):
    gamma: Annotated[
        Scalar, Real("1/s", "adaptation gain, per Delta^2", min=0.0, max=1e30, nominal=1e15, tunable=True)
    ] = 1e15
    d2: Annotated[Scalar, pole("d2")] = 2.0
    d3: Annotated[Scalar, pole("d3")] = 4.0
    d4: Annotated[Scalar, pole("d4")] = 6.0
    d5: Annotated[Scalar, pole("d5")] = 8.0


class Outputs(NamedTuple):
    theta1: Annotated[Scalar, Real("pu", "estimate of the constant theta_1")] = 0.0
    theta2: Annotated[Scalar, Real("pu", "estimate of the constant theta_2")] = 0.0
    Delta: Annotated[Scalar, Real("1", "determinant of the extended regressor", nominal=1e-7)] = 0.0
    int_Delta2: Annotated[Scalar, Real("s", "integral of Delta^2: the excitation so far", nominal=1e-15)] = 0.0


class Row(NamedTuple):
    """A row of [Psi, Y_E]: the regression behind one filter."""

    psi1: Scalar = 0.0
    psi2: Scalar = 0.0
    psi3: Scalar = 0.0
    psi4: Scalar = 0.0
    psi5: Scalar = 0.0
    y_E: Scalar = 0.0


class Filtered(NamedTuple):
    """Rows 2 to 5 of [Psi, Y_E], zero at the start."""

    row2: Row = Row()
    row3: Row = Row()
    row4: Row = Row()
    row5: Row = Row()


class Mixed(NamedTuple):
    """The two scalar regressions calY_k = Delta theta_k."""

    Delta: Scalar = 0.0
    calY1: Scalar = 0.0
    calY2: Scalar = 0.0


class State(NamedTuple):
    gpebo: Gpebo = Gpebo()
    filtered: Filtered = Filtered()
    mixed: Mixed = Mixed()
    theta: Vector = Vector(0.0, 0.0)
    int_Delta2: Scalar = 0.0


def start(xp, p, c, s):
    return State()  # the filters start from zero, so that Delta = 0 at the first frame


def step(xp, p, c, state, interval):
    h = interval.h
    w0 = row(gpebo.regression(state.gpebo, interval.before.Y1))
    advanced = gpebo.advance(state.gpebo, interval.flow)
    w1 = row(gpebo.regression(advanced, interval.after.Y1))
    rows = [low_pass(xp, d * h, v, w0, w1) for d, v in zip(p[1:], state.filtered)]
    mixed = mix([w1, *rows])

    # theta' = -rate theta + drive, exactly for the mean rate and drive of the interval: no gamma is ever stiff
    before = state.mixed
    mean_Delta2 = (before.Delta * before.Delta + mixed.Delta * mixed.Delta) / 2
    rate = p.gamma * mean_Delta2

    def adapt(theta, calY0, calY1):
        drive = p.gamma * (before.Delta * calY0 + mixed.Delta * calY1) / 2
        return relax(xp, theta, rate, drive, h)

    theta = Vector(
        adapt(state.theta.d, before.calY1, mixed.calY1),
        adapt(state.theta.q, before.calY2, mixed.calY2),
    )
    return State(advanced, Filtered(*rows), mixed, theta, state.int_Delta2 + h * mean_Delta2)


def row(regression):
    return Row(*regression.psi, y_E=regression.y_E)


def low_pass(xp, dh, v, w0, w1):
    """v' = d (w - v) over one interval, exactly for w linear in time from w0 to w1 (first-order hold)."""
    decay, mean = xp.exp(-dh), decay_mean(xp, dh)
    from_w0, from_w1 = mean - decay, 1 - mean
    return Row(*[decay * a + from_w0 * b + from_w1 * c for a, b, c in zip(v, w0, w1)])


def mix(rows) -> Mixed:
    """Delta, calY1 and calY2 from the five rows of [Psi, Y_E].

    The three determinants share columns 3 to 5: Laplace expansion along the first two columns, with the 3x3 minors of
    the others. A minor's sign is that of the row pair it belongs to.
    """
    c1, c2, c3, c4, c5, y = zip(*rows)
    Delta = calY1 = calY2 = 0.0
    for i, j, k, m, n in ROW_PAIRS:
        minor = (
            c3[k] * (c4[m] * c5[n] - c4[n] * c5[m])
            - c3[m] * (c4[k] * c5[n] - c4[n] * c5[k])
            + c3[n] * (c4[k] * c5[m] - c4[m] * c5[k])
        )
        if (i + j) % 2 == 0:
            minor = -minor
        Delta = Delta + (c1[i] * c2[j] - c1[j] * c2[i]) * minor
        calY1 = calY1 + (y[i] * c2[j] - y[j] * c2[i]) * minor
        calY2 = calY2 + (c1[i] * y[j] - c1[j] * y[i]) * minor
    return Mixed(Delta, calY1, calY2)


ROW_PAIRS = [
    (i, j, *[row for row in range(5) if row not in (i, j)])  # a pair of rows, and the three others
    for i in range(5)
    for j in range(i + 1, 5)
]


def estimate(xp, state, s, near):
    return rotor_angle(xp, s, gpebo.estimate(state.gpebo, state.theta), near)


def outputs(xp, state):
    return Outputs(state.theta.d, state.theta.q, state.mixed.Delta, state.int_Delta2)
