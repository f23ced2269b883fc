"""Choices by number, for importers that ignore Enumeration variables (libcosim, ecos): an Integer beside each of them.

`estimator_number` = 3 is the third item of `estimator`, whatever that one says; 0, its start, leaves the choice there.
"""

from typing import Annotated, Any, NamedTuple

from ..pmu_observer import tree
from ..pmu_observer.interface import INLINE, Enumeration, Integer, Scalar, variables
from .model import Model

SUFFIX = "_number"


class Parameters(NamedTuple):
    """The parameters as the FMU has them."""

    own: Annotated[Any, INLINE]  # the model's
    numbers: Annotated[Any, INLINE]


def parameters(model: Model) -> Parameters:
    """Those of the model with their start values, and a number for each of its enumerations."""
    fields = [
        (
            name.replace(".", "_") + SUFFIX,
            Annotated[Scalar, Integer(text(name), min=0, max=specification.max, tunable=specification.tunable)],
        )
        for name, specification, _ in variables(model.parameters)
        if isinstance(specification, Enumeration)
    ]
    numbers: Any = NamedTuple("Numbers", fields)
    return Parameters(model.parameters, numbers(*[0] * len(fields)))


def text(name: str) -> str:
    return f"item of {name} by its number, for importers that ignore enumerations; 0: as {name} says"


def chosen(xp, model: Model, p: Parameters) -> Any:
    """The model's own parameters, each choice replaced by its number where that is given."""
    leaves = tree.leaves(p.own)
    places = [i for i, v in enumerate(variables(model.parameters)) if isinstance(v.specification, Enumeration)]
    for place, number in zip(places, p.numbers):
        leaves[place] = xp.where(number > 0, number, leaves[place])
    return tree.like(model.parameters, leaves)
