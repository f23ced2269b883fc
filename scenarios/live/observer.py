"""One machine's observer FMU, stepped from frame to frame.

The communication points lie a period after the frames: the frame at t is taken, and the outputs are the estimate at
t + h. A frame that is missing is a step without one. An FMU that fails is put aside and started anew; the other
machines do not notice.
"""

import cmath
from collections.abc import Mapping
from math import isfinite, nan
from typing import Any, NamedTuple

from ..component import Component
from ..errors import ScenarioError, alternatives
from ..lookup import number
from ..machines.table import Machine as MachineData
from .channels import Frame


class Output(NamedTuple):
    name: str
    unit: str
    deviation: str = ""
    """The output that is its standard deviation."""


OUTPUTS = (
    Output("delta", "rad", "delta_std"),
    Output("load_angle", "rad"),
    Output("omega", "rad/s", "omega_std"),
    Output("e1d", "pu", "e1d_std"),
    Output("e1q", "pu", "e1q_std"),
    Output("E_f_hat", "pu", "E_f_std"),
    Output("P_m_hat", "pu", "P_m_std"),
    Output("delta_std", "rad"),
    Output("omega_std", "rad/s"),
    Output("e1d_std", "pu"),
    Output("e1q_std", "pu"),
    Output("E_f_std", "pu"),
    Output("P_m_std", "pu"),
    Output("innovation", "1"),
    Output("angle_innovation", "1"),
    Output("power_mismatch", "1"),
    Output("status", "1"),
)
"""What is handed out, in this order."""

NAMES = tuple(output.name for output in OUTPUTS)

WAITING, TRACKING = 0, 2

NOTHING = (nan,) * (len(NAMES) - 1) + (float(WAITING),)

REST = 5.0
"""s, after which an FMU that failed is started anew."""

OF_THE_SERVICE: dict[str, float | str] = {
    "power_source": "phasors",
    "frame_time": "stamped",
    "field_voltage": "estimated",
    "mechanical_power": "estimated",
}
"""What follows from how it is run; live.toml may say otherwise."""


def parameters_of(
    component: Component, data: MachineData, given: Mapping[str, Any], measured: set[str], period: float
) -> dict[str, float]:
    """The parameters of one machine's observer, as the FMU takes them. Raises ScenarioError."""
    chosen = {**OF_THE_SERVICE, "frame_period": period, "S_base": data["S_n"], **data.parameters}
    for name, mode in (("P_m", "mechanical_power"), ("E_f", "field_voltage")):
        if name in measured:
            chosen[mode] = "measured"
    known = {name: v for name, v in component.variables.items() if v.causality == "parameter"}
    optional = OF_THE_SERVICE.keys() | ({"machine_model"} if data.model == "two_axis" else set())
    chosen = {name: value for name, value in chosen.items() if name in known or name not in optional} | dict(given)
    for name in chosen:
        if name not in known:
            raise ScenarioError(f'{data.unit}: the FMU has no parameter "{name}"; {alternatives(name, list(known))}')
    return {name: number(data.unit, known[name], whole(known[name], value)) for name, value in chosen.items()}


def whole(variable, value):
    return int(value) if variable.type == "Integer" and isinstance(value, float) and value.is_integer() else value


class Observer:
    """Estimates of one machine; `failure` says why there are none."""

    def __init__(self, component: Component, label: str, parameters: Mapping[str, float], period: float):
        self.component, self.label, self.parameters, self.period = component, label, parameters, period
        has = component.variables
        self.stamped = "t_frame" in has
        self.names = [name for name in NAMES if name in has]
        self.places = [NAMES.index(name) for name in self.names]
        self.slave: Any = None
        self.origin = self.t = 0.0
        self.failure = ""
        self.failed_at = 0.0
        self.failures = 0

    def estimate(self, t: float, frame: Frame, valid: bool, anew: bool) -> tuple[float, ...]:
        """The estimate a period after t, the time of the frame, in the order of OUTPUTS. s, continuous.

        `anew`: how long it is after the last frame is not known.
        """
        if self.failure and t < self.failed_at + REST and t >= self.failed_at:
            return NOTHING
        try:
            if self.slave is None or anew or self.failure:
                self.start(t)
            self.catch_up(t)
            return self.step(t, frame, valid)
        except ScenarioError as error:
            self.fail(t, str(error))
        except Exception as error:  # whatever it is, it is this machine's
            self.fail(t, f"{type(error).__name__}: {error}")
        return NOTHING

    def start(self, t: float) -> None:
        self.close()
        self.failure = ""
        self.origin, self.t = t, 0.0
        self.slave = self.component.instantiate(self.label)
        self.slave.set(self.parameters)
        self.slave.enter_initialization(1e9)
        self.slave.set({"frame_valid": 0.0})
        self.slave.exit_initialization()

    def catch_up(self, t: float) -> None:
        """A step for each frame that is missing before the one at t."""
        while t - self.origin - self.t > self.period / 2:
            self.slave.set({"frame_valid": 0.0})
            self.slave.step(self.t, self.period)
            self.t += self.period

    def step(self, t: float, frame: Frame, valid: bool) -> tuple[float, ...]:
        good = valid and cmath.isfinite(frame.V) and cmath.isfinite(frame.I)
        inputs = {"frame_valid": float(good)}
        if good:
            S = frame.V * frame.I.conjugate()
            inputs["V_t"], inputs["theta_t"] = cmath.polar(frame.V)
            inputs["I_t"], inputs["phi_t"] = cmath.polar(frame.I)
            inputs["P_t"], inputs["Q_t"] = S.real, S.imag
            if self.stamped:
                inputs["t_frame"] = t - self.origin
            for name, value in (("P_m", frame.P_m), ("E_f", frame.E_f)):
                if isfinite(value):
                    inputs[name] = value  # else the last one stays
        self.slave.set(inputs)
        h = t - self.origin + self.period - self.t
        self.slave.step(self.t, h)
        self.t += h
        values = [0.0] * len(NAMES)
        for place, value in zip(self.places, self.slave.get(self.names), strict=True):
            values[place] = value
        return tuple(values)

    def fail(self, t: float, failure: str) -> None:
        self.failure, self.failed_at = failure, t
        self.failures += 1
        self.close()

    def close(self) -> None:
        slave, self.slave = self.slave, None
        if slave is not None:
            slave.close()
