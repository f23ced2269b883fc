"""The commands of `python -m scenarios`, one a file: adding one is adding a file here.

A command's module has

    HELP       one line: what it does (its docstring is the text of its --help)
    EXAMPLES   pairs of arguments and what they do; the first one is shown by `python -m scenarios --help` too
    add_arguments(parser)
    run(arguments, console) -> exit code      it raises UserError for what the user can mend: one line, exit code 2

What its top imports is in the base installation and quick to import; what an extra brings is imported in `run`.
"""

import argparse
from collections.abc import Sequence
from importlib import import_module
from pkgutil import iter_modules
from typing import Protocol

from rich.console import Console


class Command(Protocol):
    __doc__: str | None
    HELP: str
    EXAMPLES: Sequence[tuple[str, str]]

    def add_arguments(self, parser: argparse.ArgumentParser) -> None: ...

    def run(self, arguments: argparse.Namespace, console: Console) -> int: ...


def all_commands() -> dict[str, Command]:
    """Every command by its name, which is that of its file, in alphabetical order."""
    return {found.name: import_module(f"{__name__}.{found.name}") for found in iter_modules(__path__)}  # type: ignore


WIDEST = 60
"""Characters of an example; what a longer one does stands below it."""


def example_lines(examples: Sequence[tuple[str, str]]) -> str:
    """The examples, each with what it does."""
    pairs = [(f"python -m scenarios {arguments}", what) for arguments, what in examples]
    width = max((len(line) for line, _ in pairs if len(line) <= WIDEST), default=0)
    below = "\n" + 6 * " "
    return "\n".join(f"  {line:{width}}{'  ' if len(line) <= width else below}{what}" for line, what in pairs)
