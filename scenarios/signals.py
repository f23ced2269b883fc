"""The errors and variables that a scenario looks at: in its table, its figures and its expectations."""

from collections.abc import Iterable

from .errors import ScenarioError, alternatives
from .expression import KEY, parse
from .lookup import Lookup, split, substituted
from .plan import Plan, Signal, Source, sweep_text
from .scenario import Scenario


def signals(scenario: Scenario, lookup: Lookup) -> dict[str, list[Signal]]:
    """By name: one signal for each combination of instances that belong together. Raises ScenarioError."""
    found = {name: list(signals_of(scenario, lookup, where, name)) for name, where in wanted(scenario).items()}
    for figure in scenario.figure:
        if figure.facet and not lookup.swept(figure.facet):
            raise ScenarioError(f'figure {figure.name}: facet = "{figure.facet}" is in no each; sweep it, or remove it')
    plan = Plan(scenario, lookup.components, [], [], found)
    for expect in scenario.expect:
        for name in expect.references:
            if not plan.expected(expect, name):
                known = "; ".join(sweep_text(signal.sweep) for signal in found[name])
                asked = sweep_text(expect.each)
                raise ScenarioError(f"expect: {name} has no instance with {asked}; known: {known or 'none'}")
    return found


def wanted(scenario: Scenario) -> dict[str, str]:
    """Every name of an error or a variable, and where the scenario uses it."""
    used = {name: f"error.{name}" for name in scenario.error}
    for figure in scenario.figure:
        used.update(
            {
                name: f"figure {figure.name}"
                for panel in figure.panel
                for name in (*panel.curves, *panel.band.values())
                if name not in used
            }
        )
    for expect in scenario.expect:
        used.update({name: "expect" for name in expect.references if name not in used})
    return used


def signals_of(scenario: Scenario, lookup: Lookup, where: str, name: str) -> Iterable[Signal]:
    if name not in scenario.error and not all(part.isidentifier() for part in KEY.sub(r"\1", name).split(".")):
        raise ScenarioError(f'{where}: "{name}" is not a name; name it in [error], and use that name here')
    if name not in scenario.error and "." not in name:
        known = alternatives(name, list(scenario.error))
        raise ScenarioError(f'{where}: there is no error "{name}"; {known} (a variable is "component.variable")')
    written = scenario.error.get(name) or parse(name)
    components = sorted({split(where, reference)[0] for reference in written.names})
    for component in components:
        lookup.component(where, component)
    for sweep, chosen in lookup.combinations(components, written.keys):
        expression = parse(substituted(where, written.source, sweep))
        references = {reference: split(where, reference) for reference in sorted(expression.names)}
        units = {r: lookup.variable(where, component, variable).unit for r, (component, variable) in references.items()}
        try:
            unit = expression.unit(units)
        except ValueError as error:
            raise ScenarioError(f"{where}: {error}") from error
        sources = {r: Source(chosen[component], variable) for r, (component, variable) in references.items()}
        yield Signal(substituted(where, name, sweep), sweep, unit, expression, sources)
