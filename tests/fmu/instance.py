"""A slave as the tests see it: variables by name, every status and every log message kept."""

import shutil
from ctypes import CFUNCTYPE, c_char_p, c_int, c_void_p, cast, string_at
from pathlib import Path

from fmpy import calloc, extract, free, read_model_description
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import (
    FMU2Slave,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
    fmi2StepFinishedTYPE,
)

FRAME = ("V_t", "theta_t", "I_t", "phi_t", "P_t", "Q_t")
STATES = ("delta", "load_angle", "omega", "e1d", "e1q")
OK, WARNING, DISCARD, ERROR, FATAL = range(5)

LOGGER = CFUNCTYPE(None, c_void_p, c_char_p, c_int, c_char_p, c_char_p, c_void_p)
"""fmi2CallbackLogger with the first of its variable arguments, which on x86-64 is passed like the others."""


class Instance:
    """One instance of an FMU, loaded from its zip by FMPy."""

    def __init__(self, path: Path, name: str = "instance", **start):
        self.path = path
        self.description = read_model_description(path)
        self.variables = {v.name: v for v in self.description.modelVariables}
        self.messages: list[str] = []
        self.folder = extract(path)
        assert self.description.coSimulation
        self.slave = FMU2Slave(
            guid=self.description.guid,
            unzipDirectory=self.folder,
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName=name,
        )
        self.logger = LOGGER(self._log)
        self.callbacks = fmi2CallbackFunctions(
            logger=cast(self.logger, fmi2CallbackLoggerTYPE),
            allocateMemory=fmi2CallbackAllocateMemoryTYPE(calloc),
            freeMemory=fmi2CallbackFreeMemoryTYPE(free),
            stepFinished=fmi2StepFinishedTYPE(lambda environment, status: None),
            componentEnvironment=None,
        )
        self.slave.instantiate(callbacks=self.callbacks, loggingOn=True)
        self.set(**start)

    def _log(self, environment, instance, status, category, message, argument):
        assert category is not None  # a NULL category kills C++ hosts
        self.messages.append((string_at(argument) if message == b"%s" else message).decode())

    def initialise(self, time: float = 0.0, **inputs) -> "Instance":
        self.slave.setupExperiment(startTime=time)
        self.slave.enterInitializationMode()
        self.set(**inputs)
        self.slave.exitInitializationMode()
        return self

    def set(self, **values) -> None:
        """Variables by name; `__` stands for the dot of a structured name."""
        for name, value in values.items():
            variable = self.variables[name.replace("__", ".")]
            setter = {"Real": self.slave.setReal, "Boolean": self.slave.setBoolean}.get(
                variable.type, self.slave.setInteger
            )
            setter([variable.valueReference], [value])

    def get(self, *names: str) -> list[float]:
        return [self._getter(name)([self.variables[name].valueReference])[0] for name in names]

    def _getter(self, name):
        kind = self.variables[name].type
        return {"Real": self.slave.getReal, "Boolean": self.slave.getBoolean}.get(kind, self.slave.getInteger)

    def call(self, function: str, *arguments) -> int:
        """The status of an FMI function, which FMPy would turn into an exception."""
        try:
            getattr(self.slave, function)(self.slave.component, *arguments)
        except FMICallException as error:
            return error.status
        return OK

    def step(self, time: float, h: float) -> int:
        return self.call("fmi2DoStep", time, h, True)

    def outputs(self) -> list[float]:
        return self.get(*[name for name, v in self.variables.items() if v.causality == "output"])

    def free(self) -> None:
        self.call("fmi2Terminate")
        self.slave.freeInstance()
        shutil.rmtree(self.folder, ignore_errors=True)
