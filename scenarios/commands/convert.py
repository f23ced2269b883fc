"""Convert a file of PMU data into a standard record: pu and rad at the PMU, on a whole raster, lost rows marked.

Reads wide CSV (any separator, decimal comma, units rows, blanks), openPDC's long CSV, IEEE/ISO-NE's three header rows,
COMTRADE with phasor channels (extra: field) and standard records. MAP.toml says which columns are which, in what units;
`--guess` writes a first one from the header. See scenarios/records/README.md. At the end the record is checked.
"""

import argparse
from pathlib import Path

from rich.console import Console

from ..errors import UserError
from ..progress import progress_bar

HELP = "convert a file of PMU data into a standard record (kV, A, MW, degrees, UTC to pu and rad)"
EXAMPLES = [
    ("convert day.csv --map map.toml", "writes day_record.csv and checks it"),
    ("convert day.csv --guess", "writes a first map.toml from the header, to mend"),
    ("convert day.csv --map map.toml --machine machines.csv --unit G6 --out g6.csv", "checks it against the machine"),
]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", type=Path, metavar="FILE", help="CSV in any form, or the .cfg or .cff of a COMTRADE")
    parser.add_argument("--map", type=Path, default=Path("map.toml"), help="which columns (default: %(default)s)")
    parser.add_argument("--guess", action="store_true", help="write a first map as --map, and do nothing else")
    parser.add_argument(
        "--machine", type=Path, metavar="CSV", help="machines.csv: its V_n is a base, and for the checks"
    )
    parser.add_argument("--unit", metavar="NAME", help="the machine's name in it")
    parser.add_argument("--out", type=Path, help="the record (default: FILE_record.csv)")
    parser.add_argument("--force", action="store_true", help="write over a file that is there")


def run(arguments: argparse.Namespace, console: Console) -> int:
    from ..machines.table import read_machine
    from ..records import checks, guess, map, report
    from ..records.conversion import convert
    from ..records.readers import open_table

    path = arguments.file
    machine = read_machine(arguments.machine, arguments.unit) if arguments.machine else None
    if arguments.guess:
        new(arguments.map, arguments.force)
        table = open_table(path)
        arguments.map.write_text(guess.guessed(table, path.name), encoding="utf-8")
        console.print(f"{arguments.map}: a first map of {path.name}; mend the lines that are marked", highlight=False)
        return 0
    chosen = map.load(arguments.map)
    out = arguments.out or path.with_name(f"{path.stem}_record.csv")
    new(out, arguments.force)
    if out.resolve() == path.resolve():
        raise UserError(f"{out} is the file itself; give another --out")
    table = map.open_table(chosen, path)
    V_n = 1e3 * machine.V_n if machine and machine.V_n else None
    with progress_bar(console) as progress:
        done = convert(table, chosen, str(arguments.map), out, path.name, V_n, progress)
    report.print_conversion(console, done, out)
    findings = checks.check(done.record, machine, done.raster, done.angles)
    report.print_findings(console, findings)
    return 1 if checks.is_nonsense(findings) else 0


def new(path: Path, force: bool) -> None:
    if path.exists() and not force:
        raise UserError(f"{path} is there already; give another name, or --force to write over it")
