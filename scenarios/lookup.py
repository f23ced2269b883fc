"""The names of a scenario: components, their variables and their instances. What is not found is a ScenarioError."""

import csv
from collections.abc import Iterable, Mapping
from itertools import product
from pathlib import Path
from typing import Any

from .component import Component, Variable
from .errors import ScenarioError, alternatives
from .plan import Instance, agree, sweep_text
from .scenario import Scenario


class Lookup:
    """`where` is the place in the scenario that the messages name."""

    def __init__(self, scenario: Scenario, components: Mapping[str, Component]):
        self.components = components
        self.instances = {name: list(instances_of(scenario, name)) for name in components}

    def component(self, where: str, name: str) -> Component:
        if name not in self.components:
            known = alternatives(name, list(self.components))
            raise ScenarioError(f'{where}: there is no FMU or CSV "{name}"; {known}')
        return self.components[name]

    def variable(self, where: str, component: str, name: str, *causalities: str) -> Variable:
        """A variable of a component; with `causalities`, of one of those."""
        variables = self.component(where, component).variables
        if name in variables and variables[name].causality in (causalities or [variables[name].causality]):
            return variables[name]
        known = [v.name for v in variables.values() if v.causality in (causalities or [v.causality])]
        kind = " or ".join(causalities) or "variable"
        raise ScenarioError(f'{where}: {component} has no {kind} "{name}"; {alternatives(name, known)}')

    def fmus_with(self, where: str, name: str, *causalities: str) -> list[tuple[str, Variable]]:
        """The variables of that name, each with its component; of inputs also plant.P_m for the name P_m."""
        of_kind = [(c, v) for c in self.components for v in self.components[c].variables.values()]
        of_kind = [(c, v) for c, v in of_kind if v.causality in causalities]
        found = [
            (c, v) for c, v in of_kind if v.name == name or (v.causality == "input" and v.name.endswith(f".{name}"))
        ]
        if not found:
            known = list(dict.fromkeys(variable.name for _, variable in of_kind))
            kind = " or ".join(causalities)
            raise ScenarioError(f'{where}: "{name}" is no {kind} of any FMU; {alternatives(name, known)}')
        return found

    def instance(self, where: str, component: str, sweep: Mapping[str, Any]) -> Instance:
        """The one instance of a component that belongs to those values of a sweep."""
        found = [instance for instance in self.instances[component] if agree(sweep, instance.sweep)]
        if len(found) != 1:
            raise ScenarioError(
                f"{where}: {len(found)} instances of {component} belong to one with {sweep_text(sweep) or 'no each'}; "
                "give both components the same each"
            )
        return found[0]

    def combinations(
        self, components: Iterable[str], keys: Iterable[str]
    ) -> list[tuple[dict[str, Any], dict[str, Instance]]]:
        """What several components and keys sweep, with the instances of the components that belong together."""
        found: list[tuple[dict[str, Any], dict[str, Instance]]] = [({}, {})]
        for key in keys:
            found = [({**sweep, key: value}, {}) for sweep, _ in found for value in self.swept(key)] or found
        for component in components:
            found = [
                ({**sweep, **instance.sweep}, {**chosen, component: instance})
                for sweep, chosen in found
                for instance in self.instances[component]
                if agree(sweep, instance.sweep)
            ]
        return found

    def swept(self, key: str) -> list[Any]:
        """The values of a key of `each`, of whatever component."""
        sweeps = [instance.sweep for group in self.instances.values() for instance in group]
        return list(dict.fromkeys(sweep[key] for sweep in sweeps if key in sweep))


def instances_of(scenario: Scenario, name: str) -> Iterable[Instance]:
    fmu = scenario.fmu.get(name)
    if fmu is None:
        return [Instance(name, {})]
    rows = rows_of(f"fmu.{name}.rows", scenario.folder / fmu.rows) if fmu.rows else [{}]
    sweeps = [dict(zip(fmu.each, values, strict=True)) for values in product(*fmu.each.values())]
    return [Instance(name, dict(list(row.items())[:1]) | sweep, row) for row in rows for sweep in sweeps]


def rows_of(where: str, path: Path) -> list[dict[str, Any]]:
    """The rows of a CSV: numbers, and texts such as the name of a unit; empty cells are left out."""
    try:
        lines = [line for line in path.read_text(encoding="utf-8").splitlines() if line.strip() and line[0] != "#"]
        names, *rows = csv.reader(lines, skipinitialspace=True)
        return [{n: cell_of(c) for n, c in zip(names, row, strict=True) if c.strip()} for row in rows]
    except FileNotFoundError:
        raise ScenarioError(f"{where}: there is no file {path}; give its path from the scenario's folder") from None
    except ValueError as error:
        raise ScenarioError(f"{where}: {path} is not a table separated by commas: {error}") from error


def cell_of(text: str) -> Any:
    """A whole number, a number, or a text."""
    try:
        value = float(text)
    except ValueError:
        return text.strip()
    return int(value) if value.is_integer() else value


def split(where: str, reference: str) -> tuple[str, str]:
    """`plant.delta` as component and variable."""
    component, _, name = reference.partition(".")
    if not name:
        raise ScenarioError(f'{where}: "{reference}" is not the name of a variable; write "component.variable"')
    return component, name


def substituted(where: str, value: Any, sweep: Mapping[str, Any]) -> Any:
    """The text "{gamma}" is the value of the sweep itself; within a longer text it is filled in."""
    if not isinstance(value, str):
        return value
    try:
        if value.startswith("{") and value[1:-1] in sweep:
            return sweep[value[1:-1]]
        return value.format(**sweep)
    except (KeyError, IndexError, ValueError):
        known = alternatives(value, list(sweep))
        raise ScenarioError(f'{where}: "{value}" asks for what is not in each; {known}') from None


def number(where: str, variable: Variable, value: Any) -> float:
    """A value as an FMU takes it; an item of an enumeration may be given by its name."""
    if variable.items:
        allowed, good = alternatives(str(value), list(variable.items)), value in variable.items
        value = variable.items.get(value, value)
    elif variable.type == "Boolean":
        allowed, good = "write true or false", isinstance(value, bool)
    elif variable.type == "Integer":
        allowed, good = "write a whole number", type(value) is int
    else:
        unit = "" if variable.unit == "1" else f" of {variable.unit}"
        allowed, good = f"write a number{unit}", type(value) in (int, float)
    if not good:
        raise ScenarioError(f"{where}: {variable.name} = {value!r} is not allowed; {allowed}")
    return value
