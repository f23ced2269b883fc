"""From the channels of a station, in V and A, to the frame of a machine, in pu on its S_n."""

import cmath
from math import nan, pi, sqrt
from typing import NamedTuple

from ..errors import alternatives
from ..machines.table import Machine as MachineData
from ..records import units
from .c37118 import Configuration, Measurement, Station
from .settings import Analog, Machine

THIRD = cmath.rect(1.0, 2 * pi / 3)
"""e^{j 120 deg}."""

NEAR = 0.01
"""Relative; omega_s and the stream's nominal frequency are one if they are this close."""


class ChannelError(ValueError):
    """A machine's channels are not in the stream, and what there is."""


class Frame(NamedTuple):
    """What the observer's inputs are made of, in pu."""

    V: complex
    I: complex  # noqa: E741 - the usual name
    P_m: float
    E_f: float
    """nan where it is not measured."""


class Channels(NamedTuple):
    """Where a machine's values are in a data frame, and what they are to be multiplied by."""

    station: int
    V: tuple[tuple[int, complex], ...]
    """Index and factor of each phasor; the sum is V."""
    I: tuple[tuple[int, complex], ...]  # noqa: E741 - the usual name
    P_m: tuple[int, float] | None
    E_f: tuple[int, float] | None
    bases: tuple[float, float]
    """V line-neutral and A of 1 pu."""

    def read(self, measurement: Measurement) -> Frame:
        """The frame of the machine, in pu."""
        V = sum(measurement.phasors[place] * factor for place, factor in self.V)
        I = sum(measurement.phasors[place] * factor for place, factor in self.I)  # noqa: E741 - the usual name
        P_m = measurement.analogs[self.P_m[0]] * self.P_m[1] if self.P_m else nan
        E_f = measurement.analogs[self.E_f[0]] * self.E_f[1] if self.E_f else nan
        return Frame(V, I, P_m, E_f)


def find(configuration: Configuration, machine: Machine, data: MachineData) -> Channels:
    """The channels of a machine. Raises ChannelError with what the stream has instead."""
    place = station_of(configuration, machine)
    station = configuration.stations[place]
    nominal = data["omega_s"] / (2 * pi)
    if abs(nominal / station.nominal_frequency - 1) > NEAR:
        raise ChannelError(
            f"{machine.unit}: station {station.name} has {station.nominal_frequency} Hz, "
            f"omega_s is that of {nominal:g} Hz"
        )
    base = machine.V.base or (data.V_n or 0.0) * 1e3
    if not base:
        raise ChannelError(
            f'{machine.unit}: give V a base: base = "20 kV line-line", or {data.unit} a V_n in machines.csv'
        )
    of_V = {"line-neutral": sqrt(3), "line-line": 1.0, "AB": cmath.rect(1.0, -pi / 6)}[machine.V.is_] / base
    of_I = sqrt(3) * base / (data["S_n"] * 1e6) * (1 if machine.I.direction == "out of the generator" else -1)
    V = phasors(station, machine, machine.V.phasor, False)
    I = phasors(station, machine, machine.I.phasor, True)  # noqa: E741 - the usual name
    turn_V = cmath.rect(machine.V.ratio, machine.V.shift) * of_V
    turn_I = cmath.rect(machine.I.ratio, machine.I.shift) * of_I
    return Channels(
        place,
        tuple((index, factor * turn_V) for index, factor in V),
        tuple((index, factor * turn_I) for index, factor in I),
        analog(station, machine, machine.P_m, "P_m", data["S_n"] * 1e6),
        analog(station, machine, machine.E_f, "E_f", 1.0),
        (base / sqrt(3), data["S_n"] * 1e6 / (sqrt(3) * base)),
    )


def station_of(configuration: Configuration, machine: Machine) -> int:
    names = [station.name for station in configuration.stations]
    codes = [station.idcode for station in configuration.stations]
    if machine.station is None and len(names) == 1:
        return 0
    if machine.station is None:
        raise ChannelError(f'{machine.unit}: say which station: station = "{names[0]}"; known: {", ".join(names)}')
    wanted: list[int | str] = [*codes] if isinstance(machine.station, int) else [*names]
    if wanted.count(machine.station) != 1:
        how_many = "no" if machine.station not in wanted else "more than one"
        known = alternatives(str(machine.station), [str(one) for one in wanted])
        raise ChannelError(f'{machine.unit}: the stream has {how_many} station "{machine.station}"; {known}')
    return wanted.index(machine.station)


def phasors(station: Station, machine: Machine, names: list[str], current: bool) -> list[tuple[int, complex]]:
    """Index and share in the positive sequence of each phasor: 1, or 1/3, a/3, a^2/3 for the phases A, B, C."""
    of_kind = {phasor.name: index for index, phasor in enumerate(station.phasors) if phasor.is_current == current}
    kind = "current" if current else "voltage"
    for name in names:
        if name not in of_kind:
            known = alternatives(name, list(of_kind))
            raise ChannelError(f'{machine.unit}: station {station.name} has no {kind} "{name}"; {known}')
    if len(names) == 1:
        return [(of_kind[names[0]], 1)]
    if len(names) == 2:
        raise ChannelError(f"{machine.unit}: give one {kind} phasor, or the three of the phases A, B and C")
    return [(of_kind[name], THIRD**power / 3) for power, name in enumerate(names)]


def analog(station: Station, machine: Machine, given: Analog | None, name: str, of_pu: float):
    """Index and factor to pu. `of_pu` is what 1 pu is in the unit's first unit, if no base is given."""
    if given is None:
        return None
    names = [one.name for one in station.analogs]
    if given.analog not in names:
        known = alternatives(given.analog, names)
        raise ChannelError(f'{machine.unit}: station {station.name} has no analog "{given.analog}" for {name}; {known}')
    unit = units.unit(given.unit)
    base = units.amount(given.base, *QUANTITIES)[0] if given.base else of_pu
    factor = unit.factor * (base / of_pu if unit.quantity == "per unit" else 1 / base)
    return names.index(given.analog), factor


QUANTITIES = ("apparent power", "voltage", "current", "per unit")
