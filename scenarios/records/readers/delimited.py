"""Text tables of any separator: what separates, which row names the columns, and numbers by the block.

NumPy's reader takes whole blocks; where a cell is no number (blank, "Bad Input") that block is read cell by cell.
"""

import csv
import re
import warnings
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..standard import RecordError
from .table import Block

BLOCK = 1 << 23
"""Bytes read at once: some 80 000 rows."""

HEAD = 1 << 16
"""Bytes that the form of a file is told from."""

SEPARATORS = (",", ";", "\t", "|")
NUMBER = re.compile(r"[-+]?(\d+([.,]\d*)?|[.,]\d+)([eE][-+]?\d+)?")
CLOCK = re.compile(r"\d{1,4}[-/.]\d{1,2}[-/.]\d{1,4}([T ].*)?|\d{1,2}:\d{2}(:\d{2}([.,]\d+)?)?.*")
TEXT = "S48"
"""Of a time stamp or a quality word."""


@dataclass(frozen=True)
class Form:
    """How a text table is written."""

    separator: str
    decimal: str
    encoding: str
    header: list[list[str]]
    """Rows of cells before the data that are as wide as the data: names, perhaps types and units."""
    preamble: list[str]
    """Lines before those."""
    skip: int
    """Lines before the data."""


def form_of(path: Path, separator: str | None = None, decimal: str | None = None) -> Form:
    """The form of a file, told from its first lines; what is given is not guessed. Raises RecordError."""
    with path.open("rb") as file:
        raw = file.read(HEAD)
    encoding = encoding_of(raw, path)
    text = raw.decode(encoding, errors="ignore")
    lines = text.splitlines()
    if len(raw) == HEAD and len(lines) > 1:
        lines = lines[:-1]  # cut off in the middle
    if not any(line.strip() for line in lines):
        raise RecordError(f"{path} is empty")
    separator = separator or separator_of(lines)
    rows = [row_of(line, separator) for line in lines]
    body = [row for row in rows if is_data(row)]
    if not body:
        raise RecordError(f"{path} has no rows of numbers; is it a table of text with a header?")
    width = Counter(len(row) for row in body).most_common(1)[0][0]
    skip = next(i for i, row in enumerate(rows) if is_data(row) and len(row) == width)
    first = skip
    while first > 0 and (is_header(rows[first - 1], width) and not lines[first - 1].lstrip().startswith("#")):
        first -= 1
    if first == skip:
        raise RecordError(f"{path} has no header: give each column a name in its first row")
    decimal = decimal or decimal_of(body, separator)
    header = [[cell.strip() for cell in row[:width]] + [""] * (width - len(row)) for row in rows[first:skip]]
    return Form(separator, decimal, encoding, header, lines[:first], skip)


def encoding_of(raw: bytes, path: Path) -> str:
    if raw.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise RecordError(f"{path} is UTF-16 text; save it as UTF-8 (in Excel: CSV UTF-8)")
    if b"\0" in raw:
        raise RecordError(f"{path} is no text; COMTRADE is read by its .cfg file, Excel's .xlsx is saved as CSV first")
    try:
        raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        return "cp1252" if error.start < len(raw) - 4 else "utf-8-sig"
    return "utf-8-sig"


def row_of(line: str, separator: str) -> list[str]:
    return next(csv.reader([line], delimiter=separator, skipinitialspace=True), [])


def separator_of(lines: Sequence[str]) -> str:
    """The one that gives the last lines most cells of numbers and times; a decimal comma gives none of its own."""
    last = [line for line in lines if line.strip()][-20:]

    def score(separator: str) -> tuple[int, int]:
        rows = [row_of(line, separator) for line in last]
        return min(len(row) for row in rows) > 1, sum(is_value(cell) for row in rows for cell in row)

    if score(";")[0] and all(len(row_of(line, ";")) == len(row_of(last[-1], ";")) for line in last):
        return ";"
    return max(SEPARATORS, key=score)


def is_value(cell: str) -> bool:
    cell = cell.strip()
    return bool(NUMBER.fullmatch(cell) or CLOCK.fullmatch(cell))


def is_data(row: Sequence[str]) -> bool:
    """Half of a data row's cells at least are numbers or times; so is a blank one (a dropout), if not all are."""
    filled = [cell for cell in row if cell.strip()]
    return len(row) > 1 and bool(filled) and 2 * sum(map(is_value, filled)) >= len(filled)


def is_header(row: Sequence[str], width: int) -> bool:
    """As wide as the data, but for what stands empty at its end."""
    filled = [cell for cell in row if cell.strip()]
    return len(filled) > 1 and len(row) <= width + 1 and len(filled) > width / 2


def decimal_of(body: Sequence[Sequence[str]], separator: str) -> str:
    """A comma where cells have one and no point, and it does not separate."""
    cells = [cell.strip() for row in body for cell in row if NUMBER.fullmatch(cell.strip())]
    return "," if separator != "," and any("," in cell for cell in cells) else "."


def blocks(
    path: Path, form: Form, names: Sequence[str], numbers: Sequence[str], texts: Sequence[str]
) -> Iterator[Block]:
    """The wanted columns of a text table, a block at a time. Raises RecordError for a column that holds no number."""
    wanted = list(dict.fromkeys([*texts, *numbers]))
    places = [names.index(name) for name in wanted]
    dtype = np.dtype([(f"c{i}", TEXT if name in texts else float) for i, name in enumerate(wanted)])
    size = path.stat().st_size
    with path.open("rb") as file:
        for _ in range(form.skip):
            file.readline()
        rest = b""
        while True:
            raw = file.read(BLOCK)
            part, rest = cut(rest + raw, at_end=not raw)
            if part.strip():
                rows, broken = rows_of(part.decode(form.encoding.removesuffix("-sig")), form, places, dtype)
                columns = {name: rows[f"c{i}"] for i, name in enumerate(wanted)}
                yield Block(columns, file.tell() / size, broken)
            if not raw:
                return


def cut(raw: bytes, at_end: bool) -> tuple[bytes, bytes]:
    """Whole lines, and the beginning of the next."""
    if at_end:
        return raw, b""
    end = raw.rfind(b"\n") + 1
    return raw[:end], raw[end:]


def rows_of(text: str, form: Form, places: Sequence[int], dtype: np.dtype) -> tuple[np.ndarray, int]:
    """The wanted cells of some lines as a structured array, and how many lines were no rows."""
    decimal_comma = form.decimal == ","
    plain = text.replace(",", ".") if decimal_comma else text
    s = form.separator
    if s + s in plain or s + "\n" in plain or s + "\r" in plain or "\n" + s in plain:  # blanks
        e = re.escape(s)
        plain = re.sub(rf"(?<={e})(?=[{e}\r\n])|^(?={e})|(?<={e})$", "nan", plain, flags=re.MULTILINE)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", DeprecationWarning)
            return (
                np.loadtxt(
                    plain.splitlines(),
                    delimiter=s,
                    dtype=dtype,
                    usecols=places,
                    quotechar='"',
                    comments=None,
                    ndmin=1,
                ),
                0,
            )
    except (ValueError, DeprecationWarning):
        return cell_by_cell(text, form, places, dtype)


def cell_by_cell(text: str, form: Form, places: Sequence[int], dtype: np.dtype) -> tuple[np.ndarray, int]:
    last = max(places)
    rows, broken = [], 0
    floats = [dtype[i].kind == "f" for i in range(len(places))]
    for row in csv.reader(text.splitlines(), delimiter=form.separator, skipinitialspace=True):
        if len(row) > last:
            rows.append(
                tuple(number(row[p], form.decimal) if f else row[p] for p, f in zip(places, floats, strict=True))
            )
        elif any(cell.strip() for cell in row):
            broken += 1
    return np.array([tuple(encoded(cell) for cell in row) for row in rows], dtype=dtype), broken


def encoded(cell: float | str) -> float | bytes:
    return cell.strip().encode("utf-8") if isinstance(cell, str) else cell


def number(cell: str, decimal: str) -> float:
    """nan for what is no number."""
    try:
        return float(cell.replace(",", ".") if decimal == "," else cell)
    except ValueError:
        return np.nan
