"""The C sources of a model: its equations through CasADi, and model.h, the tables that fmi2_slave.c needs of it."""

import json
import re
from contextlib import contextmanager
from math import inf
from pathlib import Path
from typing import Any, Dict, List

from casadi import SX, Function, GlobalOptions

from ...pmu_observer import tree
from ...pmu_observer.carriers import symbols
from ...pmu_observer.carriers.symbols import symbols_like, vector
from ...pmu_observer.interface import describe
from .. import choices
from ..model import Model, Program
from ..ports import Port, kind_of, ports
from .c_code import c_function, number

RUNTIME = Path(__file__).with_name("fmi2_slave.c")
HEADERS = sorted((Path(__file__).parent / "headers").glob("fmi2*.h"))
"""Those of the FMI project, unchanged (2-clause BSD): with FMI2_FUNCTION_PREFIX, several FMUs make one program."""

MODEL_H = """\
/* Generated from the declaration of {name}: its variables, and its equations. */

#define MODEL_GUID "{guid}"
#define MAX_STEP {max_step}
{selector}
enum {{
    N_INPUTS = {inputs},
    N_PARAMETERS = {parameters},
    N_OUTPUTS = {outputs},
    N_STATES = {states}, /* of the program that has most of them */
    N_RULES = {rules}
}};

/* The value reference is the index. */
static const Variable VARIABLES[] = {{
{variables}
}};

#include "equations.h"

static const Program PROGRAMS[] = {{
{programs}
}};

static void rule_message(int rule, const double *values, char *text, size_t size) {{
    (void)values, (void)text, (void)size;
    switch (rule) {{
{messages}
    }}
}}
"""


START = """\
static void start_{name}(const double *inputs, const double *parameters, double t, double *restrict outputs,
                         double *restrict state) {{
    double next_state[{states}];
    first_state_{name}(inputs, parameters, t, state);
    step_{name}(inputs, parameters, state, t, 0.0, outputs, next_state);
}}
"""
"""The start of a program that has a first state: its outputs are those of a step of zero length."""


def sources(model: Model, guid: str) -> Dict[str, bytes]:
    """Every file that the FMU is compiled from, by name; fmi2_slave.c is the one to compile.

    Raises ValueError if an equation takes a function from elsewhere than the carrier, which makes it NaN.
    """
    functions = {name: program_functions(model, program) for name, program in model.programs.items()}
    loops: Dict[str, str] = {}
    equations = [c_function(f"{f.name()}_{name}", f, loops) for name, group in functions.items() for f in group]
    equations.append(c_function("rules", rule_function(model), loops))
    first = [name for name, program in model.programs.items() if program.first_state]
    equations += [START.format(name=name, states=functions[name][1].numel_out("next_state")) for name in first]
    equations = [f"static void {name}{body}" for body, name in loops.items()] + equations
    states = {name: step.numel_out("next_state") for name, (_, step, *_) in functions.items()}
    generated = {
        "fmi2_slave.c": RUNTIME.read_bytes(),
        "model.h": model_h(model, guid, states).encode(),
        "equations.h": "\n".join(equations).encode(),
    }
    return {**generated, **{header.name: header.read_bytes() for header in HEADERS}}


@contextmanager
def as_written():
    """The C rounds as the Python FMU does: CasADi would cancel and rearrange some operations on the way."""
    before = GlobalOptions.getSimplificationOnTheFly()
    GlobalOptions.setSimplificationOnTheFly(False)
    try:
        yield
    finally:
        GlobalOptions.setSimplificationOnTheFly(before)


@as_written()
def program_functions(model: Model, program: Program) -> List[Function]:
    """The program's start and step, and its output if it has one, with the arguments that fmi2_slave.c gives them."""
    inputs, all_parameters = symbols_like(model.inputs), symbols_like(choices.parameters(model))
    parameters, t, h = choices.chosen(symbols, model, all_parameters), SX.sym("t"), SX.sym("h")
    given = {"inputs": inputs, "parameters": all_parameters}
    if program.first_state:
        state = program.first_state(symbols, parameters, inputs, t)
        start = function("first_state", {**given, "t": t}, {"state": state})
    else:
        state, outputs = program.start(symbols, parameters, inputs, t)
        start = function("start", {**given, "t": t}, {"outputs": outputs, "state": state})
    state = symbols_like(state)
    next_state, outputs = program.step(symbols, parameters, state, inputs, t, h)
    of_state = {**given, "state": state, "t": t}
    step = function("step", {**of_state, "h": h}, {"outputs": outputs, "next_state": next_state})
    if program.output is None:
        return [start, step]
    outputs = program.output(symbols, parameters, state, inputs, t)
    return [start, step, function("output", of_state, {"outputs": outputs})]


@as_written()
def rule_function(model: Model) -> Function:
    """holds[i] = 1 if rule number i holds, else 0."""
    inputs, all_parameters = symbols_like(model.inputs), symbols_like(choices.parameters(model))
    rules = model.rules(symbols, choices.chosen(symbols, model, all_parameters), inputs)
    holds = tuple(rule.holds for rule in rules)
    return function("rules", {"inputs": inputs, "parameters": all_parameters}, {"holds": holds})


def function(name: str, arguments: Dict[str, Any], results: Dict[str, Any]) -> Function:
    """A CasADi function of trees."""
    vectors_in = [vector(branch) for branch in arguments.values()]
    vectors_out = [vector(branch) for branch in results.values()]
    return Function(name, vectors_in, vectors_out, list(arguments), list(results))


def model_h(model: Model, guid: str, states: Dict[str, int]) -> str:
    """The tables; `states` is the number of states of each program."""
    all_ports = ports(model)
    names = [port.variable.name for port in all_ports]
    messages = [rule.message for rule in model.rules(symbols, model.parameters, model.inputs)]
    return MODEL_H.format(
        name=model.name,
        guid=guid,
        max_step=number(model.max_step),
        selector=selector(model, names),
        inputs=len(tree.leaves(model.inputs)),
        parameters=len(tree.leaves(choices.parameters(model))),
        outputs=len(tree.leaves(model.outputs)),
        states=max(states.values()),
        rules=len(messages),
        variables="\n".join(f"    {variable(port)}," for port in all_ports),
        programs="\n".join(f"    {entry(model, name, states[name])}," for name in model.table()),
        messages="\n".join(f"    case {i}: {message(text, names)} break;" for i, text in enumerate(messages)),
    )


def selector(model: Model, names: List[str]) -> str:
    """The places of the parameter that selects the program, and of its number, which goes before."""
    if not model.selector:
        return ""
    places = names.index(model.selector), names.index(model.selector + choices.SUFFIX)
    lines = "#define SELECTOR {}\n#define SELECTOR_NUMBER {}\n#define SELECTED {}\n".format(*places, model.selected)
    if not model.variant:
        return lines
    places = names.index(model.variant), names.index(model.variant + choices.SUFFIX)
    return lines + "#define VARIANT {}\n#define VARIANT_NUMBER {}\n".format(*places)


def entry(model: Model, name: str, states: int) -> str:
    output = f"output_{name}" if model.programs[name].output else "NULL"
    return f"{{start_{name}, step_{name}, {output}, {states}}}"


def variable(port: Port) -> str:
    (name, specification, start), causality, variability = port
    role = f"{variability}_{causality}" if causality == "parameter" else causality
    low = -inf if specification.min is None else specification.min
    high = inf if specification.max is None else specification.max
    cells = [text(name), kind_of(specification).upper(), role.upper(), number(start), number(low), number(high)]
    return f"{{{', '.join(cells)}, {text(describe(specification))}}}"


def message(template: str, names: List[str]) -> str:
    """A call of snprintf that writes the message of a rule into `text`."""
    parts = re.split(r"{(.*?)}", template)
    form = "%.12g".join(part.replace("%", "%%") for part in parts[::2])
    values = "".join(f", values[{names.index(name)}]" for name in parts[1::2])
    return f"snprintf(text, size, {text(form)}{values});"


def text(string: str) -> str:
    return json.dumps(string, ensure_ascii=False)
