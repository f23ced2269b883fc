"""One step from a shared state agrees on floats, arrays and symbols; that it can be traced shows it free of branches.

A Python branch on a symbol raises; `math.sin` and `float` of a symbol do not, but leave the constant NaN in the graph.
"""

from functools import lru_cache
from math import inf, isfinite, nan, sin

import casadi
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fmu_src.models import pmu_channel, pmu_observer, smib_plant
from fmu_src.pmu_observer import tree
from fmu_src.pmu_observer.carriers import arrays, floats, symbols
from fmu_src.pmu_observer.interface import Enumeration, variables

from . import reference
from .reference import MOVING_CASE
from .sampled import inputs_along, machine_of

MODELS = {model.MODEL.name: model.MODEL for model in (pmu_observer, pmu_channel, smib_plant)}
PROGRAMS = [(model, name) for model, declared in MODELS.items() for name in declared.programs]
H = 1 / 60
FRAMES = inputs_along(MOVING_CASE, reference.solve(MOVING_CASE, np.arange(0, 1, H)))
WILD = st.one_of(st.sampled_from([nan, inf, -inf, 0.0, -1.0, 1e-3, 1e8, -1e8, 1e300, 1e-300]), st.floats())


@lru_cache
def shape(model, name):
    """A state of the program, for its shape."""
    declared = MODELS[model]
    return declared.programs[name].start(floats, declared.parameters, declared.inputs, 0.0)[0]


@lru_cache
def traced(model, name):
    """The step as a CasADi function of the leaves of parameters, state and inputs, and of t and h."""
    declared = MODELS[model]
    trees = (declared.parameters, shape(model, name), declared.inputs)
    vectors = [casadi.SX.sym(f"v{k}", len(tree.leaves(branch))) for k, branch in enumerate(trees)]
    t, h = casadi.SX.sym("t"), casadi.SX.sym("h")
    arguments = [tree.like(branch, casadi.vertsplit(vector)) for branch, vector in zip(trees, vectors)]
    state, outputs = declared.programs[name].step(symbols, *arguments, t, h)
    result = casadi.vertcat(*tree.leaves(state), *tree.leaves(outputs))
    return casadi.Function("step", [*vectors, t, h], [result])


def constants_of(f: casadi.Function):
    instructions = range(f.n_instructions())
    return [f.instruction_constant(k) for k in instructions if f.instruction_id(k) == casadi.OP_CONST]


@pytest.mark.parametrize(("model", "name"), PROGRAMS)
def test_a_step_is_free_of_branches(model, name):
    assert all(isfinite(constant) for constant in constants_of(traced(model, name)))


@pytest.mark.parametrize("taken", [lambda x: sin(x), lambda x: float(x) + x])
def test_what_is_taken_from_elsewhere_leaves_a_nan(taken):
    """So that the test above can fail."""
    x = casadi.SX.sym("x")
    assert not all(isfinite(constant) for constant in constants_of(casadi.Function("f", [x], [taken(x)])))


def test_a_branch_on_a_symbol_raises():
    with pytest.raises(Exception, match=r"truth|scalar"):
        _ = 1 if casadi.SX.sym("x") > 0 else 2


def comparable(model, name, state, outputs):
    """Name, value and nominal of every leaf. A frame's angles as phasors: they jump at +-pi, and are any for I = 0."""
    listed = [(f"state.{leaf}", value, 1.0) for leaf, value in zip(tree.names(shape(model, name)), tree.leaves(state))]
    for variable, value in zip(variables(MODELS[model].outputs), tree.leaves(outputs)):
        listed.append((variable.name, value, getattr(variable.specification, "nominal", 1.0)))
    frame = getattr(outputs, "frame", None)
    if frame is None:
        return listed
    listed = [leaf for leaf in listed if leaf[0] not in ("theta_t", "phi_t", "load_angle")]
    angles = {"V": (frame.V_t, frame.theta_t), "I": (frame.I_t, frame.phi_t)}
    for phasor, (magnitude, angle) in angles.items():
        listed += [(f"Re {phasor}", magnitude * np.cos(angle), 1.0), (f"Im {phasor}", magnitude * np.sin(angle), 1.0)]
    return listed


def assert_agreement(model, name, samples):
    """`samples`: two of (parameters, state, inputs, t, h), with the same t and h; the arrays take both at once."""
    step = MODELS[model].programs[name].step
    (*first, t, h), (*second, _, _) = samples
    both = [tree.map(lambda *leaves: np.array(leaves, dtype=float), *branches) for branches in zip(first, second)]
    with np.errstate(all="ignore"):
        state, outputs = step(arrays, *both, t, h)
    for k, arguments in enumerate((first, second)):
        expected = step(floats, *arguments, t, h)
        leaves = np.array(traced(model, name)(*map(tree.leaves, arguments), t, h)).ravel()
        on_symbols = tree.like(expected, leaves.tolist())
        on_arrays = tree.map(lambda leaf, k=k: float(np.broadcast_to(leaf, 2)[k]), (state, outputs))
        for found in (on_arrays, on_symbols):
            pairs = zip(comparable(model, name, *expected), comparable(model, name, *found))
            for (leaf, right, nominal), (_, value, _) in pairs:
                # of the nominal, or of a value that is larger than that
                assert abs(value - right) <= 1e-12 * max(nominal, abs(right)), f"{leaf} = {value!r}, floats {right!r}"


def parameters(draw, model, **fixed):
    """The defaults but for what is fixed, and with every enumeration drawn."""
    defaults = MODELS[model].parameters._replace(**fixed)
    leaves = [
        draw(st.integers(1, v.specification.max)) if isinstance(v.specification, Enumeration) else v.start
        for v in variables(defaults)
    ]
    return tree.like(defaults, leaves)


# PmuObserver ---------------------------------------------------------------------------------------------------------

MACHINES = [
    machine_of(MOVING_CASE.machine)._replace(xd2=0.04, xq2=0.04),  # below x', as all models but two_axis need it
    machine_of(MOVING_CASE.machine)._replace(xd2=0.04, xq2=0.04, Ra=0.005, xq1=0.08),
]


@lru_cache
def observer_states(name, p):
    """The states along a record."""
    program = MODELS["PmuObserver"].programs[name]
    states = [program.start(floats, p, FRAMES[0], 0.0)[0]]
    for k, inputs in enumerate(FRAMES[:30]):
        states.append(program.step(floats, p, states[-1], inputs, k * H, H)[0])
    return states


@st.composite
def observer_samples(draw, name):
    """The next frame, or another one, with up to three wild values in it."""
    t, h = 0.5, draw(st.sampled_from([1e-3, H, 0.5]))

    def sample():
        p = parameters(draw, "PmuObserver", machine=draw(st.sampled_from(MACHINES)))
        at = draw(st.integers(0, 30))
        inputs = FRAMES[at + draw(st.sampled_from([0, 0, 0, 7]))]
        for place in draw(st.lists(st.integers(0, 7), max_size=3)):
            leaves = tree.leaves(inputs)
            leaves[place] = draw(WILD)
            inputs = tree.like(inputs, leaves)
        return p, observer_states(name, p)[at], inputs, t, h

    return sample(), sample()


@pytest.mark.parametrize("name", MODELS["PmuObserver"].programs)
@given(data=st.data())
def test_observer(name, data):
    assert_agreement("PmuObserver", name, data.draw(observer_samples(name)))


# SmibPlant -----------------------------------------------------------------------------------------------------------


@st.composite
def plant_samples(draw):
    """Before a fault, into it, in it, out of it, across it, and after it."""
    t, h = draw(st.sampled_from([0.0, 0.0999, 0.15, 0.1999, 0.2])), draw(st.sampled_from([5e-4, 0.11]))

    def sample():
        p = parameters(draw, "SmibPlant", x_line=0.1, t_fault=0.1, t_clear=0.2)
        rotor = [draw(st.floats(-2.0, 2.0)) for _ in range(4)]
        state = tree.like(shape("SmibPlant", "smib"), [*rotor, draw(st.floats(-9.0, 9.0)), 0.1])
        inputs = MODELS["SmibPlant"].inputs._replace(
            P_m=draw(st.floats(-1.0, 5.0)),
            E_f=draw(st.floats(0.0, 5.0)),
            V_inf=draw(st.floats(0.0, 1.2)),
            theta_inf=draw(st.floats(-4.0, 4.0)),
            f_inf=draw(st.sampled_from([0.0, 59.9])),
        )
        return p, state, inputs, t, h

    return sample(), sample()


@given(plant_samples())
def test_plant(samples):
    assert_agreement("SmibPlant", "smib", samples)


# PmuChannel ----------------------------------------------------------------------------------------------------------


@st.composite
def channel_samples(draw):
    """With everything that a frame can suffer, wild inputs too."""
    model = MODELS["PmuChannel"]
    t, h = 0.1, draw(st.sampled_from([1e-3, H, 0.5]))

    def sample():
        seed = draw(st.integers(0, 2**31 - 1))
        p = parameters(draw, "PmuChannel", seed=seed, dropout=0.3, gross_error_probability=0.3, latency=0.05)
        state, _ = model.programs["pmu_channel"].start(floats, p, model.inputs, 0.0)
        inputs = [draw(st.one_of(st.floats(-2.0, 2.0), WILD)) for _ in tree.leaves(model.inputs)]
        return p, state, tree.like(model.inputs, inputs), t, h

    return sample(), sample()


@given(channel_samples())
def test_channel(samples):
    assert_agreement("PmuChannel", "pmu_channel", samples)
