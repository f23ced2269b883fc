"""libcosim, in C++, through libcosimpy. It ignores Enumeration variables: the default estimator runs."""

from pathlib import Path

from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave

from .case import FRAME, OBSERVER, PLANT, RESULTS, STARTS, STEPS, H, main


def run(folder: Path) -> dict[str, float]:
    execution = CosimExecution.from_step_size(round(H * 1e9))
    slaves = {"plant": PLANT, "observer": OBSERVER}
    index = {name: execution.add_local_slave(CosimLocalSlave(str(folder / fmu), name)) for name, fmu in slaves.items()}
    references = {
        name: {variable.name.decode(): variable.reference for variable in execution.slave_variables(index[name])}
        for name in slaves
    }
    plant, observer = references["plant"], references["observer"]
    for name in FRAME:
        execution.connect_real_variables(index["plant"], plant[name], index["observer"], observer[name])
    for name, value in STARTS.items():
        execution.real_initial_value(index["observer"], observer[name], value)
    last = CosimObserver.create_last_value()
    execution.add_observer(last)
    assert execution.step(STEPS)
    results = {}
    for component, names in RESULTS.items():
        values = last.last_real_values(index[component], [references[component][name] for name in names])
        results |= {f"{component}.{name}": value for name, value in zip(names, values, strict=True)}
    return results


if __name__ == "__main__":
    main(run)
