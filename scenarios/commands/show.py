"""Show what scenarios connect to what, without running them."""

import argparse

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from .. import loader, study
from ..plan import Plan, value_text

HELP = "show what scenarios connect to what, without running them"
EXAMPLES = [("show paper_drem", "what is connected to what")]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("names", nargs="+", metavar="NAME", help="a scenario's name (see list), or a .toml file")


def run(arguments: argparse.Namespace, console: Console) -> int:
    for one in [loader.load(name) for name in arguments.names]:
        with study.prepared(one) as plan:
            show(console, plan)
    return 0


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
