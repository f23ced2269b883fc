"""A model as the runtimes see it: annotated trees for its interface, and functions for what it does."""

from math import inf
from typing import Any, Callable, Dict, List, NamedTuple, Tuple

from ..pmu_observer.interface import Rule

Tree = Any
"""A NamedTuple of scalars and of further NamedTuples: see `pmu_observer.tree`."""


class Program(NamedTuple):
    """The equations of a model; `xp` is the carrier of its scalars.

    start(xp, parameters, inputs, t) -> state, outputs at t
    step(xp, parameters, state, inputs, t, h) -> state, outputs at t + h
    """

    start: Callable[..., Tuple[Tree, Tree]]
    step: Callable[..., Tuple[Tree, Tree]]


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
    rules: Callable[..., List[Rule]] = no_rules
    """rules(xp, parameters, inputs): what must hold at the start of values that are each in range."""
    input_variability: str = "continuous"
    """`discrete` for frames, which must not be interpolated."""
    feedthrough: bool = False
    """The outputs at the end of a step show the inputs of that instant: a master sets those, then steps the FMU."""
    max_step: float = inf
    """s; the runtime divides longer communication steps."""
    step_size: float = 1e-2
    """s; of the default experiment."""
    stop_time: float = 10.0
    """s; of the default experiment."""
    requirements: Tuple[str, ...] = ()
    """Packages beyond the standard library that the Python FMU imports."""

    def program(self, parameters: Tree) -> Program:
        """The program that the parameters select."""
        if not self.selector:
            return next(iter(self.programs.values()))
        return list(self.programs.values())[int(getattr(parameters, self.selector)) - 1]
