"""A standard record a piece at a time: a day of frames is half a GB in memory, and a program needs one piece."""

from collections.abc import Iterator
from pathlib import Path

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
