"""PmuChannel.fmu: true phasors in, the frames of a PMU out."""

from math import pi

from ..pmu_observer import pmu_channel
from ..runtime.model import Model, Program, Terminal


def example(t: float) -> pmu_channel.Inputs:
    """Phasors of a grid at 0.5 Hz above nominal."""
    return pmu_channel.Inputs(pmu_channel.Plant(1.0, pi * t, 0.8, pi * t - 0.2, 0.78, 1.1, t))


MODEL = Model(
    name="PmuChannel",
    description="PMU and its network: frames with noise, bias, limited resolution, latency, losses and gross errors",
    inputs=pmu_channel.Inputs(),
    parameters=pmu_channel.Parameters(),
    outputs=pmu_channel.Outputs(),
    programs={"pmu_channel": Program(pmu_channel.start, pmu_channel.step, pmu_channel.output)},
    rules=pmu_channel.rules,
    example=example,
    step_size=1 / 60,
    about="What stands between a machine and its observer in the field. A frame is taken at the communication points "
    "at or after every multiple of 1/rate; t_frame says when the frame that is shown was measured.",
    limits=(
        "The inputs of a step are those of its begin, as FMI 2.0 has it; in a master that sets those of its end "
        "(Gauss-Seidel), connect plant.t_frame.",
        "Noise is white; a PMU's own filter and its answer to a changing frequency are not in it.",
        "A latency is rounded up to whole frames, 32 at most.",
    ),
    terminals={
        "plant": Terminal("input", "the true values at the terminal", "plant."),
        "pmu": Terminal("output", "the frame that comes"),
    },
)
