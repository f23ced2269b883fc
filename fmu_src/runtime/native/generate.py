"""The C sources of a model: its equations through CasADi, and model.h, the tables that fmi2_slave.c needs of it."""

import json
import re
from math import inf, isnan
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Dict, List

import fmpy
from casadi import OP_CONST, SX, CodeGenerator, Function, vertcat

from ...pmu_observer import tree
from ...pmu_observer.carriers import symbols
from ...pmu_observer.interface import describe
from ..model import Model, Program
from ..ports import Port, kind_of, ports

RUNTIME = Path(__file__).with_name("fmi2_slave.c")
HEADERS = sorted((Path(fmpy.__file__).parent / "c-code").glob("fmi2*.h"))  # the official ones

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
    N_WORK = {work},
    N_RULES = {rules},
    MAX_ARGUMENTS = {arguments},
    MAX_RESULTS = {results}
}};

/* The value reference is the index. */
static const Variable VARIABLES[] = {{
{variables}
}};

#define CASADI_SYMBOL_EXPORT static inline
#include "equations.c"

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


def sources(model: Model, guid: str) -> Dict[str, bytes]:
    """Every file that the FMU is compiled from, by name; fmi2_slave.c is the one to compile.

    Raises ValueError if an equation takes a function from elsewhere than the carrier, which makes it NaN.
    """
    programs = {name: functions(model, name, program) for name, program in model.programs.items()}
    rules = rule_function(model)
    generated = {
        "fmi2_slave.c": RUNTIME.read_bytes(),
        "model.h": model_h(model, guid, programs, rules).encode(),
        "equations.c": c_code([*[f for pair in programs.values() for f in pair], rules]),
    }
    return {**generated, **{header.name: header.read_bytes() for header in HEADERS}}


def functions(model: Model, name: str, program: Program) -> List[Function]:
    """The program's start and step, with the arguments and results that fmi2_slave.c says."""
    inputs, parameters, t, h = symbols_like(model.inputs), symbols_like(model.parameters), SX.sym("t"), SX.sym("h")
    state, outputs = program.start(symbols, parameters, inputs, t)
    start = function(f"start_{name}", [inputs, parameters, t], [outputs, state])
    state = symbols_like(state)
    next_state, outputs = program.step(symbols, parameters, state, inputs, t, h)
    step = function(f"step_{name}", [inputs, parameters, state, t, h], [outputs, next_state])
    return [start, step]


def rule_function(model: Model) -> Function:
    """rules: (inputs, parameters) -> 1 for every rule that holds."""
    inputs, parameters = symbols_like(model.inputs), symbols_like(model.parameters)
    holds = tuple(rule.holds for rule in model.rules(symbols, parameters, inputs))
    return function("rules", [inputs, parameters], [holds])


def symbols_like(shape):
    return tree.like(shape, [SX.sym(name) for name in tree.names(shape)])


def function(name: str, arguments: list, results: list) -> Function:
    made = Function(name, [vector(argument) for argument in arguments], [vector(result) for result in results])
    for k in range(made.n_instructions()):
        if made.instruction_id(k) == OP_CONST and isnan(made.instruction_constant(k)):
            raise ValueError(f"{name} has a NaN in it: take every function from the carrier, and no `math.sin`")
    return made


def vector(branch) -> SX:
    return SX(vertcat(*tree.leaves(branch)))


def c_code(all_functions: List[Function]) -> bytes:
    generator = CodeGenerator("equations.c", {"casadi_int": "int"})
    for each in all_functions:
        generator.add(each)
    with TemporaryDirectory() as folder:
        return Path(generator.generate(f"{folder}/")).read_bytes()


def model_h(model: Model, guid: str, programs: Dict[str, List[Function]], rules: Function) -> str:
    all_ports = ports(model)
    names = [port.variable.name for port in all_ports]
    every = [f for pair in programs.values() for f in pair] + [rules]
    messages = [rule.message for rule in model.rules(symbols, model.parameters, model.inputs)]
    return MODEL_H.format(
        name=model.name,
        guid=guid,
        max_step=number(model.max_step),
        selector=f"#define SELECTOR {names.index(model.selector)}\n" if model.selector else "",
        inputs=len(tree.leaves(model.inputs)),
        parameters=len(tree.leaves(model.parameters)),
        outputs=len(tree.leaves(model.outputs)),
        states=max(states(step) for _, step in programs.values()),
        work=max(1, *(f.sz_w() for f in every)),
        rules=len(messages),
        arguments=max(f.sz_arg() for f in every),
        results=max(f.sz_res() for f in every),
        variables="\n".join(f"    {variable(port)}," for port in all_ports),
        programs="\n".join(f"    {{start_{name}, step_{name}, {states(f[1])}}}," for name, f in programs.items()),
        messages="\n".join(f"    case {i}: {message(text, names)} break;" for i, text in enumerate(messages)),
    )


def states(step: Function) -> int:
    return step.size1_in(2)


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


def number(value: float) -> str:
    """A C constant that reads back as the same number."""
    return repr(float(value)).replace("inf", "INFINITY")
