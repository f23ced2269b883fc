"""What the master can run: an FMU or a record, seen alike."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple, Protocol


class Variable(NamedTuple):
    """A variable of a component, from its model description."""

    name: str
    unit: str
    causality: str
    variability: str
    type: str = "Real"
    items: dict[str, int] = {}
    """Of an enumeration, by name."""
    reference: int = 0


class Slave(Protocol):
    """A running instance. The values of `get` are those at the end of the last step, with the inputs set since."""

    def set(self, values: Mapping[str, float]) -> None: ...

    def enter_initialization(self, stop: float) -> None: ...

    def exit_initialization(self) -> None: ...

    def get(self, names: Sequence[str]) -> list[float]: ...

    def step(self, t: float, h: float) -> None: ...

    def close(self) -> None: ...


class Component(Protocol):
    variables: Mapping[str, Variable]
    feedthrough: Mapping[str, frozenset[str]]
    """The outputs that depend on inputs of the same instant, and on which."""

    def instantiate(self, label: str) -> Slave: ...
