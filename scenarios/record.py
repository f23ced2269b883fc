"""A recorded CSV as a source in place of a plant."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from .component import Variable
from .errors import ScenarioError, alternatives
from .scenario import Csv

ROUNDING = 1e-6
"""s; a recorded time stamp may be rounded."""

STAMP = Variable("t_frame", "s", causality="output", variability="discrete")


class Record:
    """A CSV file: lines that begin with # are comments, the first other line names the columns.

    At time t it gives the last row whose time is not after t: a frame is never interpolated. `t_frame` is that row's
    time, if no column says otherwise.
    """

    feedthrough: frozenset[str] = frozenset()

    def __init__(self, name: str, csv: Csv, folder: Path):
        where = f"csv.{name}"
        columns = read_columns(folder / csv.file, where)
        for our, formula in {"time": csv.time, **csv.columns}.items():
            for missing in formula.names - columns.keys():
                raise ScenarioError(
                    f'{where}: {our} needs a column "{missing}" of {csv.file}; {alternatives(missing, list(columns))}'
                )
        given = {name: column(where, name, formula) for name, formula in csv.columns.items()}
        self.variables: Mapping[str, Variable] = {STAMP.name: STAMP, **given}
        if column(where, "time", csv.time).unit != "s":
            raise ScenarioError(f'{where}: time is in {csv.time.written_unit}; convert it to seconds: "t/1000 [s]"')
        self.times = csv.time(columns)
        self.values = {STAMP.name: self.times, **{name: formula(columns) for name, formula in csv.columns.items()}}
        if not np.all(np.diff(self.times) > 0):
            raise ScenarioError(f"{where}: the times of {csv.file} do not increase; sort its rows")
        self.file, self.where = csv.file, where

    def instantiate(self, label: str) -> "RecordSlave":
        return RecordSlave(self)


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
