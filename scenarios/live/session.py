"""What is said between a PMU or PDC and its client, without any input or output: bytes and times in, events out.

The client turns the data off, asks for the configuration, and turns the data on when it has it. It asks again when that
may be out of date: data frames of another size, STAT's bit for a change of configuration has fallen, or a minute has
passed. Data are not read with a layout that may be the old one.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

from . import c37118
from .c37118 import Command, Configuration, Data, FrameError, Layout, Stamp, Stat
from .splitter import Splitter
from .timeline import Timeline

PATIENCE = 1.0
"""s without an answer, after which the configuration is asked for again."""

CHECK_CONFIGURATION = 60.0
"""s after which it is asked for anyhow: a change may give frames of the same size, and no notice."""

TIME_ERROR = 1e-4
"""s; the default of what a clock may be off. At 60 Hz it is 2.2 deg; 1 ms would be 21.6 deg."""


class Configured(NamedTuple):
    """There is a new configuration; the data that follow are of it."""

    configuration: Configuration


class Arrived(NamedTuple):
    """A data frame, later than all before it."""

    data: Data
    t: float
    """s, continuous: see timeline.py."""
    missing: int
    """Frames before this one that did not come."""
    anew: bool
    """How much time has passed since the frame before is not known."""
    troubles: tuple[str, ...]
    """Of each station: why its values are not to be used, or ""."""


@dataclass
class Counters:
    frames: int = 0
    missing: int = 0
    late: int = 0
    """Repeated, or older than the last one."""
    unread: int = 0
    """Data frames that came while the configuration was not known, or did not fit it."""
    skipped: int = 0
    """Bytes that belonged to no intact frame."""
    configurations: int = 0
    connections: int = 0


def trouble(stat: int, stamp: Stamp, time_error: float = TIME_ERROR) -> str:
    """Why a station's values are not to be used (Tables 4 and 7), or ""."""
    error = stat >> 14
    if error:
        return ("", "no data from the PMU", "PMU in test mode", "PMU error")[error]
    if stat & Stat.NOT_SYNCHRONIZED:
        return "PMU not synchronised to UTC"
    if stat & Stat.SORTED_BY_ARRIVAL:
        return "time of arrival, not of measurement"
    off = max(c37118.pmu_time_error(stat), stamp.time_error)
    if off > time_error * 1.001:
        return f"clock off by up to {off:g} s"
    return ""


@dataclass
class Session:
    """With one source, over any number of connections: the time runs on."""

    idcode: int
    third: bool = False
    """CFG-3 is asked for, not CFG-2."""
    commands: bool = True
    """The source obeys commands; else it sends by itself, and its configuration every minute."""
    time_error: float = TIME_ERROR
    say: Callable[[str], None] = lambda text: None
    outgoing: list[bytes] = field(default_factory=list)
    """What is to be sent now."""
    counters: Counters = field(default_factory=Counters)
    layout: Layout | None = None
    last_data: float = 0.0
    """s, of the clock of `now`: when the last data frame came."""

    def __post_init__(self):
        self.splitter = Splitter()
        self.timeline: Timeline | None = None
        self.parts: list[bytes] = []
        self.asked = self.checked = 0.0
        self.current = False  # the layout is that of the frames that come now
        self.announced = False  # a change of configuration

    def connected(self, now: float) -> None:
        """A new connection: what was received in part is lost, and the configuration may be another one."""
        self.splitter, self.parts = Splitter(), []
        self.counters.connections += 1
        self.current = self.announced = False
        self.last_data = now
        if self.commands:
            self.send(Command.DATA_OFF, now)
        self.ask(now)

    def ask(self, now: float) -> None:
        self.asked = now
        if self.commands:
            self.send(Command.SEND_CONFIG_3 if self.third else Command.SEND_CONFIG_2, now)

    def send(self, command: Command, now: float) -> None:
        self.outgoing.append(c37118.encode_command(self.idcode, Stamp(int(now)), command))

    def tick(self, now: float) -> None:
        """To be called several times a second."""
        if not self.current and now - self.asked >= PATIENCE:
            self.ask(now)
        elif self.current and now - self.checked >= CHECK_CONFIGURATION:
            self.checked = now
            self.ask(now)

    def farewell(self, now: float) -> None:
        """Before the connection is closed."""
        if self.commands:
            self.send(Command.DATA_OFF, now)

    def receive(self, received: bytes, now: float, whole: bool = False) -> list[Configured | Arrived]:
        """What the bytes bring; `whole` if no frame goes on in the bytes that follow (a datagram)."""
        events = [event for frame in self.splitter.feed(received) for event in self.take(frame, now)]
        self.counters.skipped += self.splitter.skipped
        self.splitter.skipped = 0
        if whole and self.splitter.buffer:
            self.counters.skipped += len(self.splitter.buffer)
            self.splitter.buffer.clear()
        return events

    def take(self, frame: bytes, now: float) -> list[Configured | Arrived]:
        if int.from_bytes(frame[4:6]) != self.idcode:
            return []
        match c37118.frame_type(frame):
            case c37118.DATA:
                return self.take_data(frame, now)
            case c37118.CONFIG_2:
                return self.take_configuration([frame], now)
            case c37118.CONFIG_3:
                index = c37118.continuation(frame)
                self.parts = [*([] if index in (0, 1) else self.parts), frame]
                return self.take_configuration(self.parts, now) if index in (0, 0xFFFF) else []
        return []

    def take_configuration(self, frames: list[bytes], now: float) -> list[Configured | Arrived]:
        try:
            configuration = c37118.decode_configuration(*frames)
        except FrameError as error:
            self.say(f"configuration of stream {self.idcode}: {error}")
            return []
        if self.commands and not self.current:
            self.send(Command.DATA_ON, now)
        self.current, self.checked = True, now
        known = self.layout and self.layout.configuration._replace(stamp=configuration.stamp)
        if known == configuration:
            return []
        self.layout = c37118.layout(configuration)
        self.counters.configurations += 1
        if self.timeline is None:
            self.timeline = Timeline(configuration.time_base, configuration.period)
        self.timeline.time_base, self.timeline.period = configuration.time_base, configuration.period
        return [Configured(configuration)]

    def take_data(self, frame: bytes, now: float) -> list[Configured | Arrived]:
        self.last_data = now
        if not self.current or self.layout is None or self.timeline is None:
            self.counters.unread += 1
            return []
        try:
            data = c37118.decode_data(frame, self.layout)
        except FrameError as error:
            self.doubt(f"{error}: asking for the configuration", now)
            return []
        announced = any(m.stat & Stat.CONFIGURATION_CHANGE for m in data.measurements)
        if self.announced and not announced:
            self.announced = False
            self.doubt("the configuration has changed as announced: asking for it", now)
            return []
        self.announced = announced
        place = self.timeline.place(data.stamp)
        if place is None:
            self.counters.late += 1
            return []
        self.counters.frames += 1
        self.counters.missing += place.missing
        troubles = tuple(trouble(m.stat, data.stamp, self.time_error) for m in data.measurements)
        return [Arrived(data, *place, troubles)]

    def doubt(self, why: str, now: float) -> None:
        """The layout is no longer that of the frames."""
        self.say(f"stream {self.idcode}: {why}")
        self.counters.unread += 1
        self.current = False
        self.ask(now)
