"""A standard record a piece at a time: a day of frames is half a GB in memory, and a program needs one piece."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from . import standard
from .readers import delimited
from .readers.wide import distinct
from .standard import COLUMNS, NEEDED, Facts, RecordError, StandardRecord


def facts(path: Path) -> Facts:
    """What the comment lines of a record say."""
    if not path.is_file():
        raise RecordError(f"there is no file {path}")
    return standard.read_facts(delimited.form_of(path, ",", ".").preamble, path)


def pieces(path: Path) -> Iterator[tuple[StandardRecord, float]]:
    """Some 80 000 frames at a time, and the share that has been read. Raises RecordError like `standard.read`."""
    known = facts(path)
    form = delimited.form_of(path, ",", ".")
    names = distinct(form.header[-1])
    missing = [name for name in NEEDED if name not in names]
    if missing:
        raise RecordError(f'{path} has no column "{missing[0]}"; {standard.CONVERT}')
    wanted = [name for name in COLUMNS if name in names]
    last = None
    for block in delimited.blocks(path, form, names, wanted, []):
        record = standard.assemble(block.columns, known, path)
        if last is not None and not record.time[0] > last:
            raise RecordError(f"{path}: time does not increase after {last:.6f} s; {standard.CONVERT}")
        last = record.time[-1]
        yield record, block.done


LARGE = 50_000_000
"""Bytes; a longer file is checked on a sample."""

SOME = 2000
"""Frames of each further piece."""


def sample(path: Path) -> StandardRecord:
    """The record to check: all of it, or of a long file the first piece and SOME frames of each other."""
    if not path.is_file() or path.stat().st_size < LARGE:
        return standard.read(path)
    parts = []
    for record, _ in pieces(path):
        some = slice(SOME if parts else None)
        parts.append({name: getattr(record, name)[some] for name in COLUMNS})
    columns = {name: np.concatenate([part[name] for part in parts]) for name in COLUMNS}
    return standard.assemble(columns, facts(path), path)
