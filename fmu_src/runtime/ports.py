"""The variables of an FMU, and their value references: one list for every kind of FMU."""

from typing import List, NamedTuple

from ..pmu_observer.interface import Boolean, Real, Specification, Variable, variables
from . import choices
from .model import Model


class Port(NamedTuple):
    """A variable of the FMU; its value reference is its place in the list of `ports`."""

    variable: Variable
    causality: str
    variability: str


def ports(model: Model) -> List[Port]:
    """Every variable of the FMU: inputs, then parameters, then outputs."""
    found = [Port(v, "input", input_variability(model, v)) for v in variables(model.inputs)]
    found += [
        Port(v, "parameter", "tunable" if v.specification.tunable else "fixed")
        for v in variables(choices.parameters(model))
    ]
    found += [
        Port(v, "output", "continuous" if isinstance(v.specification, Real) else "discrete")
        for v in variables(model.outputs)
    ]
    return found


def kind_of(specification: Specification) -> str:
    """The FMI type to get and set the variable by; enumerations are set as integers."""
    if isinstance(specification, Real):
        return "Real"
    return "Boolean" if isinstance(specification, Boolean) else "Integer"


def input_variability(model: Model, variable: Variable) -> str:
    return model.input_variability if isinstance(variable.specification, Real) else "discrete"
