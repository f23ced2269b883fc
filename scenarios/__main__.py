"""python -m scenarios run NAME... | list | show NAME | readme"""

import argparse
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from time import perf_counter

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from . import loader, readme, report, study
from .errors import ScenarioError, alternatives
from .plan import Plan, value_text
from .scenario import Scenario

RESULTS = Path("results")
COMPARED = "record_g6"
PATIENCE = 2.0
"""s; a run that takes longer shows its progress."""

EPILOG = """\
examples (from the repository's root):
  python -m scenarios list                          what there is
  python -m scenarios show paper_drem               what is connected to what
  python -m scenarios run paper_drem                one scenario
  python -m scenarios run smib_fault my/other.toml  several, by name or by file
  python -m scenarios run --fmu native smib_fault   with no Python in the FMUs (extra: native)
  python -m scenarios compare                       robust beside an EKF, a UKF and the paper's, on noisy frames

A run builds the FMUs that are missing or stale (dist/), prints the errors and whether the scenario's expectations hold,
and writes a CSV, the figures and summary.json into results/<name>/.

exit code: 0 all expectations hold, 1 an expectation failed, 2 wrong usage or a mistake in a scenario
"""


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(
        prog="python -m scenarios",
        description="Co-simulate plant and observer FMUs as a scenario file (scenarios/*.toml) describes it.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    commands.add_parser("list", help="list the scenarios")
    commands.add_parser("readme", help="write what all runs in results/ have measured into README.md")
    for name, text in (("run", "run scenarios"), ("show", "show what scenarios connect to what, without running them")):
        command = commands.add_parser(name, help=text, description=f"{text.capitalize()}.")
        command.add_argument("names", nargs="+", metavar="NAME", help="a scenario's name (see list), or a .toml file")
        if name == "run":
            about = "kind of FMU to run; Ieee39Plant has no native one and stays a Python FMU (default: %(default)s)"
            command.add_argument("--fmu", choices=study.KINDS, default="python", help=about)
    about = "estimators beside an EKF and a UKF on the same noisy frames: accuracy, capture, cost (extra: bench)"
    command = commands.add_parser("compare", help=about, description=f"{about.capitalize()}.")
    command.add_argument(
        "name",
        nargs="?",
        default=COMPARED,
        help="what they run on: record_g6, record_g6_6th_order or smib_fault (default: %(default)s)",
    )
    command.add_argument("--seeds", type=int, default=100, help="noise seeds (default: %(default)s)")
    chosen = parser.parse_args(arguments)
    console = Console()
    try:
        if chosen.command == "list":
            show_list(console)
            return 0
        if chosen.command == "readme":
            readme.update(RESULTS)
            return 0
        if chosen.command == "compare":
            run_comparison(console, chosen.name, chosen.seeds)
            return 0
        scenarios = [loader.load(name) for name in chosen.names]
        if chosen.command == "show":
            for one in scenarios:
                with study.prepared(one) as plan:
                    show(console, plan)
            return 0
        say = partial(console.print, highlight=False)
        held = [run(console, one, chosen.fmu, say) for one in scenarios]
        return 0 if all(held) else 1
    except ScenarioError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2


def run(console: Console, one: Scenario, kind: str, say: Callable[[str], None]) -> bool:
    console.rule(f"{one.name}: {one.title}", align="left")
    with progress_bar(console) as progress:
        results, verdicts = study.run(one, RESULTS / one.name, progress, kind, say)
    report.print_tables(console, results, verdicts)
    console.print(
        f"{float(one.stop):g} s in {one.index(one.stop)} steps took {results.wall_time:.1f} s of wall time; "
        f"see {RESULTS / one.name}/\n",
        highlight=False,
    )
    return all(verdict.holds for verdict in verdicts)


def run_comparison(console: Console, name: str, seeds: int) -> None:
    if seeds < 1:
        raise ScenarioError(f"--seeds {seeds}: give at least one seed")
    try:
        from .compare import comparison, cost
        from .compare import report as compared
    except ModuleNotFoundError as missing:
        raise ScenarioError(f"compare needs {missing.name}: pip install '.[bench]'") from missing
    if name not in comparison.JUDGED:
        raise ScenarioError(f'compare: there is no "{name}"; {alternatives(name, list(comparison.JUDGED))}')
    start = perf_counter()
    folder = RESULTS / ("compare" if name == COMPARED else f"compare_{name}")  # the README shows the first
    with progress_bar(console) as progress:
        found = comparison.compare(name, seeds, progress)
        costs = cost.measure()
    compared.print_table(console, found, costs, seeds)
    compared.print_verdicts(console, compared.verdicts(found, costs))
    compared.print_costs(console, costs)
    compared.write(found, costs, seeds, folder)
    console.print(f"It took {perf_counter() - start:.0f} s; see {folder}/\n", highlight=False)


@contextmanager
def progress_bar(console: Console) -> Iterator:
    """A function of the share that is done; it shows a bar once a run has lasted longer than PATIENCE."""
    columns = (TextColumn("{task.percentage:3.0f} %"), BarColumn(), TimeRemainingColumn())
    start = perf_counter()
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task("", total=1.0, visible=False)

        def progress(done: float) -> None:
            bar.update(task, completed=done, visible=perf_counter() - start > PATIENCE)

        yield progress


def show_list(console: Console) -> None:
    table = Table("name", "title")
    table.add_column("s", justify="right")
    table.add_column("step, s", justify="right")
    for name in loader.names():
        one = loader.load(name)
        table.add_row(name, one.title, value_text(float(one.stop)), str(one.step))
    console.print(table)


def show(console: Console, plan: Plan) -> None:
    one = plan.scenario
    console.rule(f"{one.name}: {one.title}", align="left")
    console.print(" ".join(one.description.split()), "", highlight=False)
    table = Table("instance", "parameters set", "inputs", show_lines=True)
    for instance in plan.instances:
        parameters = [f"{name} = {value_text(value)}" for name, value in instance.parameters.items()]
        inputs = [f"{name} <- {source.instance.label}.{source.variable}" for name, source in instance.links.items()]
        inputs += [f"{name} = {value_text(value)}" for name, value in instance.inputs.items()]
        table.add_row(escape(instance.label), "\n".join(parameters), escape("\n".join(inputs)))
    console.print(table)


if __name__ == "__main__":
    sys.exit(main())
