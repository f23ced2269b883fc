"""Frames on a whole raster: every period of the frame rate has its row, and one without a frame is marked lost.

A PMU takes its frames on the raster of the UTC second (IEEE C37.118.1), so that a stamp that is only rounded (to ms, to
100 ns) is put back on it. Stamps that are spread by more than a tenth of a period are no such stamps, and are kept.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from . import times
from .standard import RecordError

USUAL_RATES = (
    1,
    2,
    4,
    5,
    6,
    10,
    12,
    12.5,
    15,
    20,
    24,
    25,
    30,
    40,
    48,
    50,
    60,
    75,
    80,
    90,
    100,
    120,
    150,
    200,
    240,
    250,
)
NEAR = 0.01
"""A rate this close to a usual one is it."""

LONGEST_GAP = 86_400.0
"""s; a longer one is a wrong stamp or another record."""

SNAP = 0.1
"""Of a period."""

ON_UTC = 0.0011
"""s; rounding to ms moves a stamp by half as much."""

LEARN_FROM = 5000
"""Frames; the rate and the phase of the raster are told from these."""


def rate_of(ns: np.ndarray) -> float:
    """Frames per second, from stamps that may be rounded, with gaps. Raises RecordError."""
    steps = np.diff(ns[:LEARN_FROM])
    forward = steps[steps > 0]
    if len(forward) == 0:
        raise RecordError("the times do not increase; see time in the map")
    seconds = (ns[:LEARN_FROM] - ns[0]) / times.SECOND
    rate = times.SECOND / float(np.median(forward))
    for width in (4, 16, 64, 256, 1024):  # frames are counted over longer and longer spans
        if width < len(seconds):
            span = seconds[width:] - seconds[:-width]
            span = span[span > 0]
            rate = float(np.median(np.rint(span * rate) / span)) if len(span) else rate
    nearest = min(USUAL_RATES, key=lambda usual: abs(rate / usual - 1))
    return float(nearest) if abs(rate / nearest - 1) < NEAR else float(f"{rate:.6g}")


@dataclass
class Raster:
    """Puts blocks of frames on the raster, one after the other, and counts what it meets."""

    rate: float
    zero: int
    """ns; the raster's zero: a whole second, or where the first frames lie."""
    snap: bool
    """Stamps are rounded ones of the raster."""
    measured_rate: float
    """Frames per second, by the first stamps."""
    first: int = 0
    """Number of the record's first row on the raster."""
    next: int | None = None
    frames: int = 0
    lost: int = 0
    repeated: int = 0
    backward: int = 0
    untimed: int = 0
    off: int = 0
    """Frames farther than a quarter of a period from the raster."""
    gaps: list[tuple[float, float]] = field(default_factory=list)
    """s from the start, s: the first few."""

    @classmethod
    def learnt(cls, ns: np.ndarray, rate: float | None) -> "Raster":
        """From the first block: the rate if it is not given, and the phase."""
        good = ns[ns != times.NOT_A_TIME][:LEARN_FROM]
        if len(good) < 2:
            raise RecordError("no row has a time that can be read; see time in the map")
        steps = np.diff(good)
        if np.mean(steps < 0) > 0.5:
            raise RecordError("the newest frame stands first; sort the rows by time")
        measured = rate_of(good)
        rate = rate or measured
        second = int(good[0]) // times.SECOND * times.SECOND
        place = (good - second) * (rate / times.SECOND)
        phase = circular_mean(place)
        spread = np.abs(wrapped(place - phase))
        if abs(wrapped(np.array(phase))) < ON_UTC * rate:
            phase = 0.0
            spread = np.abs(wrapped(place))
        zero = second + round(phase / rate * times.SECOND)
        return cls(rate, zero, bool(np.quantile(spread, 0.99) < max(SNAP, 0.0006 * rate)), measured)

    def time_of(self, number: np.ndarray) -> np.ndarray:
        """ns after `zero`, of rows of the raster."""
        return np.rint(number * (times.SECOND / self.rate)).astype(np.int64)

    def place(self, ns: np.ndarray, values: Mapping[str, np.ndarray]) -> tuple[dict[str, np.ndarray], int]:
        """Rows of the raster for these frames, nan where one is lost, and their number; times in s from the first."""
        usable = ns != times.NOT_A_TIME
        self.untimed += int(np.sum(~usable))
        away = ns[usable] - self.zero
        exact = away * (self.rate / times.SECOND)
        number = np.rint(exact).astype(np.int64)
        if len(number) == 0:
            return {}, 0
        if self.next is None:
            self.first = self.next = int(number[0])
        highest = np.maximum.accumulate(np.concatenate([[self.next - 1], number[:-1]]))
        new = number > highest
        self.repeated += int(np.sum(number == highest))
        self.backward += int(np.sum(number < highest))
        number, kept = number[new], np.flatnonzero(usable)[new]
        if len(number) == 0:
            return {}, 0
        self.off += int(np.sum(np.abs(exact[new] - number) > 0.25))
        self._count_gaps(number, ns[kept])
        start = self.next
        rows = int(number[-1]) - start + 1
        at = number - start
        t_raster = (self.time_of(np.arange(start, start + rows)) - self.time_of(np.array(self.first))) / times.SECOND
        placed = {"time": t_raster, "t_frame": t_raster.copy()}
        if not self.snap:
            placed["t_frame"][at] = (away[new] - int(self.time_of(np.array(self.first)))) / times.SECOND
        for name, column in values.items():
            placed[name] = np.full(rows, np.nan)
            placed[name][at] = column[kept]
        self.next = int(number[-1]) + 1
        self.frames += len(number)
        self.lost += rows - len(number)
        return placed, rows

    def _count_gaps(self, number: np.ndarray, ns: np.ndarray) -> None:
        assert self.next is not None
        before = np.concatenate([[self.next - 1], number[:-1]])
        jumps = np.flatnonzero(number - before > 1)
        for i in jumps.tolist():
            length = float(number[i] - before[i] - 1) / self.rate
            if length > LONGEST_GAP:
                raise RecordError(
                    f"the times jump by {length / 86_400:.1f} days, to {stamp_text(int(ns[i]))}: a wrong stamp, or two "
                    "records in one file; cut it there"
                )
            if len(self.gaps) < 10:
                self.gaps.append((float(before[i] + 1 - self.first) / self.rate, length))

    @property
    def start(self) -> int:
        """ns; the time of the first row."""
        return self.zero + int(self.time_of(np.array(self.first)))


def stamp_text(ns: int) -> str:
    return times.utc_text(ns) if ns > 1e9 * times.SECOND else f"{ns / times.SECOND:.6f} s"


def wrapped(place: np.ndarray) -> np.ndarray:
    """Into -1/2 .. 1/2."""
    return place - np.rint(place)


def circular_mean(place: np.ndarray) -> float:
    """The mean of what is left of whole numbers, in -1/2 .. 1/2."""
    return float(np.angle(np.mean(np.exp(2j * np.pi * (place % 1.0)))) / (2 * np.pi))
