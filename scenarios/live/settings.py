"""live.toml: which streams, which of their channels are which machine's, and where the estimates go.

    machines = "machines.csv"                      # data of the machines, a row a unit: see scenarios/machines

    [[stream]]
    host = "127.0.0.1"
    port = 4712
    idcode = 39

    [[machine]]
    unit = "G6"                                    # its row in machines.csv
    station = "G6"
    V = { phasor = "V1", base = "20 kV line-line" }
    I = { phasor = "I1" }

    [c37118]
    port = 4713

README.md of this folder tells every key.
"""

import tomllib
from collections import Counter
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError, model_validator

from ..errors import UserError, alternatives
from ..records import units
from ..records.map import Direction, Names, Turn, VoltageBase
from .server import LOCAL, Address
from .session import TIME_ERROR


class SettingsError(UserError):
    """What is wrong with a live.toml, and what to do about it."""


def address(value: Any) -> Address:
    """`10.0.0.7:4713`."""
    host, colon, port = str(value).rpartition(":")
    if not colon or not host or not port.isdecimal() or not 0 < int(port) < 65536:
        raise ValueError('write host and port: "10.0.0.7:4713"')
    return Address(host, int(port))


Port = Annotated[int, Field(ge=0, le=65535)]
Idcode = Annotated[int, Field(ge=1, le=65534)]
To = Annotated[Address, BeforeValidator(address)]


class Part(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, populate_by_name=True)


class Stream(Part):
    """A PMU or PDC to listen to."""

    name: str = ""
    host: str
    port: Annotated[int, Field(ge=1, le=65535)]
    idcode: Idcode
    transport: Literal["tcp", "udp", "udp_spontaneous"] = "tcp"
    configuration: Literal[2, 3] = 2
    time_error: Annotated[float, Field(gt=0, le=10)] = TIME_ERROR
    """s; frames of a clock that may be farther off are not used."""

    @property
    def label(self) -> str:
        return self.name or f"{self.host}:{self.port}"


class Voltage(Part):
    """Of the positive sequence, or of the three phases."""

    phasor: Names = ["V1"]
    base: VoltageBase | None = None
    """V line-line; without it V_n of machines.csv."""
    is_: Annotated[Literal["line-neutral", "line-line", "AB"], Field(alias="is")] = "line-neutral"
    ratio: Annotated[float, Field(gt=0)] = 1.0
    """Of the voltage transformer, where the phasors are secondary ones."""
    shift: Turn = 0.0
    """rad; is added to the angle."""


class Current(Part):
    phasor: Names = ["I1"]
    direction: Direction = "out of the generator"
    ratio: Annotated[float, Field(gt=0)] = 1.0
    """Of the current transformer, where the phasors are secondary ones."""
    shift: Turn = 0.0


class Analog(Part):
    """An analog channel with P_m or E_f."""

    analog: str
    unit: str = "pu"
    base: str | None = None
    """Of a P_m in pu ("900 MVA"; without it S_n), and of an E_f that is not in pu ("230 V")."""


class Machine(Part):
    unit: str
    stream: str = ""
    station: str | int | None = None
    """Its name, or its IDCODE; without it the stream has one station."""
    V: Voltage = Voltage()
    I: Current = Current()  # noqa: E741 - the usual name
    P_m: Analog | None = None
    E_f: Analog | None = None
    parameters: dict[str, bool | int | float | str] = {}
    """Of the observer, beside or in place of those of machines.csv."""

    @model_validator(mode="after")
    def check(self) -> Self:
        for name, analog, quantities in (
            ("P_m", self.P_m, ("active power", "per unit")),
            ("E_f", self.E_f, ("voltage", "current", "per unit")),
        ):
            if analog is None:
                continue
            unit = units.unit_of(analog.unit, *quantities)
            if analog.base is not None:
                units.amount(analog.base, *(("apparent power",) if name == "P_m" else quantities))
            elif name == "E_f" and unit.quantity != "per unit":
                raise ValueError(f'E_f in {unit.symbol} needs its base: base = "230 {unit.symbol}"')
        return self


class C37118(Part):
    """The estimates as a C37.118 stream."""

    port: Port
    idcode: Idcode = 1000
    host: str = LOCAL
    send_to: list[To] = []
    """UDP without being asked."""


class Csv(Part):
    """The estimates as files that rotate."""

    folder: str
    minutes: Annotated[float, Field(gt=0, le=1440)] = 60.0
    keep: Annotated[int, Field(ge=1)] = 48
    """Files; older ones are deleted."""
    every: Annotated[int, Field(ge=1)] = 1
    """Estimate that is written: every one, every second one, ..."""


class Metrics(Part):
    """/metrics for Prometheus."""

    port: Port
    host: str = LOCAL


class Settings(Part):
    stream: Annotated[list[Stream], Field(min_length=1)]
    machines: str
    machine: Annotated[list[Machine], Field(min_length=1, max_length=1000)]
    fmu: str = "native"
    """native, python, or the path of an FMU."""
    parameters: dict[str, bool | int | float | str] = {}
    """Of every observer."""
    c37118: C37118 | None = None
    csv: Csv | None = None
    metrics: Metrics | None = None

    path: Path

    @model_validator(mode="after")
    def check(self) -> Self:
        labels = [stream.label for stream in self.stream]
        for what, names in (("streams", labels), ("machines", [machine.unit for machine in self.machine])):
            for name, count in Counter(names).items():
                if count > 1:
                    raise ValueError(f'{count} {what} are called "{name}"; give each its own name')
        for machine in self.machine:
            if machine.stream and machine.stream not in labels:
                raise ValueError(
                    f'machine {machine.unit}: there is no stream "{machine.stream}"; '
                    f"{alternatives(machine.stream, labels)}"
                )
            if not machine.stream and len(labels) > 1:
                raise ValueError(f'machine {machine.unit}: say of which stream: stream = "{labels[0]}"')
        return self

    def stream_of(self, machine: Machine) -> Stream:
        return next(s for s in self.stream if machine.stream in ("", s.label))

    def beside(self, name: str) -> Path:
        """A path that is meant from the folder of live.toml."""
        return self.path.parent / name


TABLES: dict[str, type[Part]] = {
    "stream": Stream,
    "machine": Machine,
    "V": Voltage,
    "I": Current,
    "P_m": Analog,
    "E_f": Analog,
    "c37118": C37118,
    "csv": Csv,
    "metrics": Metrics,
}


def load(path: Path | str) -> Settings:
    """The settings in a TOML file. Raises SettingsError, a line for each mistake."""
    path = Path(path)
    if not path.is_file():
        raise SettingsError(f"there is no file {path}; scenarios/live/README.md shows one")
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8"))
        return Settings(**{**content, "path": path})
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise SettingsError(f"{path} is not TOML: {error}") from error
    except ValidationError as error:
        raise SettingsError("\n".join(dict.fromkeys(f"{path}: {explain(d)}" for d in error.errors()))) from error


def explain(detail: Any) -> str:
    """One finding of pydantic in the words of a live.toml."""
    place, given = detail["loc"], detail["input"]
    where = ".".join(str(part + 1) if isinstance(part, int) else part for part in place)
    match detail["type"]:
        case "missing":
            return f"{where} is missing; add it"
        case "extra_forbidden":
            inside = [TABLES[part] for part in place[:-1] if part in TABLES]
            known = (inside[-1] if inside else Settings).model_fields.items()
            names = [field.alias or name for name, field in known if name != "path"]
            return f"{where} is not known; {alternatives(str(place[-1]), names)}"
        case "literal_error":
            return f"{where} = {given!r} is not known; write {detail['ctx']['expected']}".replace("'", '"')
        case "value_error" if not place or isinstance(given, dict):
            return f"{where + ': ' if where else ''}{detail['ctx']['error']}"
        case "value_error":
            return f"{where} = {given!r}: {detail['ctx']['error']}"
        case "model_type":
            return f"{where} = {given!r}: write a table: {{ ... }}"
    return f"{where} = {given!r}: {detail['msg'].lower()}"
