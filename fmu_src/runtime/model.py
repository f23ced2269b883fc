"""A model as the runtimes see it: annotated trees for its interface, and functions for what it does."""

from math import inf
from typing import Any, Callable, Dict, List, NamedTuple, Optional, Tuple

from ..pmu_observer.interface import Enumeration, Rule, variables

Tree = Any
"""A NamedTuple of scalars and of further NamedTuples: see `pmu_observer.tree`."""


ON_TIME = 1e-2
"""Of a communication step: a master that adds up its steps, or counts in nanoseconds, may begin one this much off the
end of the last one, and end it this much after stopTime. What is wrong is wrong by whole steps."""


class Program(NamedTuple):
    """The equations of a model; `xp` is the carrier of its scalars.

    start(xp, parameters, inputs, t) -> state, outputs at t
    step(xp, parameters, state, inputs, t, h) -> state, outputs at t + h
    output(xp, parameters, state, inputs, t) -> outputs at t

    `output` is for equations with direct feedthrough: where an input is set after a step, the outputs that are read
    then show it. It changes nothing, so that reading twice gives the same.

    first_state(xp, parameters, inputs, t) -> state is for equations whose start is that state, with the outputs of a
    step of zero length: C then needs the step once only.
    """

    start: Callable[..., Tuple[Tree, Tree]]
    step: Callable[..., Tuple[Tree, Tree]]
    output: Optional[Callable[..., Tree]] = None
    first_state: Optional[Callable[..., Tree]] = None


class Terminal(NamedTuple):
    """Those variables of a PMU's frame that have the prefix, among the inputs or among the outputs."""

    causality: str
    description: str
    prefix: str = ""


def no_example(t: float) -> Tree:
    return ()


def no_rules(xp, parameters, inputs) -> List[Rule]:
    return []


class Model(NamedTuple):
    """A declaration of an FMU. `inputs`, `parameters` and `outputs` are the annotated trees with their start values."""

    name: str
    description: str
    inputs: Tree
    parameters: Tree
    outputs: Tree
    programs: Dict[str, Program]
    """One program, or one for each item of the enumeration parameter named by `selector`."""
    selector: str = ""
    variant: str = ""
    """A second enumeration parameter: its item b turns program a into a_b, where there is one; else it is still a."""
    rules: Callable[..., List[Rule]] = no_rules
    """rules(xp, parameters, inputs): what must hold at the start of values that are each in range."""
    input_variability: str = "continuous"
    """`discrete` for frames, which must not be interpolated."""
    max_step: float = inf
    """s; the runtime divides longer communication steps."""
    step_size: float = 1e-2
    """s; of the default experiment."""
    stop_time: float = 10.0
    """s; of the default experiment."""
    about: str = ""
    """What it is, in some sentences for its documentation."""
    limits: Tuple[str, ...] = ()
    """What it does not do, a sentence each."""
    terminals: Dict[str, Terminal] = {}
    """By name: what is plugged as one."""
    example: Callable[[float], Tree] = no_example
    """The inputs at a time, for the reference results that go with the FMU."""
    requirements: Tuple[str, ...] = ()
    """Packages beyond the standard library that the Python FMU imports."""

    def program(self, parameters: Tree) -> Program:
        """The program that the parameters select."""
        table = self.table()
        row = int(getattr(parameters, self.selector)) - 1 if self.selector else 0
        column = int(getattr(parameters, self.variant)) - 1 if self.variant else 0
        return self.programs[table[column * self.selected + row]]

    @property
    def selected(self) -> int:
        """How many items the selector has."""
        return len(self.items(self.selector)) if self.selector else 1

    def items(self, parameter: str) -> Tuple[str, ...]:
        """Of an enumeration parameter."""
        (found,) = [v.specification for v in variables(self.parameters) if v.name == parameter]
        return found.items if isinstance(found, Enumeration) else ()

    def table(self) -> List[str]:
        """The names of the programs for each item of the selector, and these for each item of the variant."""
        if not self.selector:
            return list(self.programs)
        selected, variants = self.items(self.selector), self.items(self.variant) if self.variant else ("",)
        return [f"{a}_{b}" if f"{a}_{b}" in self.programs else a for b in variants for a in selected]
