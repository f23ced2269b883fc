"""Every parameter outside its range is refused by a message with its name, its value and what is allowed."""

from math import inf, nan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fmu_src.pmu_observer import observer, tree
from fmu_src.pmu_observer.carriers import floats
from fmu_src.pmu_observer.interface import Enumeration, Real, broken, range_errors, variables
from fmu_src.pmu_observer.machines import two_axis
from fmu_src.pmu_observer.plants import smib

TREES = {"observer": observer.Parameters(), "plant": smib.Parameters()}
PARAMETERS = [(kind, variable) for kind, defaults in TREES.items() for variable in variables(defaults)]


def wrong_values(specification):
    values = [nan, inf, -inf] if isinstance(specification, Real) else []
    if specification.min is not None:
        values.append(specification.min - 1)
    if specification.max is not None:
        values.append(specification.max * 1.001 if isinstance(specification, Real) else specification.max + 1)
    return values


def with_value(defaults, name, value):
    names = [variable.name for variable in variables(defaults)]
    leaves = tree.leaves(defaults)
    leaves[names.index(name)] = value
    return tree.like(defaults, leaves)


@pytest.mark.parametrize(("kind", "variable"), PARAMETERS, ids=[f"{kind}-{v.name}" for kind, v in PARAMETERS])
def test_out_of_range(kind, variable):
    specification = variable.specification
    for value in wrong_values(specification):
        (message,) = range_errors(TREES[kind], with_value(TREES[kind], variable.name, value))
        assert message.startswith(f"{variable.name} = {value:.12g} is not allowed")
        allowed = message.split("must be")[1]
        if isinstance(specification, Enumeration):
            assert all(f"{item} ({number})" in allowed for number, item in enumerate(specification.items, 1))
        else:
            assert "[" in allowed or "from" in allowed
            assert all(f"{bound:g}" in allowed for bound in (specification.min, specification.max) if bound is not None)
            assert getattr(specification, "unit", "1") in ("1", allowed.split()[-1])


@pytest.mark.parametrize("defaults", TREES.values(), ids=TREES)
def test_the_defaults_are_in_range(defaults):
    assert range_errors(defaults, defaults) == []


@pytest.mark.parametrize("kind", TREES)
@given(data=st.data())
def test_values_in_range_are_accepted(kind, data):
    listed = variables(TREES[kind])
    values = [
        data.draw(
            st.floats(s.min, s.max, allow_nan=False, allow_infinity=False)
            if isinstance(s, Real)
            else st.integers(s.min, s.max)
        )
        for s in (variable.specification for variable in listed)
    ]
    assert range_errors(TREES[kind], tree.like(TREES[kind], values)) == []


def messages(rules, values):
    return broken(rules, {variable.name: value for variable, value in zip(variables(values), tree.leaves(values))})


@pytest.mark.parametrize(("small", "large"), [("xd1", "xd"), ("xq1", "xq"), ("xd1", "xq")])
def test_a_transient_reactance_is_not_above_the_synchronous_one(small, large):
    """Nor x'd above xq: b2 would be negative."""
    p = observer.Parameters().machine._replace(xd=1.0, xq=1.0, xd1=0.1, xq1=0.1)._replace(**{small: 0.2, large: 0.15})
    (message,) = messages(two_axis.rules(floats, p), p)
    assert message.startswith(f"{small} = 0.2 ") and f"{large} = 0.15" in message
    assert messages(two_axis.rules(floats, p._replace(**{large: 0.2})), p) == []


def test_the_adaptive_speed_observer_needs_the_mechanical_power():
    p = observer.Parameters(speed_observer=2, mechanical_power=2)
    (message,) = messages(observer.rules(floats, p, observer.Inputs()), p)
    assert "mechanical_power = 2" in message and "speed_observer = 2" in message
    assert messages(observer.rules(floats, p._replace(mechanical_power=1), observer.Inputs()), p) == []
