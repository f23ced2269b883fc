"""The observers on their streams: events of the streams in, estimates of all machines at one time out.

All of it runs in one thread. What comes in waits in the buffers of its connection, which are bounded; nothing waits
inside. `delay` and `backlog` of each stream say whether it keeps up.
"""

import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from math import pi
from typing import NamedTuple, Protocol

from ..component import Component
from ..errors import ScenarioError
from ..machines import table
from . import channels, settings
from .c37118 import Configuration, Measurement, Stamp
from .observer import NOTHING, TRACKING, Observer, parameters_of
from .server import Server
from .session import Arrived, Configured, Session

PATIENCE = 0.1
"""s that estimates of one time wait for those of other streams."""

MOST_WAITING = 64
"""Times that may be incomplete."""

MINUTE = 60.0

TIME_BASE = 1_000_000
"""Of the stamps that are handed out, whatever those of the streams are."""

STATUS = {0: "waiting for frames", 1: "capturing", 2: "tracking", 3: "holding"}


class Estimate(NamedTuple):
    """Of one machine."""

    values: tuple[float, ...]
    """In the order of observer.OUTPUTS; status is the last one."""
    V: complex
    """V, as the frame has it, like the following."""
    I: complex  # noqa: E741 - the usual name
    """A."""
    frequency: float
    """Hz."""
    rocof: float
    stat: int
    trouble: str
    """Why the frame was not used, or ""."""

    @property
    def status(self) -> int:
        return int(self.values[-1])

    @property
    def tracking(self) -> bool:
        return self.status == TRACKING


class Snapshot(NamedTuple):
    """The estimates of one time; None of a machine whose frame did not come."""

    number: int
    """Of the time, in frames: it grows by one from frame to frame, across leap seconds too."""
    stamp: Stamp
    utc: float
    """s since 1970."""
    estimates: tuple[Estimate | None, ...]


class Sink(Protocol):
    """Where estimates go."""

    def take(self, snapshot: Snapshot) -> None: ...


class Unit:
    """A machine of the service."""

    def __init__(self, given: settings.Machine, data: table.Machine):
        self.given, self.data, self.name = given, data, given.unit
        self.channels: channels.Channels | None = None
        self.observer: Observer | None = None
        self.trouble = "no connection yet"
        """Why there is no estimate at all, or ""."""
        self.latest: Estimate | None = None
        self.tracked = False
        """It has been tracked at least once."""

    @property
    def nominal_frequency(self) -> int:
        """Hz, 50 or 60."""
        return round(self.data["omega_s"] / (2 * pi))

    def state(self) -> str:
        """What is wrong with it now, in one line, or ""."""
        failure = self.observer.failure if self.observer else ""
        return self.trouble or failure or (self.latest.trouble if self.latest else "")


class Feed:
    """A stream with its machines, and how it keeps up."""

    def __init__(self, given: settings.Stream, units: Sequence[tuple[int, Unit]], say: Callable[[str], None]):
        self.given, self.units = given, units
        self.session = Session(
            given.idcode,
            third=given.configuration == 3,
            commands=given.transport != "udp_spontaneous",
            time_error=given.time_error,
            say=lambda text: say(f"{given.label}: {text}"),
        )
        self.last_arrival = 0.0
        self.delay = 0.0
        """s from the time stamp of the last frame to its arrival, by this machine's clock."""
        self.smallest: deque[tuple[float, float]] = deque()
        """(when, delay), increasing: the smallest delay of the last minute is the first."""

    @property
    def configuration(self) -> Configuration | None:
        return self.session.layout.configuration if self.session.layout else None

    @property
    def backlog(self) -> float:
        """s by which the last frame came later than the fastest of the last minute: what is piling up somewhere."""
        return self.delay - self.smallest[0][1] if self.smallest else 0.0

    def note(self, utc: float, now: float) -> None:
        self.last_arrival, self.delay = now, now - utc
        while self.smallest and self.smallest[-1][1] >= self.delay:
            self.smallest.pop()
        while self.smallest and self.smallest[0][0] < now - MINUTE:
            self.smallest.popleft()
        self.smallest.append((now, self.delay))


class Service:
    def __init__(self, given: settings.Settings, component: Component, say: Callable[[str], None]):
        """Raises UserError for a machine that machines.csv does not have."""
        self.given, self.component, self.say = given, component, say
        path = given.beside(given.machines)
        self.units = [Unit(one, table.read_machine(path, one.unit)) for one in given.machine]
        self.feeds = [
            Feed(stream, [(k, u) for k, u in enumerate(self.units) if given.stream_of(u.given) is stream], self.say)
            for stream in given.stream
        ]
        self.sinks: list[Sink] = []
        self.waiting: dict[int, tuple[float, Stamp, float, dict[int, Estimate]]] = {}
        self.handed_out = 0
        """Number of the last snapshot."""
        self.snapshots = self.late = 0
        self.output: Server | None = None
        self.rate = 0
        """Frames per second, of all streams."""
        self.configured: Callable[[], None] = lambda: None
        """Is called when the rate is known, or another one."""

    def deliver(self, feed: Feed, event: Configured | Arrived) -> None:
        if isinstance(event, Configured):
            self.configure(feed, event.configuration)
        else:
            self.arrived(feed, event)

    def configure(self, feed: Feed, configuration: Configuration) -> None:
        """Find every machine's channels in a new configuration. An observer goes on where the channels are the same."""
        self.say(f"{feed.given.label}: {described(configuration)}")
        rates = {f.configuration.rate for f in self.feeds if f.configuration is not None}
        if len(rates) > 1:
            self.say(f"{feed.given.label}: streams of {sorted(rates)} frames/s: run one service for each rate")
        if self.rate != configuration.rate:
            self.rate = configuration.rate
            self.configured()
        for _, unit in feed.units:
            try:
                unit.channels = channels.find(configuration, unit.given, unit.data)
                if unit.observer is None or unit.observer.period != configuration.period:
                    unit.observer = self.new_observer(unit, configuration)
                unit.trouble = ""
            except (channels.ChannelError, ScenarioError) as error:
                unit.channels, unit.trouble = None, str(error)
                self.say(unit.trouble)

    def new_observer(self, unit: Unit, configuration: Configuration) -> Observer:
        if unit.observer:
            unit.observer.close()
        measured = {name for name in ("P_m", "E_f") if getattr(unit.given, name)}
        parameters = {**self.given.parameters, **unit.given.parameters}
        chosen = parameters_of(self.component, unit.data, parameters, measured, configuration.period)
        return Observer(self.component, unit.name, chosen, configuration.period)

    def arrived(self, feed: Feed, event: Arrived) -> None:
        now, stamp = time.time(), event.data.stamp
        configuration = feed.configuration
        if configuration is None or configuration.rate < 1:
            return
        utc = stamp.soc + stamp.fraction / configuration.time_base
        feed.note(utc, now)
        origin = feed.session.timeline.origin or 0 if feed.session.timeline else 0
        number = origin * configuration.rate + round(event.t * configuration.rate) + 1
        if number <= self.handed_out and not event.anew:
            self.late += 1
        found = self.waiting.setdefault(number, (now, *following(stamp, configuration), {}))[-1]
        for place, unit in feed.units:
            found[place] = unit.latest = self.estimate(unit, event)
            unit.tracked |= unit.latest.tracking
        self.hand_out(now)

    def estimate(self, unit: Unit, event: Arrived) -> Estimate:
        if unit.channels is None or unit.observer is None:
            return Estimate(NOTHING, complex("nan"), complex("nan"), 0.0, 0.0, 0, unit.trouble)
        measurement: Measurement = event.data.measurements[unit.channels.station]
        trouble = event.troubles[unit.channels.station]
        frame = unit.channels.read(measurement)
        failures = unit.observer.failures
        values = unit.observer.estimate(event.t, frame, not trouble, event.anew)
        if unit.observer.failures > failures:
            self.say(f"{unit.name}: its FMU failed and starts anew in a while: {unit.observer.failure}")
        base = unit.channels.bases
        return Estimate(
            values,
            frame.V * base[0],
            frame.I * base[1],
            measurement.frequency,
            measurement.rocof,
            measurement.stat,
            trouble or unit.observer.failure,
        )

    def hand_out(self, now: float) -> None:
        """Give the sinks what is complete, in the order of time; what is not waits for PATIENCE at most."""
        live = {k for f in self.feeds if now - f.last_arrival < 1.0 for k, _ in f.units}
        for number in sorted(self.waiting):
            since, stamp, utc, found = self.waiting[number]
            if live <= found.keys() or now - since > PATIENCE or len(self.waiting) > MOST_WAITING:
                del self.waiting[number]
                if number > self.handed_out or number < self.handed_out - MOST_WAITING:
                    self.handed_out = number
                    self.snapshots += 1
                    snapshot = Snapshot(number, stamp, utc, tuple(found.get(k) for k in range(len(self.units))))
                    for sink in self.sinks:
                        sink.take(snapshot)
            else:
                return

    def report(self) -> Iterator[str]:
        """How each stream keeps up, and what is wrong with which machine."""
        for feed in self.feeds:
            counters = feed.session.counters
            yield (
                f"{feed.given.label}: {counters.frames} frames, {counters.missing} missing, {counters.skipped} bytes "
                f"skipped, {counters.connections} connections; delay {1e3 * feed.delay:.0f} ms, "
                f"backlog {1e3 * feed.backlog:.0f} ms"
            )
        if self.output and self.output.dropped:
            yield f"{self.output.dropped} estimates not taken by clients that were too slow"
        tracking = [unit for unit in self.units if unit.latest and unit.latest.tracking]
        yield f"{len(tracking)} of {len(self.units)} machines tracked"
        for unit in self.units:
            if unit not in tracking or unit.state():
                status = unit.latest.status if unit.latest else 0
                yield f"{unit.name}: {unit.state() or STATUS.get(status, f'status {status}')}"

    def flush(self) -> None:
        """Hand out what still waits for other streams."""
        self.hand_out(float("inf"))

    def close(self) -> None:
        for unit in self.units:
            if unit.observer:
                unit.observer.close()


def following(stamp: Stamp, configuration: Configuration) -> tuple[Stamp, float]:
    """The stamp a period later, in 1/TIME_BASE s: the estimates are of that time; and the same in s since 1970."""
    rate, base = configuration.rate, configuration.time_base
    number = round(stamp.fraction / base * rate) + 1
    soc, rest = stamp.soc + number // rate, number % rate
    return Stamp(soc, round(rest * TIME_BASE / rate), stamp.quality), soc + rest / rate


def described(configuration: Configuration) -> str:
    stations = ", ".join(station.name for station in configuration.stations[:12])
    more = len(configuration.stations) - 12
    rate = f"{configuration.rate} frames/s" if configuration.rate > 0 else f"a frame every {-configuration.rate} s"
    return f"{rate}, {len(configuration.stations)} stations: {stations}{f' and {more} more' if more > 0 else ''}"
