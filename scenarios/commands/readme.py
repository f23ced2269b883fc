"""Write what all runs in results/ have measured into the READMEs here: the tables between markers, and the figures."""

import argparse

from rich.console import Console

from .. import readme, study

HELP = "write what all runs in results/ have measured into the READMEs"
EXAMPLES = [("readme", "tables and figures of the READMEs, from results/")]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    pass


def run(arguments: argparse.Namespace, console: Console) -> int:
    readme.update(study.RESULTS)
    return 0
