"""An FMI 2.0 co-simulation FMU and its instances, on FMPy."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from ctypes import byref
from functools import lru_cache
from pathlib import Path
from typing import Any

from fmpy import calloc, extract, free, read_model_description
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import (
    FMU2Slave,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
    fmi2Warning,
)
from fmpy.logging import addLoggerProxy

from .component import Variable
from .errors import ScenarioError


class Fmu:
    """An FMU, unpacked into a folder."""

    def __init__(self, path: Path, folder: Path):
        self.folder = extract(str(path), unzipdir=str(folder))
        self.description: Any = read_model_description(self.folder)
        self.variables: Mapping[str, Variable] = {v.name: variable(v) for v in self.description.modelVariables}
        self.feedthrough: Mapping[str, frozenset[str]] = {
            output: inputs for output, inputs in direct_inputs(self.description) if inputs
        }

    def instantiate(self, label: str) -> "FmuSlave":
        return FmuSlave(self, label)


def direct_inputs(description: Any) -> Iterable[tuple[str, frozenset[str]]]:
    """Each output with the inputs of its own instant that it depends on; where an FMU does not say, all of them."""
    for output in description.outputs:
        known = description.modelVariables if output.dependencies is None else output.dependencies
        yield output.variable.name, frozenset(v.name for v in known if v.causality == "input")


def variable(v: Any) -> Variable:
    declared = v.declaredType
    items = {item.name: int(item.value) for item in declared.items or []} if declared else {}
    unit = v.unit or (declared and declared.unit) or "1"
    return Variable(v.name, unit, v.causality, v.variability, v.type, items, v.valueReference)


class FmuSlave:
    """An instance. What it logs as an error ends the run: see `_call`."""

    def __init__(self, fmu: Fmu, label: str):
        self.label = label
        self.variables = fmu.variables
        LOGGED[label] = self.messages = []
        description = fmu.description
        self.slave = FMU2Slave(
            instanceName=label,
            guid=description.guid,
            modelIdentifier=description.coSimulation.modelIdentifier,
            unzipDirectory=fmu.folder,
        )
        self.slave.instantiate(callbacks=callbacks(), loggingOn=True)
        accessors = {"Real": (self.slave.getReal, self.slave.setReal)}
        accessors["Integer"] = accessors["Enumeration"] = (self.slave.getInteger, self.slave.setInteger)
        accessors["Boolean"] = (self.slave.getBoolean, self.slave.setBoolean)
        self.accessors = accessors
        self.groups = lru_cache(maxsize=None)(self._groups)

    def set(self, values: Mapping[str, float]) -> None:
        for type_, names, references in self.groups(tuple(values)):
            convert = float if type_ == "Real" else int
            self._call(self.accessors[type_][1], references, [convert(values[name]) for name in names])

    def get(self, names: Sequence[str]) -> list[float]:
        found = {}
        for type_, group, references in self.groups(tuple(names)):
            found.update(zip(group, self._call(self.accessors[type_][0], references), strict=True))
        return [float(found[name]) for name in names]

    def enter_initialization(self, stop: float | None, start: float = 0.0) -> None:
        self._call(self.slave.setupExperiment, None, start, stop)
        self._call(self.slave.enterInitializationMode)

    def exit_initialization(self) -> None:
        self._call(self.slave.exitInitializationMode)

    def step(self, t: float, h: float) -> None:
        self._call(self.slave.doStep, t, h)

    def close(self) -> None:
        self.slave.freeInstance()

    def _call(self, function: Callable, *arguments: Any) -> Any:
        """Raises ScenarioError with what the FMU logs, if it does, or else with its status."""
        result = None
        try:
            result = function(*arguments)
        except FMICallException as error:
            self.messages = self.messages or [str(error)]
        if self.messages:
            raise ScenarioError("\n".join(f"{self.label}: {message}" for message in self.messages))
        return result

    def _groups(self, names: tuple[str, ...]) -> list[tuple[str, list[str], list[int]]]:
        """(type, names, value references): FMI gets and sets the variables of one type in one call."""
        by_type: dict[str, list[str]] = {}
        for name in names:
            by_type.setdefault(self.variables[name].type, []).append(name)
        return [(type_, group, [self.variables[name].reference for name in group]) for type_, group in by_type.items()]


LOGGED: dict[str, list[str]] = {}
"""What each instance has logged worse than a warning, by its name: FMPy's proxy knows one logger a process."""


@fmi2CallbackLoggerTYPE
def log(environment, name, status, category, message):
    if status > fmi2Warning:
        LOGGED.setdefault(name.decode(), []).append(message.decode("utf-8", "replace"))


def callbacks() -> fmi2CallbackFunctions:
    functions = fmi2CallbackFunctions()
    functions.logger = log
    functions.allocateMemory = fmi2CallbackAllocateMemoryTYPE(calloc)
    functions.freeMemory = fmi2CallbackFreeMemoryTYPE(free)
    addLoggerProxy(byref(functions))  # fills in what C's variable arguments bring
    return functions
