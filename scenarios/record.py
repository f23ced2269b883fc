"""A recorded file as a source in place of a plant."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from .component import Variable
from .errors import ScenarioError, alternatives
from .expression import Expression
from .records import map as maps
from .records import standard
from .records.conversion import in_memory
from .scenario import Csv

ROUNDING = 1e-6
"""s; a recorded time stamp may be rounded."""

STAMP = Variable("t_frame", "s", causality="output", variability="discrete")


class Record:
    """A recorded file: a standard record, or any that a map reads, or a CSV with expressions of its columns.

    At time t it gives the last row whose time is not after t: a frame is never interpolated. `t_frame` is that row's
    time, if the record does not say otherwise.
    """

    feedthrough: Mapping[str, frozenset[str]] = {}

    def __init__(self, name: str, csv: Csv, folder: Path):
        self.file, self.where = csv.file, f"csv.{name}"
        self.variables: Mapping[str, Variable]
        if csv.time is None:
            self.variables, self.values = of_record(recorded(csv, folder))
        else:
            self.variables, self.values = of_expressions(self.where, csv, csv.time, folder)
        self.times = self.values.pop("time")
        if not np.all(np.diff(self.times) > 0):
            raise ScenarioError(f"{self.where}: the times of {csv.file} do not increase; sort its rows")

    def instantiate(self, label: str) -> "RecordSlave":
        return RecordSlave(self)


def recorded(csv: Csv, folder: Path) -> standard.StandardRecord:
    """The file itself, or what its map makes of it. Raises UserError."""
    path = folder / csv.file
    if csv.map is None:
        return standard.read(path)
    chosen = maps.load(folder / csv.map)
    return in_memory(maps.open_table(chosen, path), chosen, csv.map)


def of_record(record: standard.StandardRecord) -> tuple[dict[str, Variable], dict[str, np.ndarray]]:
    """What the record holds, under the observer's names; lost frames are nan, with frame_valid 0."""
    names = [name for name in standard.COLUMNS if name not in standard.VALUES or record.has(name)]
    kinds = {"frame_valid": "Boolean"}
    variables = {
        name: Variable(name, standard.COLUMNS[name], "output", "discrete", kinds.get(name, "Real"))
        for name in names
        if name != "time"
    }
    return variables, {name: np.asarray(getattr(record, name), dtype=float) for name in names}


def of_expressions(
    where: str, csv: Csv, time: Expression, folder: Path
) -> tuple[dict[str, Variable], dict[str, np.ndarray]]:
    columns = read_columns(folder / csv.file, where)
    for our, formula in {"time": time, **csv.columns}.items():
        for missing in formula.names - columns.keys():
            raise ScenarioError(
                f'{where}: {our} needs a column "{missing}" of {csv.file}; {alternatives(missing, list(columns))}'
            )
    given = {name: column(where, name, formula) for name, formula in csv.columns.items()}
    if column(where, "time", time).unit != "s":
        raise ScenarioError(f'{where}: time is in {time.written_unit}; convert it to seconds: "t/1000 [s]"')
    times = time(columns)
    values = {STAMP.name: times, **{name: formula(columns) for name, formula in csv.columns.items()}, "time": times}
    return {STAMP.name: STAMP, **given}, values


def column(where: str, name: str, formula) -> Variable:
    try:
        return Variable(name, formula.unit({}), causality="output", variability="discrete")
    except ValueError as error:
        raise ScenarioError(f"{where}.{name}: {error}") from error


def read_columns(path: Path, where: str) -> dict[str, np.ndarray]:
    try:
        lines = [line for line in path.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
        names = [name.strip().strip('"') for name in lines[0].split(",")]
        rows = np.loadtxt(lines[1:], delimiter=",", ndmin=2)
        return dict(zip(names, rows.T, strict=True))
    except FileNotFoundError:
        raise ScenarioError(f"{where}: there is no file {path}; give its path from the scenario's folder") from None
    except (IndexError, ValueError) as error:
        raise ScenarioError(f"{where}: {path} is not a table of numbers separated by commas: {error}") from error


class RecordSlave:
    def __init__(self, record: Record):
        self.record = record
        self.time = 0.0

    def set(self, values: Mapping[str, float]) -> None:
        pass  # a record has no inputs

    def enter_initialization(self, stop: float) -> None:
        first, last = self.record.times[[0, -1]]
        if first > ROUNDING or last < stop - ROUNDING:
            raise ScenarioError(
                f"{self.record.where}: {self.record.file} holds {first:g} s to {last:g} s; "
                f"the run is from 0 s to {stop:g} s: change stop, or shift the time"
            )

    def exit_initialization(self) -> None:
        pass

    def get(self, names: Sequence[str]) -> list[float]:
        row = np.searchsorted(self.record.times, self.time + ROUNDING, side="right") - 1
        return [float(self.record.values[name][row]) for name in names]

    def step(self, t: float, h: float) -> None:
        self.time = t + h

    def close(self) -> None:
        pass
