"""PmuObserver.fmu: PMU frames in, rotor angle, speed, E'd and E'q out."""

from functools import partial

from ..pmu_observer import observer
from ..pmu_observer.estimators import ESTIMATORS
from ..runtime.model import Model, Program

MODEL = Model(
    name="PmuObserver",
    description="Dynamic state observer for a synchronous generator seen by a PMU",
    inputs=observer.Inputs(),
    parameters=observer.Parameters(),
    outputs=observer.Outputs(),
    programs={name: Program(partial(observer.start, name), partial(observer.step, name)) for name in ESTIMATORS},
    selector="estimator",
    rules=observer.rules,
    input_variability="discrete",
    step_size=1 / 60,
)
