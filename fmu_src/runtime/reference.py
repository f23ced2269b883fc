"""Reference results that go with an FMU, as CSV: what to feed it, and what it then shows after every step."""

from typing import Any, Dict, List

from ..pmu_observer import tree
from ..pmu_observer.carriers import floats
from ..pmu_observer.interface import variables
from .model import Model

STEPS = 120
FOLDER = "extra/pmu-observer.reference"
DIGITS = {"in": 17, "out": 9}
"""Inputs exactly; of the outputs what no other C library's sin changes."""


def reference_results(model: Model) -> Dict[str, bytes]:
    """`<model>_in.csv` and `<model>_out.csv`: start values, its default step, the outputs as they are after a step.

    The inputs of a row hold for the step from its time on.
    """
    h, parameters, program = model.step_size, model.parameters, model.program(model.parameters)
    inputs = [model.example(k * h) for k in range(STEPS + 1)]
    state, outputs = program.start(floats, parameters, inputs[0], 0.0)
    shown = [outputs]
    for k in range(STEPS):
        state, outputs = advanced(model, program, state, inputs[k], k * h, h)
        shown.append(outputs)
    found = {"out": (model.outputs, shown)}
    if tree.leaves(model.inputs):
        found["in"] = (model.inputs, inputs)
    return {
        f"{FOLDER}/{model.name}_{name}.csv": table(shape, rows, h, DIGITS[name])
        for name, (shape, rows) in found.items()
    }


def advanced(model: Model, program, state: Any, inputs: Any, t: float, h: float):
    """A communication step, divided as the slaves divide it."""
    divisions = max(1, round(h / model.max_step))
    outputs = None
    for i in range(divisions):
        step = h / divisions
        state, outputs = program.step(floats, model.parameters, state, inputs, t + i * step, step)
    return state, outputs


def table(shape: Any, rows: List[Any], h: float, digits: int) -> bytes:
    lines = [",".join(f'"{name}"' for name in ["time", *[v.name for v in variables(shape)]])]
    for k, row in enumerate(rows):
        lines.append(",".join(f"{float(value):.{digits}g}" for value in (k * h, *tree.leaves(row))))
    return ("\n".join(lines) + "\n").encode()
