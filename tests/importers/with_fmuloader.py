"""fmuloader, from Python: it binds every function of FMI 2.0, those of model exchange too."""

from pathlib import Path

from fmpy import read_model_description
from fmuloader.fmi2 import Fmi2Slave, Fmi2Status, Fmi2Type

from .case import FRAME, OBSERVER, PLANT, RESULTS, STARTS, STEPS, H, main


def load(path: Path) -> tuple[Fmi2Slave, dict[str, int]]:
    description = read_model_description(path)
    slave = Fmi2Slave(path, model_identifier=path.stem)
    slave.instantiate(path.stem, Fmi2Type.CO_SIMULATION, guid=str(description.guid))
    slave.setup_experiment(start_time=0.0)
    slave.enter_initialization_mode()
    return slave, {v.name: v.valueReference for v in description.modelVariables}


def run(folder: Path) -> dict[str, float]:
    (plant, of_plant), (observer, of_observer) = load(folder / PLANT), load(folder / OBSERVER)
    sources, sinks = [of_plant[name] for name in FRAME], [of_observer[name] for name in FRAME]
    observer.set_real([of_observer[name] for name in STARTS], list(STARTS.values()))
    observer.set_real(sinks, plant.get_real(sources))
    plant.exit_initialization_mode()
    observer.exit_initialization_mode()
    for k in range(STEPS):
        observer.set_real(sinks, plant.get_real(sources))
        for slave in (plant, observer):
            assert slave.do_step(k * H, H) == Fmi2Status.OK
    references = {"plant": (plant, of_plant), "observer": (observer, of_observer)}
    results = {}
    for component, names in RESULTS.items():
        slave, of_slave = references[component]
        values = slave.get_real([of_slave[name] for name in names])
        results |= {f"{component}.{name}": value for name, value in zip(names, values, strict=True)}
        slave.terminate()
        slave.free_instance()
    return results


if __name__ == "__main__":
    main(run)
