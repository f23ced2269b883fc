"""List the scenarios: their names, what they show, how long they run and in which steps."""

import argparse

from rich.console import Console
from rich.table import Table

from .. import loader
from ..plan import value_text

HELP = "list the scenarios"
EXAMPLES = [("list", "what there is")]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    pass


def run(arguments: argparse.Namespace, console: Console) -> int:
    table = Table("name", "title")
    table.add_column("s", justify="right")
    table.add_column("step, s", justify="right")
    for name in loader.names():
        one = loader.load(name)
        table.add_row(name, one.title, value_text(float(one.stop)), str(one.step))
    console.print(table)
    return 0
