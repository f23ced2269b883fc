"""The project's standard record: PMU frames of one machine in pu and rad, on a whole raster of times.

A CSV. Comment lines say what the numbers are on, the header names the observer's inputs, and each period of the frame
rate has a row; where no frame came its values are `nan` and `frame_valid` is 0:

    # pmu-observer record
    # utc_start = 2024-05-01T12:00:00.016666667Z
    # rate = 60 frames/s
    # f0 = 60 Hz
    # S_base = 100 MVA
    # V_base = 22 kV
    time,t_frame,frame_valid,V_t,theta_t,I_t,phi_t,P_t,Q_t,P_m,E_f
    0.000000000,0.000000000,1,1.0493000000,0.0982627982,...

How to use it:

    record = standard.read("record.csv")     # the whole record, as numpy arrays
    record.V_t, record.theta_t               # one value a frame
    record.frame_valid                       # bool: False where no usable frame came, and all values are nan
    record.has("E_f")                        # False: the column is all nan, it was not recorded
    record.V, record.I                       # complex phasors, pu; V conj(I) = P + jQ generated
    record.rate, record.f0, record.S_base, record.utc_start

Any CSV with these column names is read; only time, V_t, theta_t, I_t and phi_t must be there.
"""

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from io import StringIO
from itertools import dropwhile
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np

from ..errors import UserError, alternatives
from .digits import table_text

COLUMNS: dict[str, str] = {
    "time": "s",
    "t_frame": "s",
    "frame_valid": "1",
    "V_t": "pu",
    "theta_t": "rad",
    "I_t": "pu",
    "phi_t": "rad",
    "P_t": "pu",
    "Q_t": "pu",
    "P_m": "pu",
    "E_f": "pu",
    "f": "Hz",
}
"""Names and units: those of the observer's inputs, after the time; and the PMU's frequency, for the checks."""

VALUES = ("V_t", "theta_t", "I_t", "phi_t", "P_t", "Q_t", "P_m", "E_f", "f")
NEEDED = ("time", "V_t", "theta_t", "I_t", "phi_t")

FIRST_LINE = "# pmu-observer record"

DECIMALS = {"frame_valid": 0, "time": 9, "t_frame": 9}
VALUE_DECIMALS = 10
"""Times to the nanosecond, values to 1e-10 pu and rad."""


class RecordError(UserError):
    """What is wrong with a record, and what to do about it."""


@dataclass(frozen=True)
class Facts:
    """What a record is on. None: not known."""

    S_base: float = 100.0
    """MVA; base of I, P, Q and P_m."""
    rate: float | None = None
    """Frames per second."""
    f0: float | None = None
    """Hz; nominal frequency, that of the frame of the angles."""
    V_base: float | None = None
    """kV line-line; base of V."""
    utc_start: str | None = None
    """UTC at time = 0, ISO 8601 with a Z."""
    source: str | None = None
    """The file that it was converted from."""


@dataclass(frozen=True)
class StandardRecord:
    """A record in memory: arrays of one length, pu and rad, in the order of time."""

    time: np.ndarray
    """s, from 0 on."""
    t_frame: np.ndarray
    """s; when the frame was measured."""
    frame_valid: np.ndarray
    """bool; False where no usable frame came: all its values are nan."""
    V_t: np.ndarray
    theta_t: np.ndarray
    I_t: np.ndarray
    phi_t: np.ndarray
    P_t: np.ndarray
    Q_t: np.ndarray
    P_m: np.ndarray
    E_f: np.ndarray
    f: np.ndarray
    facts: Facts = field(default_factory=Facts)

    def __len__(self) -> int:
        return len(self.time)

    def has(self, name: str) -> bool:
        """Whether a column was recorded at all."""
        return not bool(np.all(np.isnan(getattr(self, name))))

    @property
    def V(self) -> np.ndarray:
        """Terminal voltage, complex, pu."""
        return self.V_t * np.exp(1j * self.theta_t)

    @property
    def I(self) -> np.ndarray:  # noqa: E743 - the usual name
        """Terminal current, complex, pu, generator convention."""
        return self.I_t * np.exp(1j * self.phi_t)

    @property
    def S_base(self) -> float:
        """MVA."""
        return self.facts.S_base

    @property
    def f0(self) -> float | None:
        """Hz."""
        return self.facts.f0

    @property
    def utc_start(self) -> str | None:
        return self.facts.utc_start

    @property
    def rate(self) -> float:
        """Frames per second: as the file says, or from the median of the steps."""
        return self.facts.rate or 1 / float(np.median(np.diff(self.time)))


def read(path: Path | str) -> StandardRecord:
    """The record in a CSV file. Raises RecordError, naming the file and what to do."""
    path = Path(path)
    if not path.is_file():
        raise RecordError(f"there is no file {path}")
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except UnicodeDecodeError:
        raise RecordError(f"{path} is no text; {CONVERT}") from None
    facts = read_facts(lines, path)
    body = list(dropwhile(lambda line: line.startswith("#") or not line.strip(), lines))
    if not body:
        raise RecordError(f"{path} is empty")
    names = [name.strip().strip('"') for name in body[0].split(",")]
    missing = [name for name in NEEDED if name not in names]
    if missing:
        raise RecordError(f'{path} has no column "{missing[0]}"; {alternatives(missing[0], names)}; {CONVERT}')
    table = read_rows(path, body[1:], [names.index(name) for name in COLUMNS if name in names])
    found = dict(zip([name for name in COLUMNS if name in names], table.T, strict=True))
    record = assemble(found, facts, path)
    if len(record) < 2:
        raise RecordError(f"{path} holds {len(record)} rows: too few to observe anything")
    return record


CONVERT = "python -m scenarios convert makes a standard record of other files"


def read_rows(path: Path, rows: Sequence[str], columns: Sequence[int]) -> np.ndarray:
    if not rows:
        raise RecordError(f"{path} has a header and no rows")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # rows of comments only: found below
            return np.loadtxt(rows, delimiter=",", usecols=columns, ndmin=2)
    except ValueError as error:
        raise RecordError(f"{path} is not a table of numbers separated by commas: {error}; {CONVERT}") from None


def assemble(found: Mapping[str, np.ndarray], facts: Facts, path: Path | str = "the record") -> StandardRecord:
    """A record from the columns that there are. P and Q follow from the phasors where they are missing."""
    time = found["time"]
    bad = np.flatnonzero(~(np.diff(time) > 0))
    if len(bad):
        raise RecordError(f"{path}: time does not increase after {time[bad[0]]:.6f} s; {CONVERT}")
    absent = np.full(len(time), np.nan)
    values = {name: np.array(found.get(name, absent), dtype=float) for name in VALUES}
    lag = values["theta_t"] - values["phi_t"]
    for name, part in (("P_t", np.cos), ("Q_t", np.sin)):
        if name not in found:
            values[name] = values["V_t"] * values["I_t"] * part(lag)
    phasors = np.all([np.isfinite(values[name]) for name in ("V_t", "theta_t", "I_t", "phi_t")], axis=0)
    valid = phasors & (found["frame_valid"] > 0) if "frame_valid" in found else phasors
    for value in values.values():
        value[~valid] = np.nan
    t_frame = found.get("t_frame", time)
    return StandardRecord(time, np.where(np.isfinite(t_frame), t_frame, time), valid, **values, facts=facts)


def read_facts(lines: Sequence[str], path: Path) -> Facts:
    """The comment lines `# name = value unit`."""
    given = {}
    for line in lines:
        if not line.startswith("#"):
            break
        name, equals, value = line[1:].partition("=")
        if equals and name.strip() in Facts.__dataclass_fields__:
            given[name.strip()] = value.strip()
    for name in given.keys() & {"S_base", "rate", "f0", "V_base"}:
        try:
            given[name] = float(given[name].split()[0])
        except (ValueError, IndexError):
            raise RecordError(f"{path}: # {name} = {given[name]}: write a number and its unit") from None
    return Facts(**given)


class Writer:
    """Writes a standard record piece by piece into a file that appears once all is written.

    `columns` are those that were recorded. On an error nothing is left.
    """

    def __init__(self, path: Path, facts: Facts, columns: Sequence[str]):
        self.path, self.part = path, path.with_name(path.name + ".part")
        self.columns = [name for name in COLUMNS if name in columns]
        self.decimals = [DECIMALS.get(name, VALUE_DECIMALS) for name in self.columns]
        self.facts = facts

    def __enter__(self) -> Self:
        self.file = self.part.open("wb")
        self.file.write((head(self.facts) + ",".join(self.columns) + "\n").encode())
        return self

    def write(self, values: Mapping[str, np.ndarray]) -> None:
        """Rows; one array a column, all of one length."""
        self.file.write(table_text([values[name] for name in self.columns], self.decimals))

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.file.close()
        if kind is None:
            self.part.replace(self.path)
        else:
            self.part.unlink()


def head(facts: Facts) -> str:
    lines = StringIO()
    print(FIRST_LINE, file=lines)
    units = {"source": "", "utc_start": "", "rate": " frames/s", "f0": " Hz", "S_base": " MVA", "V_base": " kV"}
    for name, unit in units.items():
        value = getattr(facts, name)
        if value is not None:
            print(f"# {name} = {f'{value:.12g}' if isinstance(value, float) else value}{unit}", file=lines)
    return lines.getvalue()


def write(record: StandardRecord, path: Path | str) -> None:
    """A whole record into a file."""
    columns = [name for name in COLUMNS if name not in VALUES or record.has(name)]
    with Writer(Path(path), record.facts, columns) as writer:
        writer.write({name: getattr(record, name) for name in columns})
