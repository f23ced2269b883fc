"""Run scenarios: co-simulate plant and observer FMUs as scenario files (scenarios/*.toml) describe it.

A run builds the FMUs that are missing or stale (dist/), prints the errors and whether the scenario's expectations hold,
and writes a CSV, the figures and summary.json into results/<name>/.
"""

import argparse
from functools import partial

from rich.console import Console

from .. import loader, report, study
from ..progress import progress_bar
from ..scenario import Scenario

HELP = "run scenarios"
EXAMPLES = [
    ("run paper_drem", "one scenario"),
    ("run smib_fault my/other.toml", "several, by name or by file"),
    ("run --fmu native smib_fault", "with no Python in the FMUs (extra: native)"),
]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("names", nargs="+", metavar="NAME", help="a scenario's name (see list), or a .toml file")
    about = "kind of FMU to run; Ieee39Plant has no native one and stays a Python FMU (default: %(default)s)"
    parser.add_argument("--fmu", choices=study.KINDS, default="python", help=about)


def run(arguments: argparse.Namespace, console: Console) -> int:
    held = [run_one(console, one, arguments.fmu) for one in [loader.load(name) for name in arguments.names]]
    return 0 if all(held) else 1


def run_one(console: Console, one: Scenario, kind: str) -> bool:
    folder = study.RESULTS / one.name
    console.rule(f"{one.name}: {one.title}", align="left")
    with progress_bar(console) as progress:
        results, verdicts = study.run(one, folder, progress, kind, partial(console.print, highlight=False))
    report.print_tables(console, results, verdicts)
    console.print(
        f"{float(one.stop):g} s in {one.index(one.stop)} steps took {results.wall_time:.1f} s of wall time; "
        f"see {folder}/\n",
        highlight=False,
    )
    return all(verdict.holds for verdict in verdicts)
