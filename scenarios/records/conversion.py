"""A file into a standard record, a block at a time: whatever its size, some hundred MB of memory are enough."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from . import times
from .angles import AngleRange
from .map import Map
from .quantities import Conversion, bind
from .raster import Raster
from .readers import Table
from .standard import COLUMNS, Facts, RecordError, StandardRecord, Writer, assemble

WHOLE = 100_000
"""Frames; a record up to this size is checked as a whole, of a longer one SOME frames of each block."""
SOME = 2000

EPOCH = 1e9
"""s since 1970, that is 2001; smaller stamps are no UTC."""


@dataclass
class Converted:
    """What a conversion has met, and the frames to check."""

    raster: Raster
    facts: Facts
    columns: list[str]
    sample: list[dict[str, np.ndarray]] = field(default_factory=list)
    broken: int = 0
    """Rows that could not be read."""
    unusable: int = 0
    """Frames with a time, but without a good value."""
    angles: AngleRange = field(default_factory=AngleRange)

    @property
    def record(self) -> StandardRecord:
        """The frames to check."""
        columns = {name: np.concatenate([piece[name] for piece in self.sample]) for name in self.sample[0]}
        return assemble(columns, self.facts)


def convert(
    table: Table,
    map: Map,
    where: str,
    out: Path,
    source: str,
    V_n: float | None = None,
    progress: Callable[[float], None] = lambda done: None,
) -> Converted:
    """Write the standard record of a table as `out`. Raises MapError and RecordError; then nothing is written.

    `where` is the map's name, `source` the file's, V_n the machine's rated voltage in V line-line.
    """
    conversion = bind(map, table, where, V_n)
    pieces = placed(table, conversion, progress)
    try:
        first, done = next(pieces)
    except StopIteration:
        raise RecordError(f"{source} has no rows") from None
    raster = done.raster
    done.facts = facts_of(conversion, raster, source)
    done.columns = [name for name in COLUMNS if name in first]
    kept = 0
    with Writer(out, done.facts, done.columns) as writer:
        while True:
            writer.write(first)
            some = slice(None) if kept < WHOLE else slice(SOME)
            done.sample.append({name: column[some].copy() for name, column in first.items()})
            kept += len(done.sample[-1]["time"])
            piece = next(pieces, None)
            if piece is None:
                break
            first, _ = piece
        if raster.frames - done.unusable < 2:
            raise RecordError(f"{source}: no frame is usable; see {where}: {', '.join(conversion.numbers)}")
    return done


def in_memory(table: Table, map: Map, where: str) -> StandardRecord:
    """The standard record of a table, not written. Raises MapError and RecordError."""
    conversion = bind(map, table, where)
    pieces = list(placed(table, conversion, lambda done: None))
    if not pieces:
        raise RecordError(f"no row can be read by {where}")
    rows, done = [rows for rows, _ in pieces], pieces[0][1]
    columns = {name: np.concatenate([piece[name] for piece in rows]) for name in rows[0]}
    return assemble(columns, facts_of(conversion, done.raster, where))


def placed(
    table: Table, conversion: Conversion, progress: Callable[[float], None]
) -> Iterator[tuple[dict[str, np.ndarray], Converted]]:
    """Blocks of rows on the raster, each with what has been met so far."""
    done: Converted | None = None
    broken = 0
    for block in table.blocks(conversion.numbers, conversion.texts):
        broken += block.broken
        if done is not None:
            done.broken = broken
        if len(block) == 0:
            continue
        ns = conversion.stamps(block.columns)
        if done is None:
            raster = Raster.learnt(ns, conversion.map.rate)
            done = Converted(raster, Facts(), [])
        values = conversion.values(block.columns)
        done.angles = done.angles.widened(conversion.angles(block.columns))
        rows, count = done.raster.place(ns, values)
        done.broken = broken
        if count:
            rows["frame_valid"] = np.nan_to_num(rows["frame_valid"])
            done.unusable += int(np.sum(values["frame_valid"] == 0))
            yield rows, done
        progress(block.done)


def facts_of(conversion: Conversion, raster: Raster, source: str) -> Facts:
    start = raster.start
    return Facts(
        S_base=conversion.S_base / 1e6,
        rate=raster.rate,
        f0=None if np.isnan(conversion.f0) else conversion.f0,
        V_base=conversion.V_base and conversion.V_base / 1e3,
        utc_start=times.utc_text(start) if start > EPOCH * times.SECOND else None,
        source=source,
    )
