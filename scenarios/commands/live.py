"""Observe the machines of C37.118 streams while they run: a native observer FMU each, as live.toml says.

Estimates go out as a C37.118 stream and as CSV files that rotate; /metrics is for Prometheus. How each stream and each
machine is doing is printed every ten seconds. Ctrl-C or SIGTERM ends it, with everything that was received written.
"""

import argparse
import asyncio
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

from rich.console import Console

from .. import study
from ..errors import UserError
from ..fmu import Fmu
from ..live import operation, settings
from ..live.service import Service

HELP = "observe the machines of C37.118 streams"
EXAMPLES = [
    ("live scenarios/live/ieee39.toml", "the machines of the file, until Ctrl-C"),
    ("live scenarios/live/ieee39.toml --once", "connect, say what is found, and end: 1 if a machine is not tracked"),
    ("live scenarios/live/ieee39.toml --seconds 600", "for ten minutes"),
]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("settings", metavar="LIVE.toml", help="streams, machines and where estimates go")
    parser.add_argument("--once", action="store_true", help="check the settings against the streams, and end")
    parser.add_argument("--seconds", type=float, help="how long (default: until Ctrl-C; with --once: 10)")


def run(arguments: argparse.Namespace, console: Console) -> int:
    given = settings.load(arguments.settings)
    if arguments.seconds is not None and not arguments.seconds > 0:
        raise UserError("--seconds must be positive")
    say = partial(console.print, highlight=False, markup=False)
    if given.fmu in study.KINDS:
        path = study.built("fmu", "PmuObserver", given.fmu, say)
    else:
        path = given.beside(given.fmu)
        if not path.is_file():
            raise UserError(f"{given.path}: fmu = {given.fmu}: there is no such file; known: {', '.join(study.KINDS)}")
    with TemporaryDirectory() as folder:
        service = Service(given, Fmu(path, Path(folder)), say)
        seconds = arguments.seconds or (10.0 if arguments.once else None)
        asyncio.run(operation.operate(service, seconds, arguments.once))
    return 0 if not arguments.once or all(unit.tracked for unit in service.units) else 1
