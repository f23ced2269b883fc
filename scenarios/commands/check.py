"""Check a standard record: does it fulfil what that of a generator fulfils? Each finding names the likely mistake.

Without --machine the checks that need the rating, the reactances or the nominal speed are left out. What no single
record can show, whatever the checks say: both phasors of one wrong phase, a transformer's shift that is forgotten on
both, a current that is a frame late.
"""

import argparse
import json
from pathlib import Path

from rich.console import Console

HELP = "check a standard record, and name what is likely wrong with it"
EXAMPLES = [
    ("check record.csv", "units, signs, angles, times"),
    ("check record.csv --machine machines.csv --unit G6", "and bases, powers and fields of this machine"),
    ("check record.csv --json", "for a program; exit code 1 on nonsense"),
]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("record", type=Path, metavar="RECORD", help="a standard record, see convert")
    parser.add_argument("--machine", type=Path, metavar="CSV", help="machines.csv")
    parser.add_argument("--unit", metavar="NAME", help="the machine's name in it")
    parser.add_argument("--json", action="store_true", help="write JSON")


def run(arguments: argparse.Namespace, console: Console) -> int:
    from ..machines.table import read_machine
    from ..records import checks, report, streaming

    machine = read_machine(arguments.machine, arguments.unit) if arguments.machine else None
    findings = checks.check(streaming.sample(arguments.record), machine)
    nonsense = checks.is_nonsense(findings)
    if arguments.json:
        found = {"record": str(arguments.record), "nonsense": nonsense, "findings": report.as_json(findings)}
        print(json.dumps(found, indent=2))
    else:
        report.print_findings(console, findings)
    return 1 if nonsense else 0
