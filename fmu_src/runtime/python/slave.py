"""Any model as a pythonfmu slave, on Python floats.

What pythonfmu leaves to the slave, or would turn into fmi2Fatal, is settled here: the call sequence, ranges, complete
states, and that no exception escapes. Its wrapper cannot return fmi2Error: what is wrong is logged, and a step that
cannot be done is discarded.
"""

from __future__ import annotations

import struct
from math import ceil, inf, isfinite
from typing import Any, Callable
from zlib import crc32

from ...pmu_observer import tree
from ...pmu_observer.carriers import floats
from ...pmu_observer.clock import EPSILON
from ...pmu_observer.interface import broken, describe, range_errors
from .. import choices
from ..model import ON_TIME, Model, Program
from ..ports import kind_of, ports

INSTANTIATED, INITIALIZATION, STEP, FAILED, TERMINATED = range(5)
PHASES = (
    "instantiated",
    "in initialization mode",
    "in step mode",
    "in step mode after a step that failed",
    "terminated",
)
STATUS_DISCARD, STATUS_ERROR = 2, 3
HEADER = struct.Struct("<8s32sB?ddII")
"""Magic, hash of the FMU, phase, outdated, time, stop time, numbers of values and of state leaves."""
MAGIC = b"pmuobs02"
CHECKSUM = struct.Struct("<I")


class ModelSlave:
    """Mixed with pythonfmu's Fmi2Slave into the class of one FMU, which names its `model` and its `digest`.

    `values` holds every variable; the value reference is the index: inputs, then parameters, then outputs.
    """

    model: Model
    digest: str
    log: Callable[..., None]  # of Fmi2Slave

    def __init_subclass__(cls, **kwargs):
        super().__init_subclass__(**kwargs)
        cls.ports = ports(cls.model)
        cls.kinds = [kind_of(port.variable.specification) for port in cls.ports]
        cls.starts = [port.variable.start for port in cls.ports]
        cls.end_of_inputs = len(tree.leaves(cls.model.inputs))
        cls.all_parameters = choices.parameters(cls.model)
        cls.end_of_parameters = cls.end_of_inputs + len(tree.leaves(cls.all_parameters))

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.values: list[Any] = list(self.starts)
        self.phase = INSTANTIATED
        self.time = 0.0
        self.stop_time = inf
        self.state: Any = None
        self.program: Program = next(iter(self.model.programs.values()))
        self.parameters = self.model.parameters
        self.refused: list[str] = []
        self.outdated = True  # an input or a parameter has been set since the outputs were calculated

    # Getting and setting -------------------------------------------------------------------------------------------

    def get_real(self, references):
        return [float(value) for value in self._get("Real", references)]

    def get_integer(self, references):
        return [int(value) for value in self._get("Integer", references)]

    def get_boolean(self, references):
        return [bool(value) for value in self._get("Boolean", references)]

    def get_string(self, references):
        return [str(value) for value in self._get("String", references)]

    def set_real(self, references, values):
        self._set("Real", references, values)

    def set_integer(self, references, values):
        self._set("Integer", references, values)

    def set_boolean(self, references, values):
        self._set("Boolean", references, values)

    def set_string(self, references, values):
        self._set("String", references, values)

    def _get(self, kind, references):
        self._expect((INITIALIZATION, STEP, FAILED, TERMINATED), f"fmi2Get{kind}")
        if self.outdated and any(i >= self.end_of_parameters for i in references):
            if self.phase == INITIALIZATION:
                self._start()
            elif self.phase == STEP:
                self._recalculate()
        return [self.values[i] if self._has(kind, i) else 0 for i in references]

    def _set(self, kind, references, values):
        if not self._expect((INSTANTIATED, INITIALIZATION, STEP), f"fmi2Set{kind}"):
            return
        for i, value in zip(references, values):
            if self._has(kind, i) and self._may_set(i, value):
                self.values[i] = value if self.kinds[i] == "Real" else int(value)
                self.outdated = True
                if i >= self.end_of_inputs and self.phase == STEP:
                    self._read_parameters()

    def _has(self, kind, i):
        # some importers set and read every variable as a Real
        if 0 <= i < len(self.kinds) and kind in (self.kinds[i], "Real"):
            return True
        self._error(f"there is no {kind} variable with value reference {i}")
        return False

    def _may_set(self, i, value):
        (name, specification, _), causality, variability = self.ports[i]
        logical = self.kinds[i] == "Boolean" and value not in (0, 1)
        if self.kinds[i] != "Real" and (value % 1 != 0 or logical):
            self._error(f"{name} = {value:.12g} is not allowed, and ignored; it must be in {describe(specification)}")
            return False
        if i < self.end_of_inputs:
            return True
        if causality == "output" or (self.phase == STEP and variability == "fixed"):
            self._error(f"{name} ({variability} {causality}) cannot be set while the slave is {PHASES[self.phase]}")
            return False
        low, high = specification.min, specification.max
        if self.phase == STEP and not (
            isfinite(value) and (low is None or value >= low) and (high is None or value <= high)
        ):
            self._error(f"{name} = {value:.12g} is not allowed, and ignored; it must be in {describe(specification)}")
            return False
        return True

    # The call sequence ---------------------------------------------------------------------------------------------

    def setup_experiment(self, start_time, stop_time=None, tolerance=None):
        if not self._expect((INSTANTIATED,), "fmi2SetupExperiment"):
            return
        if not isfinite(start_time):
            return self._error(f"startTime = {start_time:.12g} s is not allowed; it must be finite")
        if stop_time is not None and not stop_time >= start_time:
            return self._error(
                f"stopTime = {stop_time:.12g} s is not allowed; it must be in [startTime = {start_time:.12g}, inf] s"
            )
        self.time, self.stop_time = start_time, inf if stop_time is None else stop_time

    def enter_initialization_mode(self):
        if self._expect((INSTANTIATED,), "fmi2EnterInitializationMode"):
            self.phase = INITIALIZATION

    def exit_initialization_mode(self):
        if self._expect((INITIALIZATION,), "fmi2ExitInitializationMode"):
            self._start()
            for message in self.refused:
                self._error(message)
            if not self.refused:
                self.phase = STEP

    def do_step(self, time, step_size):
        if self.refused:
            return self._discard(f"the step is not done, because {'; '.join(self.refused)}")
        if not self._expect((STEP,), "fmi2DoStep"):
            return False
        if not 0 < step_size < inf:
            return self._discard(f"communicationStepSize = {step_size:.12g} s is not allowed; it must be above 0 s")
        tolerance = max(ON_TIME * step_size, 8 * EPSILON * abs(time))
        if not abs(time - self.time) <= tolerance:
            return self._discard(
                f"currentCommunicationPoint = {time:.12g} s is not where the last step ended, at {self.time:.12g} s"
            )
        if time + step_size > self.stop_time + tolerance:
            return self._discard(
                f"a step to {time + step_size:.12g} s is not allowed; stopTime = {self.stop_time:.12g} s"
            )
        try:
            state, outputs = self._advance(time, step_size)
        except (ArithmeticError, ValueError) as error:
            return self._fail(f"the step is not done: {error}; {self._input_values()}")
        outputs = tree.leaves(outputs)
        if not (isfinite(sum(outputs)) and isfinite(sum(tree.changed(state, self.state)))):
            return self._fail(f"the step is not done: its result is not finite; {self._input_values()}")
        self.state = state
        self.values[self.end_of_parameters :] = outputs
        self.time = time + step_size
        self.outdated = False
        return True

    def terminate(self):
        if self._expect((STEP, FAILED), "fmi2Terminate"):
            self.phase = TERMINATED

    def _fail(self, message):
        self.phase = FAILED
        return self._discard(message)

    def _expect(self, phases, function):
        if self.phase in phases:
            return True
        self._error(f"{function} is not allowed while the slave is {PHASES[self.phase]}")
        return False

    # The model -----------------------------------------------------------------------------------------------------

    def _inputs(self):
        return tree.like(self.model.inputs, self.values[: self.end_of_inputs])

    def _input_values(self):
        named = zip(self.ports[: self.end_of_inputs], self.values)
        return "inputs " + ", ".join(f"{port.variable.name} = {value:.9g}" for port, value in named)

    def _read_parameters(self):
        leaves = self.values[self.end_of_inputs : self.end_of_parameters]
        self.all_parameters = tree.like(self.all_parameters, leaves)
        self.parameters = choices.chosen(floats, self.model, self.all_parameters)

    def _start(self):
        """State and outputs at the start, or the reasons why there are none."""
        self._read_parameters()
        self.refused = range_errors(self.all_parameters, self.all_parameters)
        self.outdated = False
        if self.refused:
            return
        try:
            rules = self.model.rules(floats, self.parameters, self._inputs())
            self.refused = broken(rules, {port.variable.name: value for port, value in zip(self.ports, self.values)})
            if self.refused:
                return
            self.program = self.model.program(self.parameters)
            self.state, outputs = self.program.start(floats, self.parameters, self._inputs(), self.time)
        except (ArithmeticError, ValueError) as error:
            self.refused = [f"there is no start: {error}; {self._input_values()}"]
            return
        outputs = tree.leaves(outputs)
        if isfinite(sum(outputs)):
            self.values[self.end_of_parameters :] = outputs
        else:
            self.refused = [f"there is no start: its outputs are not finite; {self._input_values()}"]

    def _recalculate(self):
        """The outputs after an input has changed, where they depend on one directly; those before where that fails."""
        self.outdated = False
        if self.program.output is None:
            return
        try:
            shown = self.program.output(floats, self.parameters, self.state, self._inputs(), self.time)
        except (ArithmeticError, ValueError) as error:
            return self._error(f"the outputs are not calculated: {error}; {self._input_values()}")
        outputs = tree.leaves(shown)
        if not isfinite(sum(outputs)):
            return self._error(f"the outputs are not calculated: they are not finite; {self._input_values()}")
        self.values[self.end_of_parameters :] = outputs

    def _advance(self, time, step_size):
        steps = max(1, ceil(step_size / self.model.max_step - 1e-9))
        h = step_size / steps
        inputs = self._inputs()
        state, outputs = self.state, None
        for i in range(steps):
            state, outputs = self.program.step(floats, self.parameters, state, inputs, time + i * h, h)
        return state, outputs

    # The state: its bytes are its serialized form too ----------------------------------------------------------------

    def _get_fmu_state(self):
        leaves = [] if self.state is None else tree.leaves(self.state)
        sizes = len(self.values), len(leaves)
        header = HEADER.pack(MAGIC, self.digest.encode(), self.phase, self.outdated, self.time, self.stop_time, *sizes)
        content = header + struct.pack(f"<{len(self.values) + len(leaves)}d", *self.values, *leaves)
        return content + CHECKSUM.pack(crc32(content))

    def _set_fmu_state(self, state):
        content, checksum = state[: -CHECKSUM.size], state[-CHECKSUM.size :]
        if len(state) < HEADER.size or checksum != CHECKSUM.pack(crc32(content)):
            return self._error("the FMU state is damaged, and ignored")
        magic, digest, phase, outdated, time, stop_time, size, state_size = HEADER.unpack_from(content)
        if magic != MAGIC or digest != self.digest.encode() or size != len(self.values):
            return self._error("the FMU state is that of another FMU, and ignored")
        numbers = struct.unpack_from(f"<{size + state_size}d", content, HEADER.size)
        self.values = [int(v) if kind == "Integer" else v for v, kind in zip(numbers, self.kinds)]
        self.state, self.refused = None, []
        if state_size:
            self._read_parameters()
            self.program = self.model.program(self.parameters)
            shape, _ = self.program.start(floats, self.parameters, self.model.inputs, time)
            self.state = tree.like(shape, numbers[size:])
        self.phase, self.outdated, self.time, self.stop_time = phase, outdated, time, stop_time

    @staticmethod
    def _fmu_state_to_bytes(state):
        return state

    @staticmethod
    def _fmu_state_from_bytes(state):
        return state

    # Messages ------------------------------------------------------------------------------------------------------

    def _error(self, message):
        self._log(message, STATUS_ERROR, "logStatusError")

    def _discard(self, message):
        self._log(message, STATUS_DISCARD, "logStatusDiscard")
        return False

    def _log(self, message, status, category):
        # C hosts take the message for a printf format
        self.log(message.replace("%", "%%"), status, category)
