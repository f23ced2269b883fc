"""ecos as a program of its own, in C++: with native FMUs there is no Python in the process. It runs an SSP."""

import csv
import os
import shutil
import subprocess
from importlib import metadata
from pathlib import Path
from tempfile import TemporaryDirectory

from fmu_src.models import pmu_observer, smib_plant
from fmu_src.runtime.ssp import System, build

from . import tbb
from .case import FRAME, OBSERVER, PLANT, RESULTS, STARTS, STEPS, H, main

SYSTEM = System(
    name="pair",
    description="plant and observer",
    components={"plant": smib_plant.MODEL, "observer": pmu_observer.MODEL},
    connections={f"observer.{name}": f"plant.{name}" for name in FRAME},
    starts={f"observer.{name}": value for name, value in STARTS.items()},
)


def run(folder: Path) -> dict[str, float]:
    with TemporaryDirectory() as place:
        path = Path(place) / "pair.ssp"
        build(SYSTEM, {"plant": folder / PLANT, "observer": folder / OBSERVER}, path)
        row = simulate(path, STEPS * H, H)
    return {f"{c}.{name}": row[f"{c}::{name}[REAL]"] for c, names in RESULTS.items() for name in names}


def simulate(path: Path, stop_time: float, h: float) -> dict[str, float]:
    """The last row of what ecos records (with six decimals). Raises CalledProcessError if it fails."""
    files = metadata.files("ecospy") or []
    packed = next(str(file.locate()) for file in files if str(file).endswith("binaries/ecos"))
    with TemporaryDirectory() as place:
        program = Path(shutil.copy(packed, place))  # the wheel has it without the permission to run
        program.chmod(0o755)
        command = [str(program), "simulate", "--path", str(path), "--parameterSet", "start"]
        command += ["--stopTime", repr(stop_time), "--stepSize", repr(h)]
        environment = {**os.environ, "LD_LIBRARY_PATH": str(tbb.library().parent)}
        subprocess.run(command, cwd=place, env=environment, check=True, capture_output=True, text=True)
        with (Path(place) / f"{path.stem}.csv").open(encoding="utf-8") as file:
            names, *_, last = csv.reader(file, skipinitialspace=True)
    return {name: float(value) for name, value in zip(names, last, strict=True)}


if __name__ == "__main__":
    main(run)
