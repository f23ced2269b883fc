"""libcosim, in C++, through libcosimpy. It ignores Enumeration variables: choices are made by number."""

from pathlib import Path

from libcosimpy.CosimEnums import CosimVariableCausality, CosimVariableType
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave

from .case import CONNECTIONS, FMUS, INTEGERS, REALS, RESULTS, STEPS, H, main, split


def run(folder: Path) -> dict[str, float]:
    execution = CosimExecution.from_step_size(round(H * 1e9))
    index = {name: execution.add_local_slave(CosimLocalSlave(str(folder / fmu), name)) for name, fmu in FMUS.items()}
    references = {
        name: {variable.name.decode(): variable.reference for variable in execution.slave_variables(index[name])}
        for name in FMUS
    }
    for target, source in CONNECTIONS.items():
        (end, end_variable), (start, start_variable) = split(target), split(source)
        ends = index[start], references[start][start_variable], index[end], references[end][end_variable]
        execution.connect_real_variables(*ends)
    for name, value in REALS.items():
        component, variable = split(name)
        execution.real_initial_value(index[component], references[component][variable], value)
    for name, value in INTEGERS.items():
        component, variable = split(name)
        execution.integer_initial_value(index[component], references[component][variable], value)
    last = CosimObserver.create_last_value()
    execution.add_observer(last)
    assert execution.step(STEPS)
    results = {}
    for component, names in RESULTS.items():
        values = last.last_real_values(index[component], [references[component][name] for name in names])
        results |= {f"{component}.{name}": value for name, value in zip(names, values, strict=True)}
    return results


def is_real_output(variable) -> bool:
    causality, kind = CosimVariableCausality(variable.causality), CosimVariableType(variable.type)
    return (causality, kind) == (CosimVariableCausality.OUTPUT, CosimVariableType.REAL)


def simulate(folder: Path, steps: int) -> list[dict[str, float]]:
    """The outputs of every component of an unpacked SSP after each step: `component.variable`, Reals only."""
    execution = CosimExecution.from_ssp_file(str(folder))
    last = CosimObserver.create_last_value()
    execution.add_observer(last)
    slaves = {info.name.decode(): info.index for info in execution.slave_infos()}
    outputs = {
        name: [v for v in execution.slave_variables(index) if is_real_output(v)] for name, index in slaves.items()
    }
    rows = []
    for _ in range(steps):
        assert execution.step()
        row = {}
        for name, variables in outputs.items():
            values = last.last_real_values(slaves[name], [v.reference for v in variables])
            row |= {f"{name}.{v.name.decode()}": value for v, value in zip(variables, values, strict=True)}
        rows.append(row)
    return rows


if __name__ == "__main__":
    main(run)
