"""python -m tests.benchmarks [--readme]: what this folder measures, as a table, printed or put into its README.md."""

import argparse
import json
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory

import build_fmu
from fmu_src.runtime import readme

from . import CASES, CYCLES


def run() -> dict:
    """What pytest-benchmark has measured. Raises CalledProcessError if it cannot."""
    with TemporaryDirectory() as folder:
        file = Path(folder) / "benchmarks.json"
        command = [sys.executable, "-m", "pytest", "-q", "-n0", "tests/benchmarks", "--benchmark-only"]
        subprocess.run([*command, f"--benchmark-json={file}"], cwd=build_fmu.ROOT, check=True)
        return json.loads(file.read_text(encoding="utf-8"))


def table(found: dict) -> str:
    """Of every benchmark the fastest round: what else the machine does only makes it slower."""
    fastest = {one["name"]: one["stats"]["min"] for one in found["benchmarks"]}
    rows = ["| a cycle of | from C | times nothing | from FMPy | times nothing |", "|---|---|---|---|---|"]
    for case in CASES:
        kind, what = case.split()
        cells = [f"{kind.capitalize()} FMU: {PROGRAMS[what]}"]
        for host in ("c", "fmpy"):
            own, nothing = (fastest[f"test_from_{host}[{kind} {program}]"] for program in (what, "nothing"))
            cells += [f"{own / CYCLES * 1e6:.3g} us", f"{own / nothing:.3g}"]
        rows.append(f"| {' | '.join(cells)} |")
    return "\n".join([*rows, "", *sentences(fastest, found)])


PROGRAMS = {"nothing": "nothing", "drem": "`drem`", "robust": "`robust`, its bank running"}


def sentences(fastest: dict[str, float], found: dict) -> list[str]:
    size = {one["name"]: one["extra_info"]["kB"] for one in found["benchmarks"] if one["extra_info"]}
    python, native = "test_build[python]", "test_build[native]"
    threads = {n: fastest["test_threads[1]"] / fastest[f"test_threads[{n}]"] for n in (2, 8)}
    cpu = found["machine_info"]["cpu"]
    ratios = [
        f"{fastest[f'test_from_c[python {what}]'] / fastest[f'test_from_c[native {what}]']:.0f} times with `{what}`"
        for what in ("robust", "drem")
    ]
    return [
        f"From C, the native FMU is faster than the Python FMU {', and '.join(ratios)}.",
        f"8 native instances are {threads[2]:.2f} times as fast on 2 threads as on one, {threads[8]:.2f} times on 8.",
        f"`python build_fmu.py` takes {fastest[python]:.0f} s, `--native` {fastest[native]:.0f} s (at first, minutes).",
        f"PmuObserver.fmu has {size[native]:.0f} kB, as a Python FMU {size[python]:.0f} kB.",
        f"Measured on {cpu['count']} cores of an {cpu['brand_raw']}.",
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--readme", action="store_true", help="write the table into tests/benchmarks/README.md")
    arguments = parser.parse_args()
    if find_spec("pytest_benchmark") is None:
        parser.error("pytest-benchmark is not installed: pip install '.[test,bench]'")
    text = table(run())
    if arguments.readme:
        readme.write(Path(__file__).with_name("README.md"), "benchmarks", text)
    else:
        print(text)


if __name__ == "__main__":
    main()
