"""python -m scenarios COMMAND: the commands are the modules of scenarios/commands."""

import argparse
import sys
from collections.abc import Mapping

from rich.console import Console

from .commands import Command, all_commands, example_lines
from .errors import UserError

EXIT_CODES = "exit code: 0 all is well, 1 an expectation failed or a check found nonsense, 2 wrong usage or wrong input"
INTERRUPTED = 130
"""Exit code after Ctrl-C, as a shell has it."""


def build_parser(commands: Mapping[str, Command]) -> argparse.ArgumentParser:
    layout = argparse.RawDescriptionHelpFormatter
    examples = example_lines([command.EXAMPLES[0] for command in commands.values()])
    parser = argparse.ArgumentParser(
        prog="python -m scenarios",
        description="Dynamic state observer for generators with a PMU: scenarios to co-simulate, records to observe.",
        epilog=f"examples (from the repository's root):\n{examples}\n\n{EXIT_CODES}",
        formatter_class=layout,
    )
    parsers = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for name, command in commands.items():
        epilog = f"examples:\n{example_lines(command.EXAMPLES)}\n\n{EXIT_CODES}"
        about = command.__doc__
        command.add_arguments(
            parsers.add_parser(name, help=command.HELP, description=about, epilog=epilog, formatter_class=layout)
        )
    return parser


def main(arguments: list[str] | None = None) -> int:
    commands = all_commands()
    chosen = build_parser(commands).parse_args(arguments)
    try:
        return commands[chosen.command].run(chosen, Console())
    except UserError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except OSError as error:
        if error.filename is None:
            raise
        print(f"error: {error.filename}: {error.strerror}", file=sys.stderr)  # no such folder, no right to write
        return 2
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return INTERRUPTED


if __name__ == "__main__":
    sys.exit(main())
