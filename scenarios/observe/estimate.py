"""What an observer makes of a record: settings from the record and its machine, and what is told of the estimate."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ..errors import UserError
from ..fmu import Fmu
from ..machines.table import Machine
from ..records.standard import Facts, StandardRecord
from .cosimulation import values_of

CAPTURING, TRACKING, HOLDING = 1, 2, 3
"""Of `status`."""

MEASURED, ESTIMATED = 1, 2
"""Items of field_voltage and mechanical_power."""

OUT_OF_BAND = 3.0
"""Standard deviations beyond which an innovation is marked: one in 370 of a right model."""

STATES = ("delta", "load_angle", "omega", "e1d", "e1q", "e2d", "e2q", "E_f_hat", "P_m_hat")
STD = {
    "delta": "delta_std",
    "load_angle": "delta_std",
    "omega": "omega_std",
    "e1d": "e1d_std",
    "e1q": "e1q_std",
    "E_f_hat": "E_f_std",
    "P_m_hat": "P_m_std",
}
JUDGES = ("innovation", "angle_innovation", "power_mismatch")

KEPT = 20_000
"""Frames that a figure needs; of a longer record every so many are kept."""


def settings(
    fmu: Fmu, machine: Machine, facts: Facts, rate: float, record: StandardRecord, given: Mapping[str, str]
) -> dict[str, float]:
    """Parameters of the observer: the machine's, the record's, what was not recorded is estimated; `given` beats all.

    Raises UserError for what this FMU has no parameter for.
    """
    chosen = {name.strip(): value for name, value in given.items()}
    of_machine = dict(machine.parameters)
    if "machine_model" not in fmu.variables:
        if of_machine["machine_model"] != "two_axis" and chosen.pop("machine_model", None) != "two_axis":
            model = of_machine["machine_model"]
            raise UserError(
                f"{machine.unit}: this FMU has the two-axis machine only, not {model}; "
                "--set machine_model=two_axis takes it for one, which is an approximation"
            )
        chosen.pop("machine_model", None)
        two_axis = ("S_n", "omega_s", "H", "D", "xd", "xd1", "xq", "xq1", "Td10", "Tq10", "Ra")
        beyond = {n for n, v in of_machine.items() if n not in two_axis and v}
        of_machine = {n: v for n, v in of_machine.items() if n in two_axis or (n in fmu.variables and n in TRANSFORMER)}
        missing = [n for n in two_axis if n not in of_machine]
        if missing:
            raise UserError(f"{machine.unit}: the two-axis machine needs {', '.join(missing)}; --set gives them")
        lost = sorted(beyond & TRANSFORMER - fmu.variables.keys())
        if lost:
            raise UserError(f"{machine.unit}: this FMU has no parameter {', '.join(lost)}")
    values: dict[str, object] = {
        **of_machine,
        "S_base": facts.S_base,
        "frame_period": 1 / rate,
        "frame_time": "stamped",
        "power_source": "inputs",
        "mechanical_power": "measured" if record.has("P_m") else "estimated",
        "field_voltage": "measured" if record.has("E_f") else "estimated",
    }
    return values_of(fmu, "--set", {**values, **chosen})


TRANSFORMER = {"x_T", "r_T", "tap", "shift"}


def outputs_of(fmu: Fmu, parameters: Mapping[str, float]) -> list[str]:
    """The outputs that say something: no copies of inputs, no states that the model has not."""
    hidden = set()
    if parameters["field_voltage"] == MEASURED:
        hidden.add("E_f_hat")
    if parameters["mechanical_power"] == MEASURED:
        hidden.add("P_m_hat")
    states = [n for n in STATES if n in fmu.variables and n not in hidden]
    deviations = [STD[n] for n in states if n in STD]
    judges = [n for n in JUDGES if n in fmu.variables]
    return [*states, *dict.fromkeys(deviations), *judges, "status"]


@dataclass
class Estimate:
    """What is told of an estimate, whatever its length: counts over all frames, and KEPT of them for figures."""

    units: Mapping[str, str]
    frames: int = 0
    by_status: np.ndarray = field(default_factory=lambda: np.zeros(4, dtype=np.int64))
    captured: float | None = None
    """s; the first frame at which status is 2."""
    squares: dict[str, float] = field(default_factory=dict)
    """Sums over the frames that track, of the judges."""
    beyond: dict[str, int] = field(default_factory=dict)
    """Frames that track and whose innovation is out of band."""
    kept: list[dict[str, np.ndarray]] = field(default_factory=list)

    def add(self, record: StandardRecord, shown: Mapping[str, np.ndarray], every: int) -> None:
        status = shown["status"].astype(int)
        tracking = (status == TRACKING) | (status == HOLDING)
        if self.captured is None and (status == TRACKING).any():
            self.captured = float(record.time[np.argmax(status == TRACKING)])
        self.frames += len(record)
        self.by_status += np.bincount(status, minlength=4)
        fresh = status == TRACKING
        for name in JUDGES:
            if name in shown:
                found = shown[name][fresh]
                self.squares[name] = self.squares.get(name, 0.0) + float(np.sum(found**2))
                self.beyond[name] = self.beyond.get(name, 0) + int(np.sum(np.abs(found) > OUT_OF_BAND))
        marks = np.zeros(len(record), dtype=bool)
        for name in ("innovation", "angle_innovation"):
            if name in shown:
                marks |= tracking & (np.abs(shown[name]) > OUT_OF_BAND)
        some = slice(None, None, every)
        self.kept.append({n: v[some].copy() for n, v in {"time": record.time, **shown, "marks": marks}.items()})

    @property
    def series(self) -> dict[str, np.ndarray]:
        return {name: np.concatenate([piece[name] for piece in self.kept]) for name in self.kept[0]}

    def share(self, status: int) -> float:
        return float(self.by_status[status]) / max(self.frames, 1)

    def rms(self, name: str) -> float:
        return float(np.sqrt(self.squares.get(name, 0.0) / max(self.by_status[TRACKING], 1)))

    def medians(self) -> dict[str, tuple[float, float]]:
        """Median value and standard deviation of each state, over the frames that track."""
        series = self.series
        tracking = series["status"] == TRACKING
        if not tracking.any():
            return {}
        found = {}
        for name in STATES:
            if name in series:
                std = series.get(STD.get(name, ""), np.zeros(len(tracking)))
                found[name] = float(np.median(series[name][tracking])), float(np.median(std[tracking]))
        return found
