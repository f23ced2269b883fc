"""Any parameters in their ranges, any frames: nothing raises, and no output and no state is ever NaN or infinite."""

from math import inf, isfinite, nan

import numpy as np
import pytest

from fmu_src.pmu_observer import observer, tree
from fmu_src.pmu_observer.carriers import floats
from fmu_src.pmu_observer.estimators import ESTIMATORS
from fmu_src.pmu_observer.interface import Real, range_errors, variables
from fmu_src.pmu_observer.phasors import Frame

TRIALS, STEPS = 60, 15
WILD = [nan, inf, -inf, 0.0, 1.0, -1.0, 1e-3, 1.1e-3, 1e3, 1e8, -1e8, 1e9, 1e-300, 1e300]


def parameters(random) -> observer.Parameters:
    """One in eight reals at a bound or anywhere between, by orders of magnitude; every choice at random."""
    defaults = observer.Parameters()
    leaves = []
    for _, specification, start in variables(defaults):
        low, high = specification.min, specification.max
        assert low is not None and high is not None  # every parameter has a range
        if not isinstance(specification, Real):
            leaves.append(int(random.integers(low, high, endpoint=True)))
        elif random.random() < 1 / 8:
            between = 10 ** random.uniform(np.log10(max(low, 1e-9)), np.log10(high))
            leaves.append(random.choice([low, high, min(max(between, low), high)]))
        else:
            leaves.append(start)
    p = tree.like(defaults, [float(leaf) for leaf in leaves])
    m = p.machine
    p = p._replace(machine=m._replace(xd1=min(m.xd1, m.xd), xq1=min(m.xq1, m.xq)))
    assert range_errors(defaults, p) == []
    return p


def frame(random, V, I) -> Frame:  # noqa: E741 - the paper's name
    theta, lag = random.uniform(-10, 10), random.uniform(-3, 3)
    return Frame(V, theta, I, theta - lag, V * I * np.cos(lag), V * I * np.sin(lag))


def inputs(random, steady: Frame) -> observer.Inputs:
    kind = random.integers(4)
    shown = steady
    if kind == 0:
        shown = frame(random, random.uniform(0.5, 1.2), random.uniform(0, 8))
    elif kind == 1:  # at the limits of what is usable
        shown = frame(random, 10 ** random.uniform(-3, 1), 10 ** random.uniform(-3, 3))
    elif kind == 2:
        shown = Frame(*[random.choice(WILD) if random.random() < 0.4 else value for value in steady])
    P_m, E_f = (random.choice([0.5, 1.0, *WILD]) for _ in range(2))
    return observer.Inputs(Frame(*map(float, shown)), float(P_m), float(E_f), float(random.random() < 0.9))


@pytest.mark.parametrize("name", ESTIMATORS)
def test_finite(name):
    random = np.random.default_rng(0)
    for trial in range(TRIALS):
        p, h = parameters(random), 10 ** random.uniform(-6, 1)
        steady = frame(random, 1.0, random.uniform(0, 8))
        state = None
        for k in range(STEPS):
            i = inputs(random, steady)
            if state is None:
                state, _ = observer.start(name, floats, p, i, 0.0)
            state, outputs = observer.step(name, floats, p, state, i, k * h, h)
            for kind, values in (("state", state), ("output", outputs)):
                for leaf, value in zip(tree.names(values), tree.leaves(values)):
                    assert isfinite(value), (trial, k, kind, leaf, p, h)
