"""SmibPlant.fmu: a two-axis machine behind a line at an infinite bus, with a three-phase fault."""

from ..pmu_observer.plants import smib
from ..runtime.model import Model, Program

MODEL = Model(
    name="SmibPlant",
    description="Synchronous generator (two-axis model) behind a line at an infinite bus, seen by a PMU",
    inputs=smib.Inputs(),
    parameters=smib.Parameters(),
    outputs=smib.Outputs(),
    programs={"smib": Program(smib.start, smib.step, smib.outputs)},
    rules=smib.rules,
    max_step=smib.MAX_STEP,
    step_size=1e-3,
)
