"""I&I speed observer with a0 and b0 (damping and inertia) unknown: DREM on the swing equation.

    p^2 x1 = -a0 p x1 + b0 (u1 - y5), filtered by F = lam^2/(p + lam)^2:  z = phi^T (a0, b0)
    z = p^2 F[x1],  phi = (-p F[x1], F[u1 - y5]);  second regression: z and phi behind mu/(p + mu)

F is driven by the rate of x1, constant over an interval, so that an offset of x1 leaves no transient. Works without
noise and with Pm known; biased by noise. It is a mode for calibrating H and D on a clean record, not for operation.
"""

from typing import Annotated, NamedTuple

from ..interface import Real, Scalar
from ..linear import relax
from ..machines.two_axis import Constants
from . import immersion_invariance
from . import rotor as swing
from .immersion_invariance import mean_power, turn_of
from .rotor import Rotor


class Parameters(NamedTuple):
    gamma: Annotated[
        Scalar, Real("1/s", "adaptation gain, per Delta^2", min=0.0, max=1e30, nominal=1e6, tunable=True)
    ] = 1e6
    lam: Annotated[Scalar, Real("1/s", "double pole lambda of the filter F", min=1e-3, max=1e4)] = 5.0
    mu: Annotated[Scalar, Real("1/s", "pole of the second regression", min=1e-3, max=1e4)] = 1.0


class Outputs(NamedTuple):
    a0: Annotated[Scalar, Real("1/s", "estimate of a0 = D omega_s/(2H)")] = 0.0
    b0: Annotated[Scalar, Real("rad/s2", "estimate of b0 = omega_s/(2H), per pu of power")] = 0.0


class Cascade(NamedTuple):
    """Two equal low-pass filters in a row, lam/(p + lam) each."""

    first: Scalar = 0.0
    second: Scalar = 0.0


class Regression(NamedTuple):
    """z = phi1 a0 + phi2 b0."""

    z: Scalar = 0.0
    phi1: Scalar = 0.0
    phi2: Scalar = 0.0


class Mixed(NamedTuple):
    """The two scalar regressions calY_k = Delta (a0, b0)_k."""

    Delta: Scalar = 0.0
    calY1: Scalar = 0.0
    calY2: Scalar = 0.0


class State(NamedTuple):
    rate: Cascade = Cascade()  # of x1', rad/s
    power: Cascade = Cascade()  # of u1 - y5, pu
    filtered: Regression = Regression()  # behind mu/(p + mu)
    mixed: Mixed = Mixed()
    a0: Scalar = 0.0
    b0: Scalar = 0.0


def start(xp, c: Constants, s, estimate, settings):
    """From the a0 and b0 of the machine's parameters."""
    return swing.balanced(xp, estimate.delta, s.measured, settings.P_m_known), State(a0=c.a0, b0=c.b0)


def step(xp, p: Parameters, c: Constants, rotor: Rotor, own: State, interval, estimate, settings):
    """I&I with the mean of the interval's a0 and b0; P_m is measured."""
    turn = turn_of(xp, rotor, interval, estimate)
    calibrated = calibrate(xp, p, own, interval, turn)
    a0, b0 = (own.a0 + calibrated.a0) / 2, (own.b0 + calibrated.b0) / 2
    moved = immersion_invariance.step_known(xp, rotor, a0, b0, settings.k, interval, turn)
    return moved._replace(delta=estimate.delta), calibrated


def calibrate(xp, p: Parameters, state: State, interval, turn) -> State:
    """a0 and b0 over an interval in which the rotor has turned by `turn`, rad."""
    h = interval.h
    P_m = (interval.before.measured.P_m + interval.after.measured.P_m) / 2
    w0 = regression(p.lam, state.rate, state.power)
    rate = low_pass_twice(xp, p.lam * h, state.rate, turn / h)
    power = low_pass_twice(xp, p.lam * h, state.power, P_m - mean_power(interval))
    w1 = regression(p.lam, rate, power)
    decay = xp.exp(-p.mu * h)
    filtered = Regression(*[v * decay + (a + b) / 2 * (1 - decay) for v, a, b in zip(state.filtered, w0, w1)])

    before = state.mixed
    after = Mixed(
        Delta=w1.phi1 * filtered.phi2 - w1.phi2 * filtered.phi1,
        calY1=w1.z * filtered.phi2 - w1.phi2 * filtered.z,
        calY2=w1.phi1 * filtered.z - w1.z * filtered.phi1,
    )
    gain = p.gamma * (before.Delta * before.Delta + after.Delta * after.Delta) / 2
    drive1 = p.gamma * (before.Delta * before.calY1 + after.Delta * after.calY1) / 2
    drive2 = p.gamma * (before.Delta * before.calY2 + after.Delta * after.calY2) / 2
    # damping and inertia are not negative; noise can drive their estimates there, and the observer out of stability
    a0 = xp.maximum(relax(xp, state.a0, gain, drive1, h), 0.0)
    b0 = xp.maximum(relax(xp, state.b0, gain, drive2, h), 0.0)
    return State(rate, power, filtered, after, a0, b0)


def regression(lam, rate: Cascade, power: Cascade) -> Regression:
    return Regression(z=lam * (rate.first - rate.second), phi1=-rate.second, phi2=power.second)


def low_pass_twice(xp, z, v: Cascade, w) -> Cascade:
    """The cascade over an interval of z = lam h, exactly for a constant input w."""
    decay = xp.exp(-z)
    first = v.first - w
    return Cascade(w + decay * first, w + decay * (v.second - w + z * first))


def constants(c: Constants, own: State) -> Constants:
    return c._replace(a0=own.a0, b0=own.b0)


def outputs(xp, own: State) -> Outputs:
    return Outputs(own.a0, own.b0)
