"""SmibPlant.fmu: a two-axis machine behind a line at an infinite bus, with a three-phase fault."""

from ..pmu_observer.plants import smib
from ..runtime.model import Model, Program, Terminal

MODEL = Model(
    name="SmibPlant",
    description="Synchronous generator (two-axis model) behind a line at an infinite bus, seen by a PMU",
    inputs=smib.Inputs(),
    parameters=smib.Parameters(),
    outputs=smib.Outputs(),
    programs={"smib": Program(smib.start, smib.step, smib.outputs)},
    rules=smib.rules,
    max_step=smib.MAX_STEP,
    example=lambda t: smib.Inputs(),
    step_size=1e-3,
    about="A plant to try observers on: it gives the frame that a PMU at the terminal would, and the true states. "
    "A three-phase fault through x_fault at the terminal begins at t_fault and is cleared at t_clear.",
    limits=(
        "The machine is the two-axis model: no subtransient windings and no saturation; it has no controllers, P_m and "
        "E_f are inputs.",
        "Stator and network are quasi-stationary: no transients of the line's own.",
    ),
    terminals={"pmu": Terminal("output", "what a PMU at the terminal measures, and the machine's inputs")},
)
