"""PSS/E's dynamics data, .dyr: a record is `bus 'MODEL' id constants /`, over as many lines as it takes.

It ends at `/` anywhere; the rest of that line is a comment. Blanks or commas separate, an empty field is the default,
quotes are optional. `bus 'USRMDL' id 'MODEL' IC IT NI NC NS NV`, and NI whole numbers, stand before a user's model's
constants. Between records, lines that begin with no number are skipped.
Siemens PTI, "PSS/E Program Operation Manual", DYRE.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from .table import MachineError

TOKEN = re.compile(r"'([^']*)'|\"([^\"]*)\"|([^\s,'\"]+)|(,)")
USER_MODEL = 6
"""Numbers behind the name of a user's model: IC, IT, NI, NC, NS, NV."""


@dataclass(frozen=True)
class DyrRecord:
    bus: int
    model: str
    """In capitals."""
    id: str
    constants: tuple[float | None, ...]
    """None: an empty field, the default."""
    line: int
    """Of the file, from 1 on; where the record begins."""


def read(path: Path) -> list[DyrRecord]:
    """All records of a file. Raises MachineError with file, line and record for what is broken."""
    if not path.is_file():
        raise MachineError(f"there is no file {path}")
    text = path.read_bytes()
    if b"\0" in text:
        raise MachineError(f"{path} is no text")
    return [parsed(path, line, tokens) for line, tokens in records(path, text.decode("utf-8-sig", "replace"))]


def records(path: Path, text: str) -> Iterator[tuple[int, list[str | None]]]:
    """The tokens of each record, and the line where it begins; None is an empty field."""
    tokens: list[str | None] = []
    begin = 0
    for number, line in enumerate(text.splitlines(), 1):
        content, slash, _ = before_slash(line)
        if not tokens and not begins(content):
            continue
        if not tokens:
            begin = number
        tokens += fields(content)
        if slash:
            yield begin, tokens
            tokens = []
    if tokens:
        raise MachineError(f"{path}, line {begin}: the record {shown(tokens)} has no / at its end")


def before_slash(line: str) -> tuple[str, bool, str]:
    """What stands before the first / that is not in quotes."""
    quote = ""
    for place, character in enumerate(line):
        if quote:
            quote = "" if character == quote else quote
        elif character in "'\"":
            quote = character
        elif character == "/":
            return line[:place], True, line[place + 1 :]
    return line, False, ""


def begins(content: str) -> bool:
    """A record begins with the number of a bus, and something behind it."""
    return re.match(r"\s*-?\d+[\s,]+\S", content) is not None


def fields(content: str) -> list[str | None]:
    found: list[str | None] = []
    after_comma = False
    for match in TOKEN.finditer(content):
        single, double, bare, comma = match.groups()
        if comma:
            if after_comma:
                found.append(None)
            after_comma = True
            continue
        found.append(next(part for part in (single, double, bare) if part is not None).strip())
        after_comma = False
    return found


def parsed(path: Path, line: int, tokens: list[str | None]) -> DyrRecord:
    where = f"{path}, line {line}: the record {shown(tokens)}"
    if len(tokens) < 3 or not tokens[1]:
        raise MachineError(f"{where} is not bus, 'model', id and constants")
    try:
        bus = int(tokens[0] or "")
    except ValueError:
        raise MachineError(f"{where} does not begin with the number of a bus") from None
    model, identifier, rest = tokens[1].upper(), tokens[2] or "1", tokens[3:]
    if model == "USRMDL":
        model, rest = user_model(where, rest)
    constants = []
    for token in rest:
        try:
            constants.append(None if token is None else float(token.replace("D", "E").replace("d", "e")))
        except ValueError:
            if not is_machine(model):  # other models have names and buses among their constants
                break
            raise MachineError(f'{where}: "{token}" is no number') from None
    return DyrRecord(bus, model, identifier, tuple(constants), line)


def is_machine(model: str) -> bool:
    return model.startswith("GEN")


def user_model(where: str, rest: list[str | None]) -> tuple[str, list[str | None]]:
    """The name of a user's model, and its constants."""
    try:
        integers = int(rest[3] or "0")
        return (rest[0] or "").upper(), rest[1 + USER_MODEL + integers :]
    except (IndexError, ValueError):
        raise MachineError(f"{where} is not USRMDL id 'model' IC IT NI NC NS NV and constants") from None


def shown(tokens: list[str | None]) -> str:
    return '"' + " ".join(token or "," for token in tokens[:4]) + ' ..."'
