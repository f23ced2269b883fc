"""PmuObserver.fmu: PMU frames in, rotor angle, speed, E'd and E'q out."""

from functools import partial
from math import cos, pi, sin

from ..pmu_observer import observer
from ..pmu_observer.estimators import ESTIMATORS
from ..pmu_observer.machines import MACHINE_MODELS
from ..pmu_observer.phasors import Frame
from ..runtime.model import Model, Program, Terminal


def program(estimator: str, machine_model: str) -> Program:
    return Program(
        partial(observer.start, estimator, machine_model=machine_model),
        partial(observer.step, estimator, machine_model=machine_model),
        first_state=partial(observer.first_state, estimator, machine_model=machine_model),
    )


def example(t: float) -> observer.Inputs:
    """Frames of a machine at rest in a grid at 0.5 Hz above nominal."""
    V, I, lag = 1.0, 0.8, 0.2  # noqa: E741 - the paper's name
    S = V * I
    return observer.Inputs(Frame(V, pi * t, I, pi * t - lag, S * cos(lag), S * sin(lag)), S * cos(lag), 1.1, t_frame=t)


MODEL = Model(
    name="PmuObserver",
    description="Dynamic state observer for a synchronous generator seen by a PMU",
    inputs=observer.Inputs(),
    parameters=observer.Parameters(),
    outputs=observer.Outputs(),
    programs={
        **{name: program(name, "two_axis") for name in ESTIMATORS},
        **{f"robust_{model}": program("robust", model) for model in MACHINE_MODELS if model != "two_axis"},
    },
    selector="estimator",
    variant="machine_model",
    rules=observer.rules,
    example=example,
    input_variability="discrete",
    step_size=1 / 60,
    about="From the frames of a PMU at the terminal and the machine's data it estimates rotor angle, speed and the "
    "transient voltages E'd and E'q, each with a standard deviation. Source: Bobtsov, Ortega, Nikolaev, Schiffer and "
    "Lorenz-Meyer, State Observation of Power Systems Equipped with Phasor Measurement Units, 2020. Connect the frame "
    "and t_frame, set the machine's data and frame_time; the default estimator needs no start values and no gains.",
    limits=(
        "The machine's data must be known: what a wrong reactance or time constant costs is in the project's README.",
        "drem and the paper's other estimators follow exact signals; on noisy frames take robust, the default.",
        "Until status is 2 (tracking) the estimates are those of a bank of hypotheses, with large deviations.",
        "In masters that set inputs, step and read outputs in one go, a frame reaches the observer a step or two late: "
        "with frame_time = stamped it is dated right, and the estimates are predictions over that time.",
    ),
    terminals={"pmu": Terminal("input", "the frame of a PMU, and the machine's inputs")},
)
