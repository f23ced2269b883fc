"""From the columns of a file to pu and rad at the PMU, as a MAP says."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..errors import alternatives
from . import times, units
from .map import Current, FieldVoltage, Map, MapError, MechanicalPower, Phasor, Power, Time, Voltage
from .readers import Table

A = np.exp(2j * np.pi / 3)
"""Fortescue's operator."""

TO_PHASE = np.exp(-1j * np.pi / 6)
"""V_AB leads V_A by 30 deg."""

S_BASE = 100e6
"""VA, where nothing else is said: the observer's own default."""


@dataclass(frozen=True)
class Conversion:
    """A map, bound to a table: all names and units are known. `where` is the map's name, for messages."""

    map: Map
    time: Time
    S_base: float
    """VA."""
    V_base: float | None
    """V line-line."""
    f0: float
    """Hz; nan where it is not known."""
    V_scale: float
    """pu per unit of the column."""
    I_scale: float
    angle_scale: tuple[float, float]
    """rad per unit of the angle columns of V and of I."""
    scales: Mapping[str, float]
    """pu per unit of the columns of P, Q, P_m, E_f, with the sign of their direction; Hz of f."""
    time_scale: float
    """s per unit of the time column."""

    @property
    def numbers(self) -> list[str]:
        """Columns to read as numbers."""
        phasors = [*columns_of(self.map.V), *columns_of(self.map.I)]
        signals = [signal.column for name in self.scales if (signal := getattr(self.map, name)) is not None]
        stamps = [self.time.soc, self.time.fracsec] if self.time.format == "soc" else []
        stamps += (self.time.column or []) if self.time.format in ("epoch", "seconds") else []
        return [name for name in (*phasors, *signals, *stamps) if name]

    @property
    def texts(self) -> list[str]:
        """Columns to read as text."""
        stamps = [] if self.time.format in ("epoch", "seconds", "soc") else self.time.column or []
        return [*stamps, *([self.map.valid.column] if self.map.valid else [])]

    def stamps(self, columns: Mapping[str, np.ndarray]) -> np.ndarray:
        """Times in ns, see `times`."""
        t = self.time
        if t.format == "soc":
            return times.from_soc(columns[t.soc or ""], columns[t.fracsec or ""], t.time_base)
        names = t.column or []
        if t.format in ("epoch", "seconds"):
            ns = times.from_numbers(columns[names[0]], self.time_scale)
            if t.start is None:
                return ns
            start = times.from_iso(np.array([t.start.encode()]), t.zone or "UTC")[0]
            return np.where(ns == times.NOT_A_TIME, ns, ns + start)
        text = columns[names[0]]
        for name in names[1:]:
            text = np.array([b" ".join(pair) for pair in zip(text.tolist(), columns[name].tolist(), strict=True)])
        if t.format == "iso":
            return times.from_iso(text, t.zone or "UTC")
        return times.from_pattern(text, t.format or "", t.zone or "UTC")

    def values(self, columns: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        """frame_valid, V_t ... E_f in pu and rad, angles in (-pi, pi]; nan where a frame is no good."""
        V, I = self._phasor(self.map.V, columns, 0), self._phasor(self.map.I, columns, 1)  # noqa: E741 - the paper's name
        if self.map.I.direction == "into the generator":
            I = -I  # noqa: E741 - the paper's name
        valid = np.isfinite(V) & np.isfinite(I) & (V != 0) & self._good(columns)
        S = V * np.conj(I)
        found = {"V_t": np.abs(V), "theta_t": np.angle(V), "I_t": np.abs(I), "phi_t": np.angle(I)}
        found |= {"P_t": np.real(S), "Q_t": np.imag(S)}
        for name, scale in self.scales.items():
            found[name] = columns[getattr(self.map, name).column] * scale
        if self.map.f is not None and self.map.f.deviation:
            found["f"] = found["f"] + self.f0
        for name in ("P_t", "Q_t"):
            valid &= np.isfinite(found[name])
        values = {name: np.where(valid, value, np.nan) for name, value in renamed(found).items()}
        return {"frame_valid": valid.astype(float), **values}

    def angles(self, columns: Mapping[str, np.ndarray]) -> list[np.ndarray]:
        """The angle columns, rad, as the map has it: not wrapped."""
        both = ((self.map.V, self.angle_scale[0]), (self.map.I, self.angle_scale[1]))
        return [scale * columns[name] for phasor, scale in both if phasor.polar for name in phasor.pairs[1]]

    def _phasor(self, phasor: Phasor, columns: Mapping[str, np.ndarray], which: int) -> np.ndarray:
        """Positive sequence, complex, pu. A phasor of which both parts are exactly 0 is a dropout: nan."""
        scale = (self.V_scale, self.I_scale)[which]
        phases = []
        for first, second in zip(*phasor.pairs, strict=True):
            a, b = columns[first], columns[second]
            value = a * np.exp(1j * self.angle_scale[which] * b) if phasor.polar else a + 1j * b
            phases.append(np.where((a == 0) & (b == 0), np.nan, scale * value))
        value = (phases[0] + A * phases[1] + A * A * phases[2]) / 3 if len(phases) == 3 else phases[0]
        if phasor.conjugate:
            value = np.conj(value)
        turn = np.exp(1j * phasor.shift)
        if isinstance(phasor, Voltage) and phasor.is_ == "AB":
            turn = turn * TO_PHASE
        return value * turn if turn != 1 else value

    def _good(self, columns: Mapping[str, np.ndarray]) -> np.ndarray | bool:
        valid = self.map.valid
        if valid is None:
            return True
        cells, place = np.unique(columns[valid.column], return_inverse=True)
        words = [cell.decode("utf-8", "replace").strip() for cell in cells]
        if valid.bad_bits is not None:
            good = [word_bits(word) is not None and not (word_bits(word) or 0) & valid.bad_bits for word in words]
        else:
            allowed = {plain(word) for word in valid.good or []}
            good = [plain(word) in allowed for word in words]
        return np.array(good)[place]


def renamed(found: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """P and Q of a map are P_t and Q_t of a record."""
    given = {"P": "P_t", "Q": "Q_t"}
    return {given.get(name, name): value for name, value in found.items()}


def word_bits(word: str) -> int | None:
    """A STAT word: 0x2000, 8192 or 8192.0."""
    try:
        return int(word, 16) if word.lower().startswith("0x") else int(float(word))
    except ValueError:
        return None


def plain(word: object) -> str:
    """A quality word or number without its capitals: 1, 1.0 and "1" are one; true is "true"."""
    text = str(word).strip().lower()
    try:
        return f"{float(text):g}"
    except ValueError:
        return text


def bind(map: Map, table: Table, where: str, V_n: float | None = None) -> Conversion:
    """The conversion of a table by a map; V_n, V line-line, is the base of a voltage that has none. Raises MapError."""
    time = time_of(map, table, where)
    for name, part in parts(map, time):
        for column in columns_of(part):
            if column not in table.names:
                raise MapError(f'{where}: {name}: there is no column "{column}"; {alternatives(column, table.names)}')
    S_base = map.S_base or (table.hints.S_base or 0) * 1e6 or S_BASE
    V_base = map.V.base or V_n
    V_scale, V_angle = voltage_scale(map.V, table, where, V_base)
    I_scale, I_angle = current_scale(map.I, table, where, V_base, S_base)
    scales = {}
    for name in ("P", "Q", "P_m"):
        signal = getattr(map, name)
        if signal is not None:
            scales[name] = power_scale(name, signal, table, where, S_base)
    if map.E_f is not None:
        scales["E_f"] = field_scale(map.E_f, table, where)
    if map.f is not None:
        scales["f"] = unit_of(f"{where}: f", map.f.unit or table.units.get(map.f.column, "Hz"), "frequency")
        if map.f.deviation and not (map.frequency or table.hints.frequency):
            raise MapError(f"{where}: f.deviation needs the nominal frequency = 60 (or 50)")
    stamp_unit = time.unit
    if time.column and time.unit == "s" and time.format in ("epoch", "seconds"):
        stamp_unit = table.units.get(time.column[0], "s")
    time_scale = unit_of(f"{where}: time", stamp_unit, "time")
    f0 = map.frequency or table.hints.frequency or np.nan
    return Conversion(map, time, S_base, V_base, f0, V_scale, I_scale, (V_angle, I_angle), scales, time_scale)


def parts(map: Map, time: Time) -> list[tuple[str, object]]:
    named = [(name, getattr(map, name)) for name in ("V", "I", "P", "Q", "P_m", "E_f", "f", "valid")]
    return [("time", time), *[(name, part) for name, part in named if part is not None]]


def columns_of(part: object) -> list[str]:
    if isinstance(part, Phasor):
        first, second = part.pairs
        return [*first, *second]
    if isinstance(part, Time):
        return [*(part.column or []), *[name for name in (part.soc, part.fracsec) if name]]
    return [part.column]  # type: ignore[attr-defined]


def time_of(map: Map, table: Table, where: str) -> Time:
    """The map's, filled up with what the file itself says."""
    known = dict(table.hints.time or {})
    given = map.time.model_dump(exclude_unset=True) if map.time else {}
    if not known and not given:
        raise MapError(f'{where}: time is missing; write time = {{ column = "...", format = "iso" }}')
    merged = {**known, **given} if given.get("format", known.get("format")) == known.get("format") else given
    time = Time(**merged)
    if time.format is None:
        raise MapError(f'{where}: time.format is missing; write "iso", "epoch", "seconds", "soc" or a pattern')
    return time


def unit_of(where: str, text: str, *quantities: str) -> float:
    try:
        return units.unit_of(text, *quantities).factor
    except ValueError as error:
        raise MapError(f"{where}: unit {error}") from None


def unit_texts(phasor: Phasor, table: Table, where: str) -> tuple[str, str]:
    """The units of the two columns of a phasor: of the map, or those that the file states."""
    first, second = (names[0] for names in phasor.pairs)
    given = list(phasor.unit or [])
    size = given[0] if given else table.units.get(first, "")
    if not size:
        raise MapError(f'{where}: the unit of "{first}" is not known; write unit = ["kV", "deg"]')
    angle = given[1] if len(given) == 2 else table.units.get(second, "") if phasor.polar else ""
    if phasor.polar and not angle:
        raise MapError(f'{where}: the unit of "{second}" is not known; write unit = ["{size}", "deg"]')
    return size, angle


def peak(phasor: Phasor) -> float:
    return 0.5**0.5 if phasor.value == "peak" else 1.0


def voltage_scale(V: Voltage, table: Table, where: str, base: float | None) -> tuple[float, float]:
    where = f"{where}: V"
    size, angle = unit_texts(V, table, where)
    found = unit_of(where, size, "voltage", "per unit")
    turn = unit_of(where, angle, "angle") if V.polar else 1.0
    if units.unit(size).quantity == "per unit":
        return found * peak(V), turn
    if V.is_ is None:
        raise MapError(
            f'{where}: say what a voltage in {size} is between: is = "line-neutral" (12.7 kV on a 22 kV machine), '
            '"line-line", or "AB" (phasors between two lines, 30 deg ahead)'
        )
    if base is None:
        raise MapError(f'{where}: base is missing; write base = "22 kV line-line", or give --machine with V_n')
    between = 1.0 if V.is_ in ("line-line", "AB") else 3**0.5
    return found * peak(V) * between / base, turn


def current_scale(I: Current, table: Table, where: str, V_base: float | None, S_base: float) -> tuple[float, float]:  # noqa: E741 - the paper's name
    where = f"{where}: I"
    size, angle = unit_texts(I, table, where)
    found = unit_of(where, size, "current", "per unit")
    turn = unit_of(where, angle, "angle") if I.polar else 1.0
    if units.unit(size).quantity == "per unit":
        return found * peak(I) * (I.base or S_base) / S_base, turn
    if V_base is None:
        raise MapError(f'{where}: a current in {size} needs the base of V: base = "22 kV line-line"')
    return found * peak(I) * 3**0.5 * V_base / S_base, turn


def power_scale(name: str, signal: Power | MechanicalPower, table: Table, where: str, S_base: float) -> float:
    where = f"{where}: {name}"
    text = signal.unit or table.units.get(signal.column, "")
    if not text:
        raise MapError(f'{where}: the unit of "{signal.column}" is not known; write unit = "MW"')
    quantity = "reactive power" if name == "Q" else "active power"
    found = unit_of(where, text, quantity, "apparent power", "per unit")
    if units.unit(text).quantity == "per unit":
        found *= signal.base or S_base
    into = isinstance(signal, Power) and signal.direction == "into the generator"
    return (-found if into else found) / S_base


def field_scale(E_f: FieldVoltage, table: Table, where: str) -> float:
    where = f"{where}: E_f"
    text = E_f.unit or table.units.get(E_f.column, "")
    if not text:
        raise MapError(f'{where}: the unit of "{E_f.column}" is not known; write unit = "pu", or "V" and a base')
    found = unit_of(where, text, "voltage", "current", "per unit")
    if units.unit(text).quantity == "per unit":
        return found * (units.amount(E_f.base, "per unit")[0] if E_f.base else 1.0)
    if E_f.base is None:
        raise MapError(
            f"{where}: in {text} it needs a base, the value at no load and rated voltage on the air-gap line: "
            f'base = "92 {text}"'
        )
    try:
        return found / units.amount(E_f.base, units.unit(text).quantity)[0]
    except ValueError as error:
        raise MapError(f"{where}: base {error}") from None
