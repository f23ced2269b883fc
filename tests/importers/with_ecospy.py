"""ecos, in C++, through ecospy. It ignores Enumeration variables: choices are made by number."""

from ctypes import CDLL, RTLD_GLOBAL
from pathlib import Path

from . import tbb
from .case import CONNECTIONS, FMUS, INTEGERS, REALS, RESULTS, STEPS, H, main, split


def run(folder: Path) -> dict[str, float]:
    CDLL(str(tbb.library()), RTLD_GLOBAL)
    from ecospy import EcosSimulation, EcosSimulationStructure

    with EcosSimulationStructure() as structure:
        for name, fmu in FMUS.items():
            structure.add_model(name, folder / fmu)
        for target, source in CONNECTIONS.items():
            structure.make_real_connection(*("::".join(split(end)) for end in (source, target)))
        starts = {"::".join(split(name)): value for name, value in {**REALS, **INTEGERS}.items()}
        structure.add_parameter_set("start", starts)
        simulation = EcosSimulation(structure=structure, step_size=H)
    simulation.init(parameter_set="start")
    simulation.step(STEPS)
    results = {f"{c}.{name}": simulation.get_real(f"{c}::{name}") for c, names in RESULTS.items() for name in names}
    simulation.terminate()
    simulation.free()
    return results


if __name__ == "__main__":
    main(run)
