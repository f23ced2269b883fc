"""ecos as a program of its own, in C++: with native FMUs there is no Python in the process. It runs an SSP."""

import csv
import os
import shutil
import subprocess
from importlib import metadata
from pathlib import Path
from tempfile import TemporaryDirectory

from fmu_src.models import pmu_channel, pmu_observer, smib_plant
from fmu_src.runtime.ssp import System, build

from . import tbb
from .case import CONNECTIONS, FMUS, INTEGERS, REALS, RESULTS, STEPS, H, main

SYSTEM = System(
    name="case",
    description="plant, PMU and two observers",
    components={
        "plant": smib_plant.MODEL,
        "channel": pmu_channel.MODEL,
        "observer": pmu_observer.MODEL,
        "chosen": pmu_observer.MODEL,
    },
    connections=CONNECTIONS,
    outputs={},
    sets={"start": {**REALS, **INTEGERS}},
    step_size=H,
)


def run(folder: Path) -> dict[str, float]:
    with TemporaryDirectory() as place:
        path = Path(place) / "case.ssp"
        build(SYSTEM, {name: folder / fmu for name, fmu in FMUS.items()}, path)
        row = simulate(path, STEPS * H, H, "start")[-1]
    return {f"{c}.{name}": row[f"{c}::{name}[REAL]"] for c, names in RESULTS.items() for name in names}


def simulate(path: Path, stop_time: float, h: float, parameter_set: str) -> list[dict[str, float]]:
    """The rows of what ecos records (with six decimals). Raises CalledProcessError if it fails."""
    files = metadata.files("ecospy") or []
    packed = next(str(file.locate()) for file in files if str(file).endswith("binaries/ecos"))
    with TemporaryDirectory() as place:
        program = Path(shutil.copy(packed, place))  # the wheel has it without the permission to run
        program.chmod(0o755)
        command = [str(program), "simulate", "--path", str(path), "--parameterSet", parameter_set]
        command += ["--stopTime", repr(stop_time), "--stepSize", repr(h)]
        environment = {**os.environ, "LD_LIBRARY_PATH": str(tbb.library().parent)}
        subprocess.run(command, cwd=place, env=environment, check=True, capture_output=True, text=True)
        with (Path(place) / f"{path.stem}.csv").open(encoding="utf-8") as file:
            names, *rows = csv.reader(file, skipinitialspace=True)
    return [{name: float(value) for name, value in zip(names, row, strict=True)} for row in rows]


if __name__ == "__main__":
    main(run)
