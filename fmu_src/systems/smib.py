"""smib.ssp: a machine at an infinite bus, its PMU, and the observer that sees it through the PMU."""

from ..models import pmu_channel, pmu_observer, smib_plant
from ..pmu_observer.machines.data import ieee39_g6, paper_smib
from ..pmu_observer.observer_interface import STAMPED
from ..pmu_observer.plants.smib import P_M_V_T
from ..runtime.ssp import System

FRAME = ("V_t", "theta_t", "I_t", "phi_t", "P_t", "Q_t", "P_m", "E_f", "frame_valid", "t_frame")

E_F_G6 = 2.2577188870638936
"""pu, the field voltage of generator 6 at rest for P_m = 6.5 and V_t = 1.05: the plant's E_f_start."""

G6_FAULT = {
    "P_m": 6.5,
    "E_f": E_F_G6,
    "V_t_start": 1.05,
    "x_line": 0.03,
    "start_mode_number": P_M_V_T,
    "t_fault": 5.0,
    "t_clear": 5.1,
    "x_fault": 0.03,
}
"""The fault of scenarios/smib_fault.toml, five seconds earlier."""

STAMPED_FRAMES = {"observer.frame_time_number": STAMPED}  # libcosim and ecos know no enumerations


def of_machine(machine) -> dict:
    """Its data for plant and observer, which know it exactly."""
    return {f"{c}.{name}": value for c in ("plant", "observer") for name, value in machine._asdict().items()}


SYSTEM = System(
    name="smib",
    description="Single machine at an infinite bus, seen by a PMU, and its observer",
    components={"plant": smib_plant.MODEL, "channel": pmu_channel.MODEL, "observer": pmu_observer.MODEL},
    connections={
        **{f"channel.plant.{name}": f"plant.{name}" for name in (*FRAME[:4], "t_frame")},
        **{f"channel.plant.{name}": f"plant.{name}_out" for name in ("P_m", "E_f")},
        **{f"observer.{name}": f"channel.{name}" for name in FRAME},
    },
    outputs={
        f"{component}_{name}": f"{component}.{name}"
        for component in ("plant", "observer")
        for name in ("delta", "omega", "e1d", "e1q")
    },
    sets={
        "paper_smib": {**of_machine(paper_smib()), **STAMPED_FRAMES},
        "ieee39_g6_fault": {
            **of_machine(ieee39_g6()),
            **{f"plant.{name}": value for name, value in G6_FAULT.items()},
            **STAMPED_FRAMES,
        },
    },
    step_size=1 / 60,
)
