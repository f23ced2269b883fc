"""Read machines from PSS/E's .dyr (and .raw): the observer's machine_model and data, on each machine's own base.

GENROU, GENROE, GENSAL, GENSAE, GENTPJ and GENTPF are read; what cannot be used (GENCLS, converters) is listed with the
reason. MBASE, the stator resistance and the step-up transformer stand in the .raw, joined by bus and id. D becomes pu
torque per rad/s: D/omega_s. The shift of a transformer's vector group (Yd) is in neither: write it into machines.csv.
"""

import argparse
from pathlib import Path

from rich.console import Console

from ..errors import UserError

HELP = "read machine data from PSS/E's .dyr and .raw"
EXAMPLES = [
    ("machine case.dyr --raw case.raw", "lists the machines of a case"),
    ("machine case.dyr --raw case.raw --out machines.csv", "all of them, for observe, check and scenarios"),
    ("machine case.dyr --raw case.raw --bus 35 --id 1 --out g6.ssv", "one, for SSP tools; prints --start-values too"),
]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", type=Path, metavar="FILE.dyr")
    parser.add_argument("--raw", type=Path, metavar="FILE.raw", help="the power flow case: MBASE, Ra, frequency")
    parser.add_argument("--bus", help="only the machines at this bus")
    parser.add_argument("--id", help="only the one of this id")
    parser.add_argument("--S-n", type=float, dest="S_n", metavar="MVA", help="MBASE, where there is no .raw")
    parser.add_argument("--frequency", type=float, metavar="HZ", help="nominal, where the .raw does not tell it")
    parser.add_argument("--out", type=Path, metavar="FILE", help="machines.csv, or NAME.ssv for one machine")
    parser.add_argument("--force", action="store_true", help="write over a file that is there")


def run(arguments: argparse.Namespace, console: Console) -> int:
    from ..machines import psse, ssv
    from ..machines.table import write_machines
    from ..records import report
    from ..records.checks.machine import data

    out = arguments.out
    if out is not None:
        if out.suffix not in (".csv", ".ssv"):
            raise UserError(f"--out {out}: give a .csv (machines.csv), or a .ssv for one machine")
        if out.exists() and not arguments.force:
            raise UserError(f"{out} is there already; give another name, or --force to write over it")
    machines, refused = psse.read(arguments.file, arguments.raw, arguments.S_n, arguments.frequency)
    if arguments.bus or arguments.id:
        machines = psse.chosen(machines, arguments.bus, arguments.id)
        refused = [r for r in refused if str(r.bus) == arguments.bus and arguments.id in (None, r.id)]
    if len(machines) > 1 and arguments.raw is None:
        raise UserError("--S-n is of one machine: choose it with --bus and --id, or give --raw")
    if out is not None and not machines:
        raise UserError(f"there is no usable machine to write into {out}")
    show(console, machines, refused)
    report.print_data(console, [finding for machine in machines for finding in data(machine)])
    if out is not None and out.suffix == ".ssv":
        if len(machines) != 1:
            raise UserError(f"{out} holds one machine, and here are {len(machines)}: choose with --bus and --id")
        ssv.write(machines[0], out)
    elif out is not None:
        write_machines({machine.unit: machine for machine in machines}, out)
    if len(machines) == 1:
        console.print(f"\n--start-values {ssv.start_values(machines[0])}", highlight=False, soft_wrap=True)
    return 0


def show(console: Console, machines: list, refused: list) -> None:
    from rich.table import Table

    from ..report import PLAIN

    if machines:
        table = Table("unit", **PLAIN)
        table.add_column("machine_model", no_wrap=True)
        names = ("S_n", "H", "D", "xd", "xd1", "xq", "xq1", "Td10", "Tq10", "S12")
        for name in names:
            table.add_column(name, justify="right", no_wrap=True)
        for m in machines:
            cells = [f"{m[name]:.4g}" if name in m.parameters else "" for name in names]
            table.add_row(m.unit, str(m.parameters["machine_model"]), *cells)
        console.print(table, highlight=False)
        for note in dict.fromkeys(m.comment for m in machines if m.comment):
            console.print(f"note: {note}", highlight=False)
    groups: dict[tuple[str, str], list[str]] = {}
    for r in refused:
        groups.setdefault((r.model, r.reason), []).append(f"{r.bus} id {r.id}")
    for (model, reason), places in groups.items():
        text = f"not used: {len(places)} {model}: {reason} (bus {', '.join(places)})"
        console.print(text, highlight=False, markup=False, soft_wrap=True)
