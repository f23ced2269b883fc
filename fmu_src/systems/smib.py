"""smib.ssp: a machine at an infinite bus, its PMU, and the observer that sees it through the PMU."""

from ..models import pmu_channel, pmu_observer, smib_plant
from ..runtime.ssp import System

FRAME = ("V_t", "theta_t", "I_t", "phi_t", "P_t", "Q_t", "P_m", "E_f", "frame_valid")

PLANT, CHANNEL, OBSERVER = smib_plant.MODEL, pmu_channel.MODEL, pmu_observer.MODEL

SYSTEM = System(
    name="smib",
    description="Single machine at an infinite bus, seen by a PMU, and its observer",
    components={"plant": PLANT, "channel": CHANNEL, "observer": OBSERVER},
    connections={
        **{f"channel.plant.{name}": f"plant.{name}" for name in FRAME[:4]},
        "channel.plant.E_f": "plant.E_f_start",  # the field voltage of the start, which is held
        **{f"observer.{name}": f"channel.{name}" for name in FRAME},
    },
    starts={"channel.plant.P_m": PLANT.inputs.P_m},  # an input of the plant, and no output to connect
)
