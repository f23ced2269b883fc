"""The paper's overparameterised gradient: all five of Theta, as if they were independent.

    Theta' = -Gamma psi (psi^T Theta - y_E),    Theta = (th1, th2, th1 th2, th1^2, th2^2)

    e = (Th1 Th2 - Th3, Th4 - Th1^2, Th5 - Th2^2)

e would be zero if Theta had converged to its true value; in the paper's example it does not, whatever Gamma. (The
preprint prints e2 = Th1 - Th4^2 and e3 = Th2 - Th5^2, which are not zero at the true Theta.)
"""

from typing import Annotated, NamedTuple

from .. import gpebo
from ..angle import rotor_angle
from ..gpebo import Gpebo
from ..interface import Real, Scalar
from ..linear import Vector, decay_mean


class Parameters(NamedTuple):
    Gamma: Annotated[Scalar, Real("1/s", "adaptation gain, per pu^4", min=0.0, max=1e30, nominal=1e6, tunable=True)] = (
        1e6
    )


class Outputs(NamedTuple):
    Theta1: Annotated[Scalar, Real("pu", "estimate of th1")] = 0.0
    Theta2: Annotated[Scalar, Real("pu", "estimate of th2")] = 0.0
    Theta3: Annotated[Scalar, Real("1", "estimate of th1 th2, pu^2")] = 0.0
    Theta4: Annotated[Scalar, Real("1", "estimate of th1^2, pu^2")] = 0.0
    Theta5: Annotated[Scalar, Real("1", "estimate of th2^2, pu^2")] = 0.0
    e1: Annotated[Scalar, Real("1", "consistency error Th1 Th2 - Th3, pu^2")] = 0.0
    e2: Annotated[Scalar, Real("1", "consistency error Th4 - Th1^2, pu^2")] = 0.0
    e3: Annotated[Scalar, Real("1", "consistency error Th5 - Th2^2, pu^2")] = 0.0


class Overparameters(NamedTuple):
    th1: Scalar = 0.0
    th2: Scalar = 0.0
    th3: Scalar = 0.0
    th4: Scalar = 0.0
    th5: Scalar = 0.0


class State(NamedTuple):
    gpebo: Gpebo = Gpebo()
    Theta: Overparameters = Overparameters()


def start(xp, p, c, s):
    return State()


def step(xp, p, c, state, interval):
    gain = p.Gamma * interval.h / 2
    Theta = adapt(xp, state.Theta, gpebo.regression(state.gpebo, interval.before.Y1), gain)
    advanced = gpebo.advance(state.gpebo, interval.flow)
    Theta = adapt(xp, Theta, gpebo.regression(advanced, interval.after.Y1), gain)
    return State(advanced, Theta)


def adapt(xp, Theta, regression, gain):
    """Theta' = -psi (psi^T Theta - y_E) over `gain` for a frozen regression: the error along psi decays exactly."""
    psi, y_E = regression
    square = sum(a * a for a in psi)
    error = sum(a * b for a, b in zip(psi, Theta)) - y_E
    move = gain * decay_mean(xp, gain * square) * error
    return Overparameters(*[b - a * move for a, b in zip(psi, Theta)])


def estimate(xp, state, s, near):
    x = gpebo.estimate(state.gpebo, Vector(state.Theta.th1, state.Theta.th2))
    return rotor_angle(xp, s, x, near)


def outputs(xp, state):
    th1, th2, th3, th4, th5 = state.Theta
    return Outputs(th1, th2, th3, th4, th5, th1 * th2 - th3, th4 - th1 * th1, th5 - th2 * th2)
