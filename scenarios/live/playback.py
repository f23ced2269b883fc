"""A scenario's plant or a record, played as the PMUs of a C37.118 stream.

Whatever feeds the scenario's observers becomes a station: through the scenario's PmuChannel, or through one that adds
nothing. Observers are left out. A station whose frame is lost says so in STAT; if all are lost, no frame is sent.
"""

import asyncio
import cmath
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from fractions import Fraction
from math import nan, pi, remainder, sqrt
from pathlib import Path
from typing import NamedTuple

from .. import master
from ..component import Component
from ..errors import ScenarioError
from ..plan import Instance, Plan, Source, sweep_text
from ..records import standard
from ..scenario import Csv, Fmu, Scenario
from .c37118 import Analog, Configuration, Data, Measurement, Phasor, Stamp, Station
from .server import Server

PHASORS = ("V_t", "theta_t", "I_t", "phi_t")
MACHINE_INPUTS = ("P_m", "E_f")
FRAME = (*PHASORS, *MACHINE_INPUTS, "t_frame", "frame_valid")

NO_DATA = 0x4000
"""STAT: error at the PMU, no data (Table 7)."""

TIME_BASE = 1_000_000

LATE = 0.5
"""s behind real time that are worth a word."""


class Site(NamedTuple):
    """A PMU: what it is called, the channel that gives its frames, and which of P_m and E_f come with them."""

    name: str
    channel: Instance
    analogs: tuple[str, ...]


class Bases(NamedTuple):
    """What 1 pu is."""

    V: float
    """V line-neutral."""
    I: float  # noqa: E741 - the usual name
    """A."""
    S: float
    """MVA."""


def bases(kV: float, S_base: float) -> Bases:
    """Of a base voltage in kV line-line and a base power in MVA."""
    return Bases(kV * 1e3 / sqrt(3), S_base * 1e6 / (sqrt(3) * kV * 1e3), S_base)


def of_record(path: Path) -> Scenario:
    """A scenario that plays a standard record (scenarios/records) from its first to its last frame."""
    record = standard.read(path)
    step = Fraction(1) / Fraction(record.rate).limit_denominator(1000)
    names = [name for name in (*PHASORS, *MACHINE_INPUTS) if name in PHASORS or record.has(name)]
    units = {name: standard.COLUMNS[name] for name in names}
    csv = Csv.model_validate(
        {"file": path.name, "time": "time [s]", "columns": {name: f"{name} [{units[name]}]" for name in names}}
    )
    return Scenario.model_validate(
        {
            "title": path.name,
            "step": step,
            "stop": step * (len(record) - 1),
            "fmu": {"channel": Fmu(model="PmuChannel", parameters={"tve": 0.0, "rate": float(1 / step)})},
            "csv": {"record": csv},
            "connect": {"channel.plant.*": "record"},
            "name": path.stem,
            "folder": path.parent,
        }
    )


def arranged(plan: Plan, channel: Component, overrides: Mapping[str, float]) -> tuple[Plan, list[Site]]:
    """The plan of the plant and of a channel for each PMU; `overrides` are parameters of all channels.

    Raises ScenarioError if nothing of it has a PMU.
    """
    sites: dict[Source, Site] = {}
    for instance in plan.instances:
        prefix = "plant." if "plant.V_t" in instance.links else ""
        seen = instance.links.get(f"{prefix}V_t")
        if seen is None or "plant.V_t" in seen.instance.links:
            continue
        key = Source(instance, "V_t") if prefix else seen
        if key not in sites:
            new = Instance(f"PMU {len(sites) + 1}", {})
            analogs = tuple(connect(new, instance, prefix))
            own = instance.parameters if prefix else {"tve": 0.0, "rate": float(1 / plan.scenario.step)}
            new.parameters = {**own, "seed": len(sites) + 1, **overrides} if not prefix else {**own, **overrides}
            if prefix and "seed" in overrides:
                new.parameters["seed"] = overrides["seed"] + len(sites)
            new.watched = set(FRAME)
            sites[key] = Site(name_of(seen, instance if prefix else None), new, analogs)
    if not sites:
        raise ScenarioError(f"{plan.scenario.name}: nothing in it sees a voltage and a current; no PMU to play")
    channels = [site.channel for site in sites.values()]
    upstream = list(dict.fromkeys(found for one in channels for found in fed_by(one)))
    for instance in upstream:
        instance.watched = set()
    for instance in [*upstream, *channels]:
        for source in instance.links.values():
            source.instance.watched.add(source.variable)
    changes = [change for change in plan.changes if change.instance in upstream]
    components = {**plan.components, **{one.component: channel for one in channels}}
    passing = [instance for instance in plan.feedthrough if instance in upstream]
    named = unique([site.name for site in sites.values()])
    found = [site._replace(name=name) for site, name in zip(sites.values(), named, strict=True)]
    return replace(
        plan,
        components=components,
        instances=[*upstream, *channels],
        changes=changes,
        signals={},
        feedthrough=[*passing, *channels],
    ), found


def connect(new: Instance, like: Instance, prefix: str) -> Iterator[str]:
    """Feed a channel with what feeds another channel, or an observer; gives the machine inputs that there are."""
    for name in (*PHASORS, *MACHINE_INPUTS):
        if prefix + name in like.links:
            new.links[f"plant.{name}"] = like.links[prefix + name]
        elif prefix + name in like.inputs:
            new.inputs[f"plant.{name}"] = like.inputs[prefix + name]
        else:
            continue
        if name in MACHINE_INPUTS:
            yield name


def fed_by(instance: Instance) -> Iterator[Instance]:
    """The instances upstream of one, each before those it feeds where that is possible."""
    found: dict[Instance, None] = {}

    def climb(one: Instance) -> None:
        for source in one.links.values():
            if source.instance not in found and source.instance is not instance:
                found[source.instance] = None
                climb(source.instance)

    climb(instance)
    return reversed(found)


def name_of(source: Source, channel: Instance | None) -> str:
    """`G6` of plant.G6.V_t, `plant` of plant.V_t; with what a channel sweeps beside."""
    prefix = source.variable.rpartition(".")[0] or source.instance.component
    sweep = {} if channel is None else {k: v for k, v in channel.sweep.items() if k != "unit"}
    return f"{prefix} {sweep_text(sweep)}".strip()


def unique(names: list[str]) -> list[str]:
    """Station names of 16 characters, all different."""
    short = [name[:16] for name in names]
    return [name if short.count(name) == 1 else f"{name[:12]} {k + 1}" for k, name in enumerate(short)]


def configuration(
    sites: list[Site], idcode: int, rate: int, f0: int, of_pu: Bases, integers: bool = False
) -> Configuration:
    """CFG-2 of the stations: V1 and I1 in V and A, and P_m in MW and E_f in pu where they are known.

    16-bit integers resolve 1/20000 of the base.
    """
    stations = tuple(
        Station(
            site.name,
            idcode + 1 + k,
            (Phasor("V1", False, of_pu.V / 20_000), Phasor("I1", True, of_pu.I / 20_000 * 1.5)),
            tuple(Analog(ANALOG_NAMES[name]) for name in site.analogs),
            phasors_float=not integers,
            frequency_float=not integers,
            nominal_frequency=f0,
        )
        for k, site in enumerate(sites)
    )
    return Configuration(idcode, stations, rate, TIME_BASE)


ANALOG_NAMES = {"P_m": "P_m MW", "E_f": "E_f pu"}


class Frames:
    """The data frames of a plan, as the points of its master bring them; `number` is that of the last one's time."""

    def __init__(self, plan: Plan, sites: list[Site], told: Configuration, of_pu: Bases, soc: int):
        self.plan, self.sites, self.told, self.of_pu, self.soc = plan, sites, told, of_pu, soc
        self.last = [-1] * len(sites)
        self.angles: list[tuple[float, float, float]] = [(nan, nan, nan)] * len(sites)
        """Of each: time, angle and frequency of the last frame."""

    def __iter__(self) -> Iterator[tuple[float, Data | None]]:
        """(time on the plant's clock in s, the frame that arrives at it) for each communication point."""
        rate = self.told.rate
        for index, outputs in enumerate(master.points(self.plan)):
            t = self.plan.scenario.time(index)
            shown = [outputs[site.channel] for site in self.sites]
            numbers = [round(one["t_frame"] * rate) if one["frame_valid"] > 0 else -1 for one in shown]
            new = [n if n > last else -1 for n, last in zip(numbers, self.last, strict=True)]
            if max(new) < 0:
                yield t, None
                continue
            number = max(new)
            measured = tuple(
                self.measurement(k, one) if n == number else self.lost(k)
                for k, (one, n) in enumerate(zip(shown, new, strict=True))
            )
            self.last = [max(n, last) for n, last in zip(new, self.last, strict=True)]
            stamp = Stamp(self.soc + number // rate, round(number % rate * TIME_BASE / rate))
            yield t, Data(self.told.idcode, stamp, measured)

    def measurement(self, place: int, shown: Mapping[str, float]) -> Measurement:
        f0 = self.told.stations[place].nominal_frequency
        V = cmath.rect(shown["V_t"] * self.of_pu.V, shown["theta_t"])
        I = cmath.rect(shown["I_t"] * self.of_pu.I, shown["phi_t"])  # noqa: E741 - the usual name
        before, angle, frequency = self.angles[place]
        h = shown["t_frame"] - before
        now = f0 + remainder(shown["theta_t"] - angle, 2 * pi) / (2 * pi * h) if h > 0 else float(f0)
        rocof = (now - frequency) / h if h > 0 and frequency == frequency else 0.0
        self.angles[place] = shown["t_frame"], shown["theta_t"], now
        scale = {"P_m": self.of_pu.S, "E_f": 1.0}
        analogs = tuple(shown[name] * scale[name] for name in self.sites[place].analogs)
        return Measurement(0, (V, I), now, rocof, analogs)

    def lost(self, place: int) -> Measurement:
        absent = complex(nan, nan)
        return Measurement(NO_DATA, (absent, absent), nan, nan, (nan,) * len(self.sites[place].analogs))


async def play(frames: Frames, server: Server, speed: float, say: Callable[[str], None]) -> None:
    """Send the frames when they are due: in real time, or `speed` times as fast."""
    start, behind = time.monotonic(), False
    for t, data in frames:
        ahead = start + t / speed - time.monotonic()
        await asyncio.sleep(max(ahead, 0.0))
        if ahead < -LATE and not behind:
            say(f"{-ahead:.1f} s behind at {t:.1f} s: this machine is too slow for it")
        behind = ahead < -LATE
        if data is not None:
            server.send(data)
