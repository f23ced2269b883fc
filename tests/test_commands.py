"""The commands of `python -m scenarios`: each is a file that teaches, and what a user gets wrong is one line."""

import shlex
import sys
from types import ModuleType

import pytest

from scenarios import commands
from scenarios.__main__ import build_parser, main
from scenarios.errors import UserError

EXAMPLES = [example for command in commands.all_commands().values() for example, _ in command.EXAMPLES]


@pytest.mark.parametrize("example", EXAMPLES)
def test_an_example_of_the_help_is_right_usage(example):
    build_parser(commands.all_commands()).parse_args(shlex.split(example))


@pytest.mark.parametrize("name", commands.all_commands())
def test_help_teaches(name, capsys):
    with pytest.raises(SystemExit) as exit_:
        main([name, "--help"])
    shown = capsys.readouterr().out
    assert exit_.value.code == 0
    assert f"usage: python -m scenarios {name}" in shown and "examples:" in shown and "exit code:" in shown


def test_a_new_file_is_a_new_command(monkeypatch, tmp_path, capsys):
    (tmp_path / "greet.py").write_text(
        "HELP = 'greet'\nEXAMPLES = [('greet you', 'hello')]\n"
        "def add_arguments(parser): parser.add_argument('whom')\n"
        "def run(arguments, console): print('hello', arguments.whom); return 7\n"
    )
    monkeypatch.setattr(commands, "__path__", [*commands.__path__, str(tmp_path)])
    assert main(["greet", "you"]) == 7
    assert capsys.readouterr().out == "hello you\n"
    sys.modules.pop("scenarios.commands.greet")


@pytest.mark.parametrize(
    ("raised", "said", "code"),
    [
        (UserError("no such unit"), "error: no such unit\n", 2),
        (PermissionError(13, "Permission denied", "out.csv"), "error: out.csv: Permission denied\n", 2),
        (KeyboardInterrupt(), "interrupted\n", 130),
    ],
)
def test_what_a_command_raises_is_one_line(raised, said, code, monkeypatch, capsys):
    def run(arguments, console):
        raise raised

    broken = ModuleType("broken", "Break.")
    broken.__dict__.update(HELP="break", EXAMPLES=[("broken", "it breaks")], add_arguments=lambda parser: None, run=run)
    monkeypatch.setattr("scenarios.__main__.all_commands", lambda: {"broken": broken})
    assert main(["broken"]) == code
    assert capsys.readouterr().err == said
