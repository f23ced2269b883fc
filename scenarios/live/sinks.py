"""Where estimates go: a C37.118 stream, CSV files that rotate, and text for Prometheus."""

import csv
import time
from collections.abc import Callable, Iterator
from datetime import UTC, datetime
from math import isfinite, nan
from pathlib import Path

from . import settings
from .c37118 import Analog, Configuration, Data, Digital, Measurement, Phasor, Station
from .observer import NAMES, OUTPUTS
from .server import Server
from .service import TIME_BASE, Estimate, Service, Snapshot

NO_DATA, TEST_MODE = 0x4000, 0x8000
"""STAT (Table 7): the frame did not come; values that are not to be used, because status is not 2."""


class Stream:
    """V1 and I1 as they came, the estimates as analogs in the order of OUTPUTS, and status as a digital word.

    The frame is stamped with the time of the estimate, a period after that of the frame it is made of.
    """

    def __init__(self, server: Server):
        self.server = server

    def take(self, snapshot: Snapshot) -> None:
        told = self.server.configuration
        measurements = tuple(map(measurement, snapshot.estimates))
        self.server.send(Data(told.idcode, snapshot.stamp, measurements))


def configuration(given: settings.C37118, service: Service) -> Configuration:
    analogs = tuple(Analog(f"{output.name} {output.unit}"[:16]) for output in OUTPUTS[:-1])
    stations = tuple(
        Station(
            unit.name[:16],
            given.idcode + 1 + place,
            (Phasor("V1"), Phasor("I1", True)),
            analogs,
            (Digital(tuple(f"status bit {bit}" if bit < 2 else "" for bit in range(16)), 0, 3),),
            nominal_frequency=unit.nominal_frequency,
        )
        for place, unit in enumerate(service.units)
    )
    return Configuration(given.idcode, stations, service.rate or 1, TIME_BASE)


def measurement(estimate: Estimate | None) -> Measurement:
    if estimate is None:
        none = complex(nan, nan)
        return Measurement(NO_DATA, (none, none), nan, nan, (nan,) * (len(NAMES) - 1), (0,))
    stat = estimate.stat & 0x3FFF | (0 if estimate.tracking else TEST_MODE)
    phasors = (estimate.V, estimate.I)
    return Measurement(stat, phasors, estimate.frequency, estimate.rocof, estimate.values[:-1], (estimate.status,))


class CsvFiles:
    """A row a machine and time: UTC, unit, the outputs, and what is wrong. A new file every `minutes`; `keep` stay."""

    def __init__(self, given: settings.Csv, folder: Path, service: Service):
        self.given, self.folder, self.service = given, folder, service
        self.period = -1
        self.file = None
        folder.mkdir(parents=True, exist_ok=True)

    def take(self, snapshot: Snapshot) -> None:
        if snapshot.number % self.given.every:
            return
        period = int(snapshot.utc // (60 * self.given.minutes))
        if period != self.period or self.file is None:
            self.rotate(snapshot.utc)
            self.period = period
        when = datetime.fromtimestamp(snapshot.utc, UTC).isoformat(timespec="microseconds")
        for unit, estimate in zip(self.service.units, snapshot.estimates, strict=True):
            if estimate is not None:
                values = [f"{value:.9g}" if isfinite(value) else "" for value in estimate.values]
                self.rows.writerow([when, unit.name, *values, estimate.trouble])

    def rotate(self, utc: float) -> None:
        self.close()
        name = datetime.fromtimestamp(utc, UTC).strftime("estimates_%Y%m%dT%H%M%S.csv")
        self.file = (self.folder / name).open("a", newline="", encoding="utf-8")
        self.rows = csv.writer(self.file)
        if not self.file.tell():
            self.rows.writerow(["time [UTC]", "unit", *(f"{one.name} [{one.unit}]" for one in OUTPUTS), "trouble"])
        for old in sorted(self.folder.glob("estimates_*.csv"))[: -self.given.keep]:
            old.unlink()

    def flush(self) -> None:
        if self.file:
            self.file.flush()

    def close(self) -> None:
        if self.file:
            self.file.close()
            self.file = None


def metrics(service: Service) -> Iterator[str]:
    """The newest estimates and the state of the streams, in Prometheus' text format."""
    yield "# TYPE pmu_analog_value gauge"
    for unit in service.units:
        if unit.latest:
            for output, value in zip(OUTPUTS, unit.latest.values, strict=True):
                if isfinite(value):
                    labels = f'machine="{escaped(unit.name)}",channel="{output.name}",unit="{output.unit}"'
                    yield f"pmu_analog_value{{{labels}}} {value:.9g}"
    for name, kind, read in STREAM_METRICS:
        yield f"# TYPE {name} {kind}"
        for feed in service.feeds:
            yield f'{name}{{stream="{escaped(feed.given.label)}"}} {read(feed):.9g}'


def escaped(label: str) -> str:
    return label.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")


STREAM_METRICS: tuple[tuple[str, str, Callable], ...] = (
    ("pmu_frames_total", "counter", lambda feed: feed.session.counters.frames),
    ("pmu_frames_missing_total", "counter", lambda feed: feed.session.counters.missing),
    ("pmu_connections_total", "counter", lambda feed: feed.session.counters.connections),
    ("pmu_delay_seconds", "gauge", lambda feed: feed.delay),
    ("pmu_backlog_seconds", "gauge", lambda feed: feed.backlog),
    ("pmu_stream_age_seconds", "gauge", lambda feed: time.time() - feed.last_arrival),
)
