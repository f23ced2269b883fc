"""One FMU over a long record: set a frame, step, get the outputs, straight through the C interface.

A frame stamped t_k comes with the step that ends at t_k, as from a master that steps the PMU first: the outputs then
are the estimate at the frame's own time. FMPy's checked calls cost 8 us a frame; a day has five million.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from ctypes import c_double, c_int, c_size_t, c_void_p
from typing import Any

import numpy as np

from ..errors import UserError, alternatives
from ..fmu import Fmu, FmuSlave
from ..lookup import number
from ..records.standard import StandardRecord

INPUTS = ("t_frame", "V_t", "theta_t", "I_t", "phi_t", "P_t", "Q_t", "P_m", "E_f")
"""Reals, in the order in which they are set; frame_valid is a Boolean."""

DISCARD = 2
"""fmi2Status from which on a call has failed."""


class Observer:
    """An instance of the observer, at time `start`, ready for the first frame."""

    def __init__(self, slave: FmuSlave, outputs: Sequence[str], start: float):
        self.slave, self.outputs, self.time = slave, list(outputs), start
        fmu: Any = slave.slave
        c, reals = fmu.component, [slave.variables[name] for name in INPUTS]
        self.component = c
        self.inputs = references([v.reference for v in reals])
        self.real_outputs = [name for name in self.outputs if slave.variables[name].type == "Real"]
        self.whole_outputs = [name for name in self.outputs if name not in self.real_outputs]
        self.reals = references([slave.variables[name].reference for name in self.real_outputs])
        self.wholes = references([slave.variables[name].reference for name in self.whole_outputs])
        self.valid = references([slave.variables["frame_valid"].reference])
        pointers = [c_void_p, c_void_p, c_size_t, c_void_p]
        self.set_real, self.set_boolean, self.get_real, self.get_integer = (
            function(fmu.dll, name, pointers)
            for name in ("fmi2SetReal", "fmi2SetBoolean", "fmi2GetReal", "fmi2GetInteger")
        )
        self.do_step = function(fmu.dll, "fmi2DoStep", [c_void_p, c_double, c_double, c_int])

    def run(self, record: StandardRecord, P_m: bool, E_f: bool) -> dict[str, np.ndarray]:
        """The outputs after each frame. P_m and E_f: whether these inputs are given."""
        n = len(record)
        given = np.column_stack([record.t_frame if name == "t_frame" else getattr(record, name) for name in INPUTS])
        for name, used in (("P_m", P_m), ("E_f", E_f)):
            if not used:
                given[:, INPUTS.index(name)] = 0.0
        given = np.ascontiguousarray(given)
        reals = np.zeros((n, len(self.real_outputs)))
        wholes = np.zeros((n, len(self.whole_outputs)), dtype=np.int32)
        flags = np.array([0, 1], dtype=np.int32)
        c, do_step, set_real, get_real, get_integer = (
            self.component,
            self.do_step,
            self.set_real,
            self.get_real,
            self.get_integer,
        )
        at, size = given.ctypes.data, given.strides[0]
        out, out_size = reals.ctypes.data, reals.strides[0]
        whole, whole_size = wholes.ctypes.data, wholes.strides[0]
        many, some, few = len(INPUTS), len(self.real_outputs), len(self.whole_outputs)
        inputs, real_outputs, whole_outputs = (a.ctypes.data for a in (self.inputs, self.reals, self.wholes))
        valid, flag, shown, now = self.valid.ctypes.data, flags.ctypes.data, -1, self.time
        failed = 0
        for time, is_valid in zip(record.time.tolist(), record.frame_valid.tolist(), strict=True):
            if is_valid != shown:
                failed |= self.set_boolean(c, valid, 1, flag + 4 * is_valid)
                shown = is_valid
            failed |= set_real(c, inputs, many, at)
            failed |= do_step(c, now, time - now, 1)
            get_real(c, real_outputs, some, out)
            get_integer(c, whole_outputs, few, whole)
            if failed >= DISCARD:
                self._fail(time)
            now, at, out, whole = time, at + size, out + out_size, whole + whole_size
        self.time = now
        found = dict(zip(self.real_outputs, reals.T, strict=True))
        return found | dict(zip(self.whole_outputs, wholes.T.astype(float), strict=True))

    def _fail(self, time: float) -> None:
        said = "; ".join(self.slave.messages) or "it logs no reason"
        raise UserError(f"the FMU refuses the step to {time:.6f} s: {said}")


def references(numbers: Sequence[int]) -> np.ndarray:
    return np.array(numbers, dtype=np.uint32)


def function(library: Any, name: str, arguments: list) -> Any:
    found = library[name]  # a new object: FMPy's own has its checks
    found.argtypes, found.restype = arguments, c_int
    return found


@contextmanager
def observer(fmu: Fmu, parameters: Mapping[str, float], outputs: Sequence[str], start: float) -> Iterator[Observer]:
    """An instance with these parameters, initialised at `start`, s."""
    slave = fmu.instantiate("observer")
    try:
        slave.set(parameters)
        slave.enter_initialization(None, start)
        slave.exit_initialization()
        yield Observer(slave, outputs, start)
    finally:
        slave.close()


def values_of(fmu: Fmu, where: str, given: Mapping[str, Any]) -> dict[str, float]:
    """Parameters as the FMU takes them: items of enumerations by name. Raises UserError for what it does not know."""
    known = {name: v for name, v in fmu.variables.items() if v.causality == "parameter"}
    found = {}
    for name, value in given.items():
        if name not in known:
            raise UserError(f'{where}: the observer has no parameter "{name}"; {alternatives(name, list(known))}')
        variable = known[name]
        if variable.type == "Boolean" and isinstance(value, str) and value.lower() in ("true", "false"):
            value = value.lower() == "true"
        found[name] = number(where, variable, parsed(value))
    return found


def parsed(value: Any) -> Any:
    """A number where a text is one."""
    if not isinstance(value, str):
        return value
    for kind in (int, float):
        try:
            return kind(value)
        except ValueError:
            continue
    return value
