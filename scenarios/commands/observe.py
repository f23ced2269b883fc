"""Run the observer FMU over a standard record: rotor angle, speed, E'd, E'q, and what was not recorded of E_f and P_m.

Each frame is taken at its own time (stamped), and each row of the result is the estimate at a frame's time. The record
is checked first: what is nonsense is said, and the exit code is 1. Writes estimate.csv, estimate.png and summary.json.
"""

import argparse
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

from rich.console import Console

from .. import study
from ..progress import progress_bar

HELP = "run the observer over a standard record: rotor angle and its band"
EXAMPLES = [
    ("observe record.csv --machine machines.csv --unit G6", "table, estimate.csv, figure"),
    ("observe record.csv --machine machines.csv --unit G6 --fmu native", "a day of 60 frames/s in a minute or two"),
    ("observe record.csv --machine machines.csv --set tve=0.003 --set field_voltage=estimated", "other parameters"),
]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("record", type=Path, metavar="RECORD", help="a standard record, see convert")
    parser.add_argument("--machine", type=Path, metavar="CSV", required=True, help="machines.csv, see machine")
    parser.add_argument("--unit", metavar="NAME", help="the machine's name in it")
    parser.add_argument("--fmu", choices=study.KINDS, default="python", help="kind of FMU (default: %(default)s)")
    about = "a parameter of the observer, its item by name; may be given several times"
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help=about)
    parser.add_argument("--out", type=Path, metavar="FOLDER", help="default: results/observe_RECORD")


def run(arguments: argparse.Namespace, console: Console) -> int:
    from ..fmu import Fmu
    from ..machines.table import read_machine
    from ..observe import report
    from ..observe.run import given_values, observe
    from ..records import checks
    from ..records.report import print_findings

    machine = read_machine(arguments.machine, arguments.unit)
    given = given_values(arguments.set)
    path = arguments.record
    folder = arguments.out or study.RESULTS / f"observe_{path.stem}"
    fmu_file = study.built("observe", "PmuObserver", arguments.fmu, partial(console.print, highlight=False))
    with TemporaryDirectory() as unpacked, progress_bar(console) as progress:
        found = observe(Fmu(fmu_file, Path(unpacked)), path, machine, given, folder, progress)
    report.print_estimate(console, found.estimate, found.seconds, found.wall)
    if found.findings:
        print_findings(console, found.findings)
    console.print(f"see {folder}/", highlight=False)
    captured = found.estimate.captured is not None
    return 0 if captured and not checks.is_nonsense(found.findings) else 1
