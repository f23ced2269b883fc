"""Which outputs depend on which variables: found by running the equations on what their scalars depend on."""

from typing import Any, List

from ..pmu_observer import tree
from ..pmu_observer.carriers import dependencies
from ..pmu_observer.carriers.dependencies import Dependent
from . import choices
from .model import Model, Program


def in_step_mode(model: Model) -> List[List[int]]:
    """For each output, the places in `ports` of the inputs of its own instant that it depends on directly."""
    none: List[List[int]] = [[] for _ in tree.leaves(model.outputs)]
    inputs, parameters = numbered(model.inputs, 0), nothing(model.parameters)
    programs = [program for program in model.programs.values() if program.output]
    found = [
        tree.leaves(program.output(dependencies, parameters, state_of(model, program), inputs, Dependent(0)))
        for program in programs
        if program.output
    ]
    return merged(found) if found else none


def at_start(model: Model) -> List[List[int]]:
    """The same of inputs and parameters, in initialization mode; all of them where equations need other packages."""
    inputs = numbered(model.inputs, 0)
    given = numbered(choices.parameters(model), len(tree.leaves(model.inputs)))
    parameters = choices.chosen(dependencies, model, given)
    if model.requirements:
        knowns = range(len(tree.leaves((inputs, given))))
        return [list(knowns) for _ in tree.leaves(model.outputs)]
    chosen = dependencies.together(*[getattr(parameters, name) for name in (model.selector, model.variant) if name])
    found = []
    for program in model.programs.values():
        _, outputs = program.start(dependencies, parameters, inputs, Dependent(0))
        found.append([dependencies.together(output, chosen) for output in tree.leaves(outputs)])
    return merged(found)


def numbered(shape: Any, first: int) -> Any:
    return tree.like(shape, [Dependent(1 << place) for place, _ in enumerate(tree.leaves(shape), first)])


def nothing(shape: Any) -> Any:
    return tree.map(lambda leaf: Dependent(0), shape)


def state_of(model: Model, program: Program) -> Any:
    state, _ = program.start(dependencies, nothing(model.parameters), nothing(model.inputs), Dependent(0))
    return nothing(state)


def merged(found: List[List[Any]]) -> List[List[int]]:
    """Of several programs: what an output depends on in any of them."""
    union = [dependencies.together(*scalars).bits for scalars in zip(*found)]
    return [[place for place in range(bits.bit_length()) if bits >> place & 1] for bits in union]
