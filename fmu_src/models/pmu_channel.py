"""PmuChannel.fmu: true phasors in, the frames of a PMU out."""

from ..pmu_observer import pmu_channel
from ..runtime.model import Model, Program

MODEL = Model(
    name="PmuChannel",
    description="PMU and its network: frames with noise, bias, limited resolution, latency, losses and gross errors",
    inputs=pmu_channel.Inputs(),
    parameters=pmu_channel.Parameters(),
    outputs=pmu_channel.Outputs(),
    programs={"pmu_channel": Program(pmu_channel.start, pmu_channel.step, pmu_channel.output)},
    rules=pmu_channel.rules,
    step_size=1 / 60,
)
