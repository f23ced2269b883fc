"""ecos, in C++, through ecospy. It ignores Enumeration variables: the default estimator runs."""

from ctypes import CDLL, RTLD_GLOBAL
from pathlib import Path

from . import tbb
from .case import FRAME, OBSERVER, PLANT, RESULTS, STARTS, STEPS, H, main


def run(folder: Path) -> dict[str, float]:
    CDLL(str(tbb.library()), RTLD_GLOBAL)
    from ecospy import EcosSimulation, EcosSimulationStructure

    with EcosSimulationStructure() as structure:
        structure.add_model("plant", folder / PLANT)
        structure.add_model("observer", folder / OBSERVER)
        for name in FRAME:
            structure.make_real_connection(f"plant::{name}", f"observer::{name}")
        structure.add_parameter_set("start", {f"observer::{name}": value for name, value in STARTS.items()})
        simulation = EcosSimulation(structure=structure, step_size=H)
    simulation.init(parameter_set="start")
    simulation.step(STEPS)
    results = {f"{c}.{name}": simulation.get_real(f"{c}::{name}") for c, names in RESULTS.items() for name in names}
    simulation.terminate()
    simulation.free()
    return results


if __name__ == "__main__":
    main(run)
