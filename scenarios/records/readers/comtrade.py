"""COMTRADE with phasor channels (IEEE C37.111): magnitude and angle, or real and imaginary part, as analog channels.

`comtrade` reads it (extra: field), all of it into memory; in double precision, for in single its times have 8 ms after
a day. Channels on the secondary side are brought to the primary one.
"""

import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .. import units
from ..standard import RecordError
from .delimited import TEXT, Form
from .table import Block, Hints
from .wide import distinct, is_unit

TIME = "time"
SUFFIXES = (".cfg", ".cff")
TIME_CODE = re.compile(r"([-+]?)(\d{1,2})(?:h(\d{2}))?")


class ComtradeTable:
    def __init__(self, path: Path):
        record: Any = load(path)
        channels = record.cfg.analog_channels
        names = distinct([channel.name.strip() for channel in channels])
        self.data = {TIME: np.asarray(record.time, dtype=float)}
        self.units = {name: channel.uu.strip() for name, channel in zip(names, channels, strict=True)}
        self.units = {TIME: "s", **{name: unit for name, unit in self.units.items() if is_unit(unit)}}
        for name, channel, values in zip(names, channels, record.analog, strict=True):
            self.data[name] = np.asarray(values, dtype=float) * to_primary(channel, self.units.get(name, "1"))
        for name, values in zip(record.status_channel_ids, record.status, strict=True):
            self.data.setdefault(name.strip(), np.asarray(values, dtype=float))
        self.names = list(self.data)
        time: dict[str, object] = {"column": TIME, "format": "seconds"}
        if record.start_timestamp and record.start_timestamp.year > 1:
            time["start"] = record.start_timestamp.isoformat()
            time["zone"] = zone_of(record.cfg)
        self.hints = Hints(time=time, frequency=record.frequency or None)

    def blocks(self, numbers: Sequence[str], texts: Sequence[str]) -> Iterator[Block]:
        columns = {name: self.data[name] for name in numbers}
        columns |= {name: np.array([b"%d" % int(v) for v in self.data[name]], dtype=TEXT) for name in texts}
        yield Block(columns, 1.0)


def load(path: Path) -> Any:
    try:
        from comtrade import Comtrade
    except ModuleNotFoundError as missing:
        raise RecordError("COMTRADE needs comtrade: pip install '.[field]'") from missing
    record = Comtrade(use_double_precision=True, use_numpy_arrays=True, ignore_warnings=True)
    try:
        record.load(str(path))
    except FileNotFoundError as error:
        raise RecordError(f"{path}: its data file {Path(str(error.filename)).name} is not beside it") from None
    except Exception as error:  # the library raises whatever a wrong line makes it stumble over
        raise RecordError(f"{path} is no COMTRADE that can be read: {error}") from error
    if record.total_samples == 0 or not record.cfg.analog_channels:
        raise RecordError(f"{path} holds {record.total_samples} samples of {record.analog_count} analog channels")
    return record


def to_primary(channel: Any, unit: str) -> float:
    """The ratio of the instrument transformer where the channel is on its secondary side."""
    on_secondary = str(channel.pors).strip().upper() == "S" and float(channel.secondary) > 0
    of_a_transformer = units.unit(unit).quantity in ("voltage", "current")
    return float(channel.primary) / float(channel.secondary) if on_secondary and of_a_transformer else 1.0


def zone_of(cfg: Any) -> str:
    """UTC offset of the stamps, `+05:30`, from the time code of a 2013 file: "-5h30"; the library keeps it private."""
    match = TIME_CODE.fullmatch(str(getattr(cfg, "_time_code", "0")).strip())
    if match is None or int(match[2]) == 0:
        return "UTC"
    return f"{match[1] or '+'}{int(match[2]):02d}:{int(match[3] or 0):02d}"


def recognises(path: Path, form: Form | None) -> bool:
    return path.suffix.lower() in SUFFIXES


def open_table(path: Path, form: Form | None) -> ComtradeTable:
    return ComtradeTable(path)
