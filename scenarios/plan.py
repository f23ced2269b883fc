"""A scenario ready to run: its instances, what feeds each of their inputs, and the signals to look at."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from .component import Component
from .expression import Expression
from .scenario import Expect, Scenario


@dataclass(eq=False)
class Instance:
    """One instance of a component; `sweep` holds its values of `each`, and of the first column of `rows`."""

    component: str
    sweep: dict[str, Any]
    row: dict[str, Any] = field(default_factory=dict)
    """Of `rows`, by column."""
    parameters: dict[str, float] = field(default_factory=dict)
    inputs: dict[str, float] = field(default_factory=dict)
    """Inputs that are constant until a change."""
    links: dict[str, "Source"] = field(default_factory=dict)
    """Inputs that are connected."""
    watched: set[str] = field(default_factory=set)
    """Variables to read after every step."""

    @property
    def label(self) -> str:
        return self.component + in_brackets(self.sweep)

    @property
    def values(self) -> dict[str, Any]:
        """What "{gamma}" can stand for."""
        return self.row | self.sweep


class Source(NamedTuple):
    instance: Instance
    variable: str


class Change(NamedTuple):
    point: int  # of communication, counted from 0 at the start
    instance: Instance
    values: dict[str, float]


class Signal(NamedTuple):
    """An error or a variable, of one combination of instances."""

    name: str
    sweep: dict[str, Any]
    unit: str
    expression: Expression
    sources: dict[str, Source]

    @property
    def label(self) -> str:
        return self.name + in_brackets(self.sweep)


@dataclass
class Plan:
    scenario: Scenario
    components: Mapping[str, Component]
    instances: list[Instance]
    changes: list[Change]
    """In the order of time."""
    signals: dict[str, list[Signal]]
    """By the name of an error or a variable: one signal a combination of instances."""
    feedthrough: list[Instance] = field(default_factory=list)
    """Those whose outputs depend on connected inputs of the same instant, each after those that feed these."""

    def expected(self, expect: Expect, name: str) -> list[Signal]:
        """The signals of that name that an expectation is about."""
        return [s for s in self.signals[name] if all(s.sweep.get(key) == value for key, value in expect.each.items())]


def agree(a: Mapping[str, Any], b: Mapping[str, Any]) -> bool:
    """Whether two instances belong together: what both sweep is the same."""
    return all(a[key] == b[key] for key in a.keys() & b.keys())


def in_brackets(sweep: Mapping[str, Any]) -> str:
    return f"[{sweep_text(sweep)}]" if sweep else ""


def sweep_text(sweep: Mapping[str, Any]) -> str:
    return ", ".join(f"{key} = {value_text(value)}" for key, value in sweep.items())


def value_text(value: Any) -> str:
    """1e6, not 1e+06 or 1000000.0."""
    return re.sub(r"e\+?(-?)0*", r"e\1", f"{value:g}") if isinstance(value, float) else str(value)
