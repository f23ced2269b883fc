"""The interface of a model is the NamedTuple its equations take, annotated with unit, range and meaning.

    class Parameters(NamedTuple):
        gamma: Annotated[Scalar, Real("1", "adaptation gain", min=0.0, nominal=1e15)] = 1e15

`variables` lists what is annotated; the FMU's variables, modelDescription.xml, the range checks and the README's
table are all made from that list.
"""

import re
from dataclasses import dataclass
from typing import Any, Dict, List, NamedTuple, Optional, Tuple, Union, get_type_hints

from .tree import leaves

Scalar = Any
"""A float, a numpy array or a CasADi expression: see `carriers`."""

INLINE = "inline"
"""Annotation of a nested NamedTuple whose variables keep their own names (`H`, not `machine.H`)."""


@dataclass(frozen=True)
class Real:
    """A real number in `unit` ("1" for none), within [min, max]. A tunable parameter may change during a run."""

    unit: str
    description: str
    min: Optional[float] = None
    max: Optional[float] = None
    nominal: float = 1.0
    tunable: bool = False


@dataclass(frozen=True)
class Integer:
    """A whole number within [min, max]."""

    description: str
    min: Optional[int] = None
    max: Optional[int] = None
    tunable: bool = False


@dataclass(frozen=True)
class Boolean:
    """True (1) or false (0)."""

    description: str
    tunable: bool = False
    min = 0
    max = 1


@dataclass(frozen=True)
class Enumeration:
    """One of `items`; its value is the number of the item, counted from 1, as in FMI 2.0."""

    type_name: str
    description: str
    items: Tuple[str, ...]
    tunable: bool = False

    @property
    def min(self) -> int:
        return 1

    @property
    def max(self) -> int:
        return len(self.items)


Specification = Union[Real, Integer, Boolean, Enumeration]


class Variable(NamedTuple):
    name: str
    specification: Specification
    start: float


def variables(defaults: tuple) -> List[Variable]:
    """The annotated leaves of a tree of NamedTuples, in the order of `tree.leaves`, with their start values.

    Raises TypeError for a leaf without a specification.
    """
    return _variables(defaults, "")


def _variables(branch, prefix):
    hints = get_type_hints(type(branch), include_extras=True)
    found = []
    for field, value in zip(branch._fields, branch):
        metadata = getattr(hints.get(field), "__metadata__", ())
        if isinstance(value, tuple):
            found += _variables(value, prefix if INLINE in metadata else f"{prefix}{field}.")
        elif metadata:
            found.append(Variable(prefix + field, metadata[0], value))
        else:
            raise TypeError(
                f"{type(branch).__name__}.{field} has no specification (Real, Integer, Boolean or Enumeration)"
            )
    return found


class Rule(NamedTuple):
    """What must hold of values that are each in range; `{name}` in the message stands for that variable's value."""

    holds: Scalar
    message: str


def broken(rules: List[Rule], values: Dict[str, float]) -> List[str]:
    """The messages of the rules that do not hold, with the values of the variables they name."""
    return [
        re.sub(r"{(.*?)}", lambda name: f"{values[name[1]]:.12g}", rule.message) for rule in rules if not rule.holds
    ]


def describe(specification: Specification) -> str:
    """The allowed values in words: `[0, 10] s`, `whole numbers from 1 to 5`, `drem (1), gradient (2)`."""
    if isinstance(specification, Enumeration):
        return ", ".join(f"{item} ({number})" for number, item in enumerate(specification.items, 1))
    if isinstance(specification, Boolean):
        return "false (0), true (1)"
    low = "-inf" if specification.min is None else f"{specification.min:g}"
    high = "inf" if specification.max is None else f"{specification.max:g}"
    if isinstance(specification, Integer):
        return f"whole numbers from {low} to {high}"
    return f"[{low}, {high}] {'' if specification.unit == '1' else specification.unit}".rstrip()


def range_errors(defaults: tuple, values: tuple) -> List[str]:
    """A message for every value outside the range of its variable: its name, its value and what is allowed."""
    messages = []
    for (name, specification, _), value in zip(variables(defaults), leaves(values)):
        low, high = specification.min, specification.max
        inside = abs(value) < float("inf")  # false for NaN
        inside = inside and (low is None or value >= low) and (high is None or value <= high)
        if not inside:
            messages.append(f"{name} = {value:.12g} is not allowed; it must be in {describe(specification)}")
    return messages
