"""What a scenario file may hold.

What can be checked without the FMUs is checked here; names of variables and units are checked in `wiring`.
"""

from collections.abc import Iterable
from fractions import Fraction
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    model_validator,
)

from .errors import alternatives
from .expression import Expression, parse


def plain(value: Any) -> bool | float | str:
    if not isinstance(value, (bool, int, float, str)):
        raise ValueError('write a number, true, false, the name of an item, or a value of the sweep: "{gamma}"')
    return value


def seconds(value: Any) -> Fraction:
    """A time as a fraction: 0.001 is 1/1000 and "1/60" is 1/60, so that no rounding adds up over a run."""
    try:
        time = Fraction(str(value))
    except (ValueError, ZeroDivisionError):
        raise ValueError('write seconds as a number, or as a fraction: "1/60"') from None
    if time < 0:
        raise ValueError("a time must not be negative; the run starts at 0 s")
    return time


def tolerance(value: Any) -> str:
    """A number, or a number of per cent ("1 %")."""
    try:
        float(str(value).removesuffix("%"))
    except ValueError:
        raise ValueError('write a number, or per cent of what is near: "1 %"') from None
    return str(value)


def formula(value: Any) -> Expression:
    if not isinstance(value, str):
        raise ValueError('write an expression as a string: "observer.e1d - plant.e1d"')
    return parse(value)


def flat(value: Any) -> Any:
    """{drem = {gamma = 1}} as {"drem.gamma" = 1}: a dotted name needs no quotes in TOML then."""
    if not isinstance(value, dict):
        return value
    pairs = [(key, flat(inner)) for key, inner in value.items()]
    return {
        f"{key}.{rest}" if rest else key: leaf
        for key, inner in pairs
        for rest, leaf in (inner.items() if isinstance(inner, dict) else [("", inner)])
    }


def listed(value: Any) -> Any:
    return [value] if isinstance(value, str) else value


Value = Annotated[Any, BeforeValidator(plain)]
Values = Annotated[dict[str, Value], BeforeValidator(flat)]
Time = Annotated[Fraction, BeforeValidator(seconds)]
Names = Annotated[list[str], BeforeValidator(listed), Field(min_length=1)]
Formula = Annotated[Expression, BeforeValidator(formula)]


class Table(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, arbitrary_types_allowed=True)


class Fmu(Table):
    """One FMU; with `each`, one instance a value (or a combination of values), all connected alike.

    `rows` is a CSV: one instance a row. Its first column is like a value of `each`, the others are values to fill in.
    """

    model: str
    rows: str | None = None
    each: dict[str, Annotated[list[Value], Field(min_length=1)]] = {}
    parameters: Values = {}
    inputs: Values = {}


class Csv(Table):
    """A recorded file as a source: a standard record; or any that `map` reads, see scenarios/records; or a CSV of
    which `columns` gives our variables as expressions of its columns."""

    file: str
    map: str | None = None
    time: Formula | None = None
    columns: Annotated[dict[str, Formula], BeforeValidator(flat)] = {}

    @model_validator(mode="after")
    def check(self) -> Self:
        if bool(self.columns) != (self.time is not None):
            raise ValueError("time and columns go together; a standard record, or a file with a map, needs neither")
        if self.map and self.columns:
            raise ValueError("give map, or time and columns")
        return self


class Change(Table):
    """At a time, new values for inputs and tunable parameters."""

    at: Time
    set: Values


class Panel(Table):
    """One pair of axes; `log` shows absolute values on a logarithmic scale, `range` is that of the values shown.

    `band` gives to curves the variable that is their standard deviation; twice that is shaded on either side.
    """

    curves: Names
    title: str = ""
    log: bool = False
    range: tuple[float, float] | None = None
    band: Annotated[dict[str, str], BeforeValidator(flat)] = {}

    @model_validator(mode="after")
    def check(self) -> Self:
        for name in self.band.keys() - set(self.curves):
            raise ValueError(f'band: "{name}" is not among the curves; {alternatives(name, self.curves)}')
        return self


class Figure(Table):
    """`facet` is what an `each` or a `rows` sweeps: every panel is drawn once for each of its values."""

    name: str
    title: str
    panel: Annotated[list[Panel], Field(min_length=1)]
    facet: str | None = None
    after: Time = Fraction(0)
    until: Time | None = None


class Expect(Table):
    """What must hold of errors or of variables, at a time or after a time."""

    error: Names | None = None
    variable: Names | None = None
    each: dict[str, Value] = {}
    at: Time | None = None
    after: Time | None = None
    until: Time | None = None
    below: float | None = None
    above: float | None = None
    near: float | None = None
    within: Annotated[str, BeforeValidator(tolerance)] | None = None

    @property
    def references(self) -> list[str]:
        return self.error or self.variable or []

    @model_validator(mode="after")
    def check(self) -> Self:
        self._exactly_one("error", "variable")
        self._exactly_one("at", "after")
        self._exactly_one("below", "above", "near")
        if (self.near is None) != (self.within is None):
            raise ValueError('near and within go together: near = 7.59e-15, within = "1 %"')
        if self.until is not None and (self.after is None or self.until < self.after):
            raise ValueError("until goes with after, and is not before it")
        return self

    def _exactly_one(self, *names: str) -> None:
        given = [name for name in names if getattr(self, name) is not None]
        if len(given) != 1:
            raise ValueError(f"give exactly one of {', '.join(names)}, not {' and '.join(given) or 'none'}")


class Scenario(Table):
    title: str
    description: str = ""
    step: Time
    stop: Time
    parameters: Values = {}
    inputs: Values = {}
    fmu: Annotated[dict[str, Fmu], Field(min_length=1)]
    csv: dict[str, Csv] = {}
    connect: Annotated[dict[str, str], BeforeValidator(flat)] = {}
    change: list[Change] = []
    error: dict[str, Formula] = {}
    at: list[Time] = []
    """The times at which the result table shows the errors; if there are none, the end of the run."""
    figure: list[Figure] = []
    expect: list[Expect] = []

    name: str
    folder: Path

    @model_validator(mode="after")
    def check(self) -> Self:
        if self.step == 0 or self.stop < self.step or (self.stop / self.step).denominator != 1:
            raise ValueError(
                f"step = {float(self.step):g} s does not divide stop = {float(self.stop):g} s; "
                "choose a step above 0 s and a stop that is a whole number of steps"
            )
        for name in self.fmu.keys() & self.csv.keys():
            raise ValueError(f'"{name}" names an FMU and a CSV; rename one of them')
        for name in [*self.fmu, *self.csv, *self.error]:
            if not name.isidentifier():
                raise ValueError(f'"{name}" cannot be a name in an expression; use letters, digits and _')
        for where, time in self._times():
            if time > self.stop:
                stop = f"stop = {float(self.stop):g} s"
                raise ValueError(f"{where} = {float(time):g} s is after the end of the run; lower it, or raise {stop}")
        return self

    def _times(self) -> Iterable[tuple[str, Fraction]]:
        yield from (("at", time) for time in self.at)
        yield from (("change.at", change.at) for change in self.change)
        for key in ("at", "after", "until"):
            yield from ((f"expect.{key}", time) for e in self.expect if (time := getattr(e, key)) is not None)

    def index(self, time: Fraction) -> int:
        """Of the communication point nearest to a time."""
        return round(time / self.step)

    def time(self, index: int) -> float:
        """Of a communication point, s."""
        return float(index * self.step)
