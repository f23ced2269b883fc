"""MAP.toml: which columns of a file are the phasors, powers and times, in which units, on which base.

    time = { column = "Timestamp", format = "iso", zone = "UTC" }
    V = { magnitude = "VA_M", angle = "VA_A", unit = ["kV", "deg"], base = "22 kV line-line", is = "line-neutral" }
    I = { magnitude = "IA_M", angle = "IA_A", unit = ["A", "deg"], direction = "out of the generator" }

README.md of this folder tells every key. What a map does not say is taken from the file, where that says it.
"""

import tomllib
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError, model_validator

from ..errors import UserError, alternatives
from . import readers, times, units
from .readers import Table


class MapError(UserError):
    """What is wrong with a MAP, and what to do about it."""


def listed(value: Any) -> Any:
    return [value] if isinstance(value, str) else value


def known_zone(value: Any) -> Any:
    if isinstance(value, str):
        times.zone_of(value)
    return value


def turn(value: Any) -> float:
    """`-30 deg` in rad."""
    if not isinstance(value, str):
        raise ValueError('write an angle with its unit: "-30 deg"')
    return units.amount(value, "angle")[0]


def power_base(value: Any) -> float:
    """`100 MVA` in VA."""
    if not isinstance(value, str):
        raise ValueError('write it with its unit: "100 MVA"')
    size = units.amount(value, "apparent power")[0]
    if not size > 0:
        raise ValueError("it must be positive")
    return size


def voltage_base(value: Any) -> float:
    """`22 kV line-line` in V line-line."""
    if not isinstance(value, str):
        raise ValueError('write it with its unit: "22 kV line-line"')
    size, kind = units.amount(value, "voltage")
    if kind not in ("", "line-line", "line-neutral"):
        raise ValueError(f'"{kind}" is not known; write "22 kV line-line" or "12.7 kV line-neutral"')
    if not size > 0:
        raise ValueError("it must be positive")
    return size * 3**0.5 if kind == "line-neutral" else size


Names = Annotated[list[str], BeforeValidator(listed), Field(min_length=1, max_length=3)]
Units = Annotated[list[str], BeforeValidator(listed), Field(min_length=1, max_length=2)]
Turn = Annotated[float, BeforeValidator(turn)]
PowerBase = Annotated[float, BeforeValidator(power_base)]
VoltageBase = Annotated[float, BeforeValidator(voltage_base)]
Zone = Annotated[str, BeforeValidator(known_zone)]
Direction = Literal["out of the generator", "into the generator"]


class Part(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, populate_by_name=True)


class Phasor(Part):
    """Magnitude and angle, or real and imaginary part: of the positive sequence (or one phase), or of three phases."""

    magnitude: Names | None = None
    angle: Names | None = None
    real: Names | None = None
    imaginary: Names | None = None
    unit: Units | None = None
    """Of both; or of the magnitude and of the angle."""
    value: Literal["rms", "peak"] = "rms"
    shift: Turn = 0.0
    """rad; is added to the angle."""
    conjugate: bool = False
    """Angles that are counted the other way round."""

    @property
    def pairs(self) -> tuple[list[str], list[str]]:
        """The columns of the first and of the second part."""
        first, second = (self.magnitude, self.angle) if self.polar else (self.real, self.imaginary)
        return first or [], second or []

    @property
    def polar(self) -> bool:
        return self.magnitude is not None

    @model_validator(mode="after")
    def check(self) -> Self:
        polar, rectangular = (self.magnitude, self.angle), (self.real, self.imaginary)
        complete = [pair for pair in (polar, rectangular) if all(pair)]
        if len(complete) != 1 or any(polar) == any(rectangular):
            raise ValueError("give magnitude and angle, or real and imaginary")
        first, second = self.pairs
        if len(first) != len(second) or len(first) == 2:
            raise ValueError("give one column for each of the two, or three, for the phases A, B and C")
        if not self.polar and self.unit is not None and len(self.unit) == 2 and self.unit[0] != self.unit[1]:
            raise ValueError("real and imaginary part have one unit")
        return self


class Voltage(Phasor):
    base: VoltageBase | None = None
    """V line-line."""
    is_: Annotated[Literal["line-neutral", "line-line", "AB"] | None, Field(alias="is")] = None
    """line-line: the magnitude, at the angle of the phase voltage; AB: the phasors V_AB (V_BC, V_CA), 30 deg ahead."""


class Current(Phasor):
    base: PowerBase | None = None
    """VA; of a current in pu."""
    direction: Direction = "out of the generator"


class Power(Part):
    column: str
    unit: str | None = None
    base: PowerBase | None = None
    """VA; of a power in pu."""
    direction: Direction = "out of the generator"


class MechanicalPower(Part):
    column: str
    unit: str | None = None
    base: PowerBase | None = None


class FieldVoltage(Part):
    """E_f in pu, or the exciter's voltage or current over its value at no load and rated voltage, the base."""

    column: str
    unit: str | None = None
    base: str | None = None

    @model_validator(mode="after")
    def check(self) -> Self:
        if self.base is not None:
            units.amount(self.base, "voltage", "current", "per unit")
        return self


class Frequency(Part):
    """What the PMU reports, for the checks; with `deviation`, less the nominal one."""

    column: str
    unit: str | None = None
    deviation: bool = False


class Time(Part):
    column: Names | None = None
    """Two are joined by a blank: date and time."""
    format: str | None = None
    """iso, epoch, seconds, soc, or a pattern of strptime: "%d.%m.%Y %H:%M:%S.%f"."""
    zone: Zone | None = None
    unit: str = "s"
    """Of epoch and seconds."""
    start: str | None = None
    """ISO 8601: what seconds count from."""
    soc: str | None = None
    fracsec: str | None = None
    time_base: Annotated[int, Field(gt=0)] = 1_000_000

    @model_validator(mode="after")
    def check(self) -> Self:
        kinds = ("iso", "epoch", "seconds", "soc")
        if self.format is not None and self.format not in kinds and "%" not in self.format:
            raise ValueError(
                f'format "{self.format}" is not known; {alternatives(self.format, kinds)}, '
                'or a pattern: "%d.%m.%Y %H:%M:%S.%f"'
            )
        if (self.format == "soc") != (self.soc is not None and self.fracsec is not None):
            raise ValueError('format = "soc" goes with soc and fracsec, the names of two columns')
        if self.format != "soc" and self.column is None:
            raise ValueError("give the column of the time stamps")
        if self.column is not None and len(self.column) == 3:
            raise ValueError("give one column, or two: date and time")
        units.unit_of(self.unit, "time")
        return self


class Valid(Part):
    """Where a frame is good: `good` lists the words or numbers for it; of a STAT word no bit of `bad_bits` is set."""

    column: str
    good: list[Any] | None = None
    bad_bits: Annotated[int, Field(ge=0, le=0xFFFF)] | None = None

    @model_validator(mode="after")
    def check(self) -> Self:
        if (self.good is None) == (self.bad_bits is None):
            raise ValueError('give good = [1, "Good"], or bad_bits = 0xF000 for a STAT word')
        return self


class File(Part):
    format: str | None = None
    separator: str | None = None
    decimal: Literal[".", ","] | None = None


class Map(Part):
    V: Voltage
    I: Current  # noqa: E741 - the usual name
    P: Power | None = None
    Q: Power | None = None
    P_m: MechanicalPower | None = None
    E_f: FieldVoltage | None = None
    f: Frequency | None = None
    time: Time | None = None
    valid: Valid | None = None
    file: File = File()
    rate: Annotated[float, Field(gt=0, le=1e5)] | None = None
    """Frames per second."""
    frequency: Annotated[float, Field(gt=0, le=1e3)] | None = None
    """Hz, nominal."""
    S_base: PowerBase | None = None
    """VA; of the record that is written."""


def load(path: Path | str) -> Map:
    """The map in a TOML file. Raises MapError, a line for each mistake."""
    path = Path(path)
    if not path.is_file():
        raise MapError(f"there is no file {path}; python -m scenarios convert FILE --guess writes a first map")
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise MapError(f"{path} is not TOML: {error}") from error
    return parse(content, str(path))


def open_table(chosen: Map, path: Path) -> Table:
    """The table in a file, as the map says it is written. Raises RecordError."""
    return readers.open_table(path, chosen.file.format, chosen.file.separator, chosen.file.decimal)


def parse(content: dict[str, Any], where: str) -> Map:
    try:
        return Map(**content)
    except ValidationError as error:
        raise MapError("\n".join(dict.fromkeys(f"{where}: {explain(d)}" for d in error.errors()))) from error


TABLES = {
    "V": Voltage,
    "I": Current,
    "P": Power,
    "Q": Power,
    "P_m": MechanicalPower,
    "E_f": FieldVoltage,
    "f": Frequency,
    "time": Time,
    "valid": Valid,
    "file": File,
}


def explain(detail: Any) -> str:
    """One finding of pydantic in the words of a map."""
    place = [str(part) for part in detail["loc"]]
    where, given = ".".join(place), detail["input"]
    match detail["type"]:
        case "missing":
            return f"{where} is missing; add it"
        case "extra_forbidden":
            inside = TABLES.get(place[0], Map) if len(place) > 1 else Map
            known = [field.alias or name for name, field in inside.model_fields.items()]
            return f"{where} is not known; {alternatives(place[-1], known)}"
        case "literal_error":
            return f'{where} = "{given}" is not known; write {detail["ctx"]["expected"]}'.replace("'", '"')
        case "value_error" if isinstance(given, dict):
            return f"{where}: {detail['ctx']['error']}"
        case "value_error":
            return f'{where} = "{given}": {detail["ctx"]["error"]}'
        case "model_type":
            return f'{where} = "{given}": write a table: {{ column = "{given}", ... }}'
    return f"{where} = {given!r}: {detail['msg'].lower()}"
