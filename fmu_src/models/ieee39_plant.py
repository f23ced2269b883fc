"""Ieee39Plant.fmu: the IEEE 39-bus system, ten machines seen by PMUs."""

from ..pmu_observer.plants.ieee39 import plant
from ..runtime.model import Model, Program, Terminal

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
    example=lambda t: plant.Inputs(),
    about="A plant to try observers on: at each of ten generators the frame that a PMU would give, and the true "
    "states. Loads vary by chance; a load step, a fault and the trip of a branch can be set.",
    limits=(
        "There is no native kind, because the equations need numpy; C hosts may crash when they exit.",
        "The machines are two-axis models; loads are admittances.",
    ),
    terminals={f"G{k}": Terminal("output", f"what a PMU at generator {k} measures", f"G{k}.") for k in range(1, 11)},
    requirements=("numpy",),
)
