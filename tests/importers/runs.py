"""The importers, each in a process of its own: one that crashes takes nothing else down."""

import json
import subprocess
import sys
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]


class Importer(NamedTuple):
    name: str
    module: str
    package: str  # on PyPI
    host: str
    tolerance: float  # of its results to those of FMPy: what its own records keep of a number


IMPORTERS = (
    Importer("FMPy", "with_fmpy", "fmpy", "Python", 0.0),
    Importer("fmuloader", "with_fmuloader", "fmuloader", "Python", 0.0),
    Importer("libcosim (libcosimpy)", "with_libcosim", "libcosimpy", "C++ in Python", 0.0),
    Importer("ecos (ecospy)", "with_ecospy", "ecospy", "C++ in Python", 0.0),
    Importer("ecos, the program", "with_ecos", "ecospy", "C++", 1e-6),
)


def missing(importer: Importer) -> str:
    """Why the importer cannot be run here, or nothing."""
    needed = [importer.package, *(["tbb"] if importer.package == "ecospy" else [])]
    absent = [name for name in needed if not any(True for _ in metadata.distributions(name=name))]
    return f"{', '.join(absent)} cannot be had here" if absent else ""


def version(importer: Importer) -> str:
    return "" if missing(importer) else metadata.version(importer.package)


@cache
def results(importer: Importer, folder: Path) -> dict[str, float]:
    """What the importer has at the end of the run. Raises RuntimeError with its last words if it fails."""
    command = [sys.executable, "-m", f"tests.importers.{importer.module}", str(folder)]
    process = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=120, check=False)
    found = [line for line in process.stdout.splitlines() if line.startswith("results:")]
    if process.returncode != 0 or not found:
        raise RuntimeError(f"{importer.name}: {(process.stderr.strip() or 'it crashed').splitlines()[-1]}")
    return json.loads(found[0].removeprefix("results:"))


def difference(importer: Importer, folder: Path) -> float:
    """The largest difference of its results from FMPy's; which instant the channel shows is up to the importer."""
    own, reference = results(importer, folder), results(IMPORTERS[0], folder)
    return max(abs(own[name] - value) for name, value in reference.items() if not name.startswith("channel."))


def verdict(importer: Importer, folder: Path, kind: str) -> str:
    """The cell of the table."""
    if missing(importer):
        return missing(importer)
    try:
        return "yes" if difference(importer, folder / kind) <= importer.tolerance else "other results"
    except RuntimeError:
        return "no"
