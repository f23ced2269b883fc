"""A run of the plant's equations: outputs by name, one array element a frame."""

from dataclasses import dataclass

import numpy as np

from fmu_src.pmu_observer import tree
from fmu_src.pmu_observer.interface import variables
from fmu_src.pmu_observer.plants.ieee39 import plant
from fmu_src.pmu_observer.plants.ieee39.plant import Inputs, Parameters, State

NAMES = [variable.name for variable in variables(plant.Outputs())]


@dataclass(frozen=True)
class Run:
    state: State
    outputs: np.ndarray  # (frames, variables)

    def __getitem__(self, name):
        return self.outputs[:, NAMES.index(name)]


def simulate(duration: float, h: float = 1 / 60, **parameters) -> Run:
    p = Parameters(**parameters)
    state, first = plant.start(None, p, Inputs(), 0.0)
    return resume(p, state, [tree.leaves(first)], 0, round(duration / h), h)


def resume(p: Parameters, state: State, found: list, first: int, last: int, h: float = 1 / 60) -> Run:
    for k in range(first, last):
        state, outputs = plant.step(None, p, state, Inputs(), k * h, h)
        found.append(tree.leaves(outputs))
    return Run(state, np.array(found))
