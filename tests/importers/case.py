"""What every importer runs: plant, PMU and two observers; outputs are exchanged, then all are stepped.

Choices are made by number, which every importer can set: `chosen` has another estimator than the default, and others.
"""

import json
import sys
from pathlib import Path
from typing import Callable

H = 1 / 64
"""s; a whole number of nanoseconds, in which some importers count."""

STEPS = 128

FMUS = {
    "plant": "SmibPlant.fmu",
    "channel": "PmuChannel.fmu",
    "observer": "PmuObserver.fmu",
    "chosen": "PmuObserver.fmu",
}

FRAME = ("V_t", "theta_t", "I_t", "phi_t")
CONNECTIONS = {
    **{f"channel.plant.{name}": f"plant.{name}" for name in (*FRAME, "t_frame")},
    **{f"channel.plant.{name}": f"plant.{name}_out" for name in ("P_m", "E_f")},
    **{f"{o}.{name}": f"plant.{name}" for o in ("observer", "chosen") for name in (*FRAME, "P_t", "Q_t")},
    **{f"{o}.{name}": f"plant.{name}_out" for o in ("observer", "chosen") for name in ("P_m", "E_f")},
}
"""The source of every input that is connected; all are Reals."""

REALS = {"channel.tve": 0.0, "channel.rate": 64.0, "observer.D": 2.0, "chosen.D": 2.0}
INTEGERS = {
    "chosen.estimator_number": 3,  # gradient
    "chosen.speed_observer_number": 1,
    "chosen.power_source_number": 2,
    "channel.noise_number": 2,
}

STATES = ("delta", "omega", "e1d", "e1q")
RESULTS = {
    **dict.fromkeys(("plant", "observer", "chosen"), STATES),
    "channel": ("V_t", "t_frame", "P_t"),
}


def split(name: str) -> tuple[str, str]:
    component, _, variable = name.partition(".")
    return component, variable


def of(component: str, values: dict) -> dict:
    """Those of one component, by the names of its variables."""
    return {split(name)[1]: value for name, value in values.items() if split(name)[0] == component}


def main(run: Callable[[Path], dict[str, float]]) -> None:
    """`python -m tests.importers.with_... FOLDER` prints the results at the end of the run as JSON."""
    print("results:", json.dumps(run(Path(sys.argv[1]).resolve())))
