"""Ieee39Plant.fmu: the IEEE 39-bus system, ten machines seen by PMUs."""

from ..pmu_observer.plants.ieee39 import plant
from ..runtime.model import Model, Program

MODEL = Model(
    name="Ieee39Plant",
    description="IEEE 39-bus (New England) system: ten two-axis machines with AVR and PSS, seen by PMUs",
    inputs=plant.Inputs(),
    parameters=plant.Parameters(),
    outputs=plant.Outputs(),
    programs={"ieee39": Program(plant.start, plant.step)},
    rules=plant.rules,
    step_size=1 / 60,
    stop_time=20.0,
    requirements=("numpy",),
)
