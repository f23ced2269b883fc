"""What every importer runs: plant and observer of the paper's case; outputs are exchanged, then both are stepped."""

import json
import sys
from pathlib import Path
from typing import Callable

H = 1 / 64
"""s; a whole number of nanoseconds, in which some importers count."""

STEPS = 128

PLANT, OBSERVER = "SmibPlant.fmu", "PmuObserver.fmu"
FRAME = ("V_t", "theta_t", "I_t", "phi_t", "P_t", "Q_t")
STARTS = {"P_m": 0.1, "E_f": 0.1}  # of the observer's inputs; the plant has them by itself
RESULTS = {"plant": ("delta", "omega", "e1d", "e1q"), "observer": ("delta", "omega", "e1d", "e1q")}


def main(run: Callable[[Path], dict[str, float]]) -> None:
    """`python -m tests.importers.with_... FOLDER` prints the results at the end of the run as JSON."""
    print("results:", json.dumps(run(Path(sys.argv[1]).resolve())))
