"""Every estimator against its continuous equations, solved by scipy's solve_ivp for the same machine.

Halving h divides the error by 4: the sampled step is of second order. At its stiff gains the overparameterised
estimator is of first order: Theta' = -Gamma psi (psi^T Theta - y_E) keeps psi^T Theta = y_E all the time, the sampled
one only at frames.
"""

from typing import Callable, NamedTuple

import numpy as np
import pytest

from . import reference
from .reference import MOVING_CASE, PAPER_CASE, Case
from .sampled import inputs_along, parameters_of, run

FINEST, DURATION = 4e-3, 1.6
STRIDES = (4, 2, 1)


class Trial(NamedTuple):
    """An estimator of the package, its continuous equations, and the quantities to compare at every frame."""

    name: str
    gains: dict
    case: Case
    observer: reference.Observer
    expected: Callable  # of the reference's state
    found: Callable  # of the observer's State
    method: str = "DOP853"


def x_of(state):
    return list(state.estimate.x)


def pair_of_theta(z, theta):
    return reference.reals(reference.gpebo_pair(z[:6], theta))


def drem(case, gamma):
    def expected(z):
        theta = z[reference.DREM_THETA]
        return [*theta, *pair_of_theta(z, theta), 1e15 * z[reference.DREM_INT_DELTA2]]

    def found(state):
        own = state.estimator
        return [*own.theta, *state.estimate.x, 1e15 * own.int_Delta2]

    return Trial("drem", {"gamma": gamma}, case, reference.drem(case.machine, gamma), expected, found)


def overparameterised(case, Gamma, method="DOP853"):
    return Trial(
        "overparameterised",
        {"Gamma": Gamma},
        case,
        reference.overparameterised(case.machine, Gamma),
        lambda z: [*z[6:], *pair_of_theta(z, z[6:8])],
        lambda state: [*state.estimator.Theta, *state.estimate.x],
        method,
    )


def gradient(case, Gamma):
    return Trial("gradient", {"Gamma": Gamma}, case, reference.gradient(case.machine, Gamma), list, x_of)


def joint_gradient(case, Gamma, k):
    observer = reference.joint_gradient(case, Gamma, k)
    return Trial("joint_gradient", {"Gamma": Gamma, "k": k}, case, observer, list, lambda state: joint(state.estimator))


def joint(own):
    return [own.x1, own.x2, *own.x]


def open_loop(case):
    return Trial("open_loop", {}, case, reference.open_loop(case.machine), list, x_of)


def errors(trial: Trial) -> list[float]:
    """The largest error over time and quantities, for h = 16, 8 and 4 ms."""
    times = np.arange(0, DURATION + FINEST / 2, FINEST)
    solution = reference.solve(trial.case, times, trial.observer, trial.method)
    inputs = inputs_along(trial.case, solution)
    expected = np.array([trial.expected(z) for z in solution.observer.T])
    p = parameters_of(trial.case.machine, trial.name, **trial.gains)
    found = []
    for stride in STRIDES:
        states = run(trial.name, p, inputs[::stride], stride * FINEST).states
        values = np.array([trial.found(state) for state in states])
        found.append(np.abs(values - expected[::stride]).max())
    return found


SECOND_ORDER = {
    "drem, paper, gamma 1e12": lambda: drem(PAPER_CASE, 1e12),
    "drem, paper, gamma 1e15": lambda: drem(PAPER_CASE, 1e15),
    "drem, moving": lambda: drem(MOVING_CASE, 1e15),
    "overparameterised, paper": lambda: overparameterised(PAPER_CASE, 1e-4),
    "overparameterised, moving": lambda: overparameterised(MOVING_CASE, 10.0),
    "gradient, paper": lambda: gradient(PAPER_CASE, 10.0),
    "gradient, moving": lambda: gradient(MOVING_CASE, 10.0),
    "joint_gradient, paper": lambda: joint_gradient(PAPER_CASE, 10.0, 2.0),
    "joint_gradient, moving": lambda: joint_gradient(MOVING_CASE, 10.0, 5.0),
    "open_loop, paper": lambda: open_loop(PAPER_CASE),
    "open_loop, moving": lambda: open_loop(MOVING_CASE),
}


@pytest.mark.parametrize("trial", SECOND_ORDER.values(), ids=SECOND_ORDER)
def test_second_order_in_h(trial):
    coarse, middle, fine = errors(trial())
    # the ratio tends to 4; at 16 ms terms of higher order still count
    assert coarse / middle == pytest.approx(4, rel=0.15)
    assert middle / fine == pytest.approx(4, rel=0.08)


@pytest.mark.parametrize("case", [PAPER_CASE, MOVING_CASE], ids=["paper", "moving"])
def test_overparameterised_at_the_papers_gain(case):
    coarse, middle, fine = errors(overparameterised(case, 1e6, method="LSODA"))  # stiff
    assert 1.8 < coarse / middle < 4.5 and 1.8 < middle / fine < 4.5


@pytest.mark.parametrize(("name", "gain"), [("drem", "gamma"), ("overparameterised", "Gamma"), ("gradient", "Gamma")])
def test_no_gain_is_stiff(name, gain):
    """At a gain a million times too high for an explicit step, and 5 frames/s, the estimate stays below 10 pu."""
    times = np.arange(0, 10, 0.2)
    inputs = inputs_along(PAPER_CASE, reference.solve(PAPER_CASE, times))
    p = parameters_of(PAPER_CASE.machine, name, **{gain: 1e24 if name == "drem" else 1e10})
    assert all(np.hypot(*state.estimate.x) < 10 for state in run(name, p, inputs, 0.2).states)
