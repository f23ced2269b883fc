"""Long CSV of openPDC: a row a value. CsvExporter writes `Timestamp,ID,Value`, CsvOutputAdapter `Signal ID,Measurement
Key,Timestamp,Value`; the stamps are `yyyy-MM-dd HH:mm:ss.fffffff`, UTC.

The columns of the table are the IDs; the values of one time stand together.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from ..standard import RecordError
from . import delimited
from .table import Block, Hints

TIMESTAMP, VALUE = "Timestamp", "Value"
IDENTIFIERS = ("Measurement Key", "Point Tag", "PointTag", "ID", "Signal ID", "SignalID", "PointID")
"""Columns that name a signal; the first that there is counts."""

LOOKED_AT = 20_000
"""Rows in which every signal has come."""

MOST_BACKWARD = 0.01
"""Of the times; more means that the rows of one time do not stand together."""


class OpenPdcTable:
    def __init__(self, path: Path, form: delimited.Form):
        self.path, self.form = path, form
        self.cells = [cell.strip() for cell in form.header[-1]]
        self.identifier = next(name for name in IDENTIFIERS if name in self.cells)
        first = next(self._rows(), None)
        keys = [] if first is None else [key.decode() for key in np.unique(first[self.identifier][:LOOKED_AT])]
        self.names = [TIMESTAMP, *keys]
        self.units: dict[str, str] = {}
        self.hints = Hints(time={"column": TIMESTAMP, "format": "iso", "zone": "UTC"})

    def _rows(self) -> Iterator[dict]:
        wanted = delimited.blocks(self.path, self.form, self.cells, [VALUE], [TIMESTAMP, self.identifier])
        for block in wanted:
            yield {**block.columns, "done": block.done, "broken": block.broken}

    def blocks(self, numbers: Sequence[str], texts: Sequence[str]) -> Iterator[Block]:
        """A row for each time, nan where a signal has no value. The last time of a block waits for the next one."""
        keys = np.array(sorted(name.encode() for name in {*numbers, *texts} - {TIMESTAMP}))
        held: dict | None = None
        for rows in self._rows():
            if held is not None:
                rows = {**rows, **{n: np.concatenate([held[n], rows[n]]) for n in (TIMESTAMP, self.identifier, VALUE)}}
            last = rows["done"] >= 1
            waits = rows[TIMESTAMP] == rows[TIMESTAMP][-1]
            if not last and not waits.all():
                names = (TIMESTAMP, self.identifier, VALUE)
                held = {name: rows[name][waits] for name in names}
                rows = {**rows, **{name: rows[name][~waits] for name in names}}
            else:
                held = None
            yield self._pivot(rows, keys, texts)

    def _pivot(self, rows: dict, keys: np.ndarray, texts: Sequence[str]) -> Block:
        stamps, identifiers, values = rows[TIMESTAMP], rows[self.identifier], rows[VALUE]
        new = np.concatenate([[True], stamps[1:] != stamps[:-1]])
        times = stamps[new]
        if len(times) > 10 and np.mean(times[1:] < times[:-1]) > MOST_BACKWARD:
            raise RecordError(f"{self.path}: the values of one time do not stand together; sort the rows by Timestamp")
        row = np.cumsum(new) - 1
        place = np.searchsorted(keys, identifiers)
        place[place == len(keys)] = 0
        known = keys[place] == identifiers if len(keys) else np.zeros(len(row), dtype=bool)
        table = np.full((len(keys), len(times)), np.nan)
        table[place[known], row[known]] = values[known]
        columns = {key.decode(): table[i] for i, key in enumerate(keys)}
        columns = {name: as_text(v) if name in texts else v for name, v in columns.items()}
        return Block({TIMESTAMP: times, **columns}, rows["done"], rows["broken"])


def as_text(values: np.ndarray) -> np.ndarray:
    """Whole numbers, such as a STAT word, as text."""
    return np.array([b"" if np.isnan(v) else b"%d" % int(v) for v in values], dtype=delimited.TEXT)


def recognises(path: Path, form: delimited.Form | None) -> bool:
    if form is None:
        return False
    cells = [cell.strip() for cell in form.header[-1]]
    return {TIMESTAMP, VALUE} <= set(cells) and any(name in cells for name in IDENTIFIERS) and len(cells) <= 5


def open_table(path: Path, form: delimited.Form) -> OpenPdcTable:
    return OpenPdcTable(path, form)
