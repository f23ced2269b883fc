"""Readers, one format a file: a new one is a module with `recognises` and `open_table`, and its line in READERS."""

from pathlib import Path
from typing import Any

from ...errors import alternatives
from ..standard import RecordError
from . import comtrade, delimited, ieee, openpdc, project, wide
from .table import Block, Hints, Table

__all__ = ["READERS", "Block", "Hints", "Table", "open_table"]

READERS: dict[str, Any] = {
    "comtrade": comtrade,
    "openpdc": openpdc,
    "ieee": ieee,
    "record": project,
    "wide": wide,
}
"""By the name that a MAP gives them; the first that recognises a file reads it."""


def open_table(
    path: Path, format: str | None = None, separator: str | None = None, decimal: str | None = None
) -> Table:
    """The table in a file; what is not given is told from the file. Raises RecordError."""
    if not path.is_file():
        raise RecordError(f"there is no file {path}")
    if format is not None and format not in READERS:
        raise RecordError(f'format "{format}" is not known; {alternatives(format, list(READERS))}')
    if path.suffix.lower() == ".dat" and path.with_suffix(".cfg").is_file():
        raise RecordError(f"{path} is the data of a COMTRADE; give {path.with_suffix('.cfg')}")
    is_comtrade = comtrade.recognises(path, None) if format is None else format == "comtrade"
    form = None if is_comtrade else delimited.form_of(path, separator, decimal)
    if format is not None:
        return READERS[format].open_table(path, form)
    return next(reader for reader in READERS.values() if reader.recognises(path, form)).open_table(path, form)
