"""Estimators beside an EKF and a UKF on the same noisy frames: accuracy, capture, cost (extra: bench)."""

import argparse
from time import perf_counter

from rich.console import Console

from .. import study
from ..errors import ScenarioError, alternatives
from ..progress import progress_bar

HELP = "estimators beside an EKF and a UKF on the same noisy frames: accuracy, capture, cost (extra: bench)"
EXAMPLES = [("compare", "robust beside an EKF, a UKF and the paper's, on noisy frames")]

SHOWN = "record_g6"
"""What the README shows."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    about = "what they run on: record_g6, record_g6_6th_order or smib_fault (default: %(default)s)"
    parser.add_argument("name", nargs="?", default=SHOWN, help=about)
    parser.add_argument("--seeds", type=int, default=100, help="noise seeds (default: %(default)s)")


def run(arguments: argparse.Namespace, console: Console) -> int:
    name, seeds = arguments.name, arguments.seeds
    if seeds < 1:
        raise ScenarioError(f"--seeds {seeds}: give at least one seed")
    try:
        from ..compare import comparison, cost, report
    except ModuleNotFoundError as missing:
        raise ScenarioError(f"compare needs {missing.name}: pip install '.[bench]'") from missing
    if name not in comparison.JUDGED:
        raise ScenarioError(f'compare: there is no "{name}"; {alternatives(name, list(comparison.JUDGED))}')
    start = perf_counter()
    folder = study.RESULTS / ("compare" if name == SHOWN else f"compare_{name}")
    with progress_bar(console) as progress:
        found = comparison.compare(name, seeds, progress)
        costs = cost.measure()
    report.print_table(console, found, costs, seeds)
    report.print_verdicts(console, report.verdicts(found, costs))
    report.print_costs(console, costs)
    report.write(found, costs, seeds, folder)
    console.print(f"It took {perf_counter() - start:.0f} s; see {folder}/\n", highlight=False)
    return 0
