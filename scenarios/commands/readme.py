"""Write what all runs in results/ have measured into README.md: the tables between its markers, and the figures."""

import argparse

from rich.console import Console

from .. import readme, study

HELP = "write what all runs in results/ have measured into README.md"
EXAMPLES = [("readme", "the README's tables and figures, from results/")]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    pass


def run(arguments: argparse.Namespace, console: Console) -> int:
    readme.update(study.RESULTS)
    return 0
