"""From a scenario to a plan. Every name, value and unit in the scenario is checked here, before anything runs."""

from collections.abc import Iterable, Mapping
from graphlib import CycleError, TopologicalSorter

from . import scenario as toml
from .component import Component, Variable
from .errors import ScenarioError
from .lookup import Lookup, number, split, substituted
from .plan import Change, Instance, Plan, Source
from .scenario import Scenario
from .signals import signals


def wire(scenario: Scenario, components: Mapping[str, Component]) -> Plan:
    """Raises ScenarioError for a name, a value or a unit that does not fit."""
    lookup = Lookup(scenario, components)
    instances = [instance for group in lookup.instances.values() for instance in group]
    set_parameters(scenario, lookup)
    connect(scenario, lookup)
    set_inputs(scenario, lookup)
    changes = [change for given in scenario.change for change in changes_of(scenario, lookup, given)]
    changes.sort(key=lambda change: change.point)
    plan = Plan(scenario, components, instances, changes, signals(scenario, lookup), feedthrough(lookup, instances))
    links = [source for instance in instances for source in instance.links.values()]
    for source in links + [s for group in plan.signals.values() for signal in group for s in signal.sources.values()]:
        source.instance.watched.add(source.variable)
    return plan


def set_parameters(scenario: Scenario, lookup: Lookup) -> None:
    """[parameters] for every FMU that has a parameter of the name, then those of each FMU."""
    for name, value in scenario.parameters.items():
        for component, variable in lookup.fmus_with("parameters", name, "parameter"):
            for instance in lookup.instances[component]:
                instance.parameters[name] = number("parameters", variable, value)
    for component, fmu in scenario.fmu.items():
        where = f"fmu.{component}.parameters"
        for name, value in fmu.parameters.items():
            variable = lookup.variable(where, component, name, "parameter")
            for instance in lookup.instances[component]:
                instance.parameters[name] = number(where, variable, substituted(where, value, instance.values))


def set_inputs(scenario: Scenario, lookup: Lookup) -> None:
    """[inputs] for every FMU that has an input of the name and is not connected there, then those of each FMU."""
    for name, value in scenario.inputs.items():
        for component, variable in lookup.fmus_with("inputs", name, "input"):
            for instance in lookup.instances[component]:
                if variable.name not in instance.links:
                    instance.inputs[variable.name] = number("inputs", variable, value)
    for component, fmu in scenario.fmu.items():
        where = f"fmu.{component}.inputs"
        for name, value in fmu.inputs.items():
            variable = lookup.variable(where, component, name, "input")
            for instance in lookup.instances[component]:
                if name in instance.links:
                    raise ScenarioError(f"{where}: {name} is connected; remove it here or in [connect]")
                instance.inputs[name] = number(where, variable, substituted(where, value, instance.values))


def connect(scenario: Scenario, lookup: Lookup) -> None:
    """ "observer.E_f" = "plant.E_f_start": one input. observer = "plant": all inputs that plant has outputs of the same
    name for. A prefix may stand on either side: observer = "grid.G1.*" is V_t from G1.V_t, and
    "channel.plant.*" = "plant" is plant.V_t from V_t."""
    for target, source in scenario.connect.items():
        where = f'connect "{target}" = "{source}"'
        component, _, name = target.partition(".")
        lookup.component(where, component)
        for instance in lookup.instances[component]:
            chosen = substituted(where, source, instance.values)
            if name and not name.endswith("*"):
                link(lookup, where, instance, name, *split(where, chosen))
            else:
                link_all(lookup, where, instance, name.removesuffix("*"), *chosen.removesuffix("*").partition(".")[::2])


def link_all(lookup: Lookup, where: str, instance: Instance, own_prefix: str, component: str, prefix: str) -> None:
    inputs = [v.name for v in lookup.components[instance.component].variables.values() if v.causality == "input"]
    outputs = [v.name for v in lookup.component(where, component).variables.values() if v.causality == "output"]
    of_prefix = [name.removeprefix(own_prefix) for name in inputs if name.startswith(own_prefix)]
    shared = [name for name in of_prefix if prefix + name in outputs]
    if not shared:
        raise ScenarioError(
            f"{where}: no output of {component} has the name of an input of {instance.component}; connect one by one.\n"
            f"  inputs of {instance.component}: {', '.join(inputs)}\n  outputs of {component}: {', '.join(outputs)}"
        )
    for name in shared:
        link(lookup, where, instance, own_prefix + name, component, prefix + name)


def link(lookup: Lookup, where: str, instance: Instance, name: str, component: str, output: str) -> None:
    target = lookup.variable(where, instance.component, name, "input")
    source = lookup.variable(where, component, output, "output")
    if source.unit != target.unit:
        units = f"{component}.{output} is in {source.unit}, {instance.component}.{name} in {target.unit}"
        raise ScenarioError(f"{where}: {units}; convert one of them")
    if name in instance.links:
        raise ScenarioError(f"{where}: {instance.component}.{name} is connected already; remove one connection")
    instance.links[name] = Source(lookup.instance(where, component, instance.sweep), output)


def changes_of(scenario: Scenario, lookup: Lookup, change: toml.Change) -> Iterable[Change]:
    where = f"change at {float(change.at):g} s"
    for name, value in change.set.items():
        for component, variable in changed(lookup, where, name):
            if variable.causality == "parameter" and variable.variability != "tunable":
                raise ScenarioError(
                    f"{where}: {component}.{variable.name} is a {variable.variability} parameter; "
                    "only inputs and tunable parameters can change during a run"
                )
            for instance in lookup.instances[component]:
                if variable.name in instance.links:
                    raise ScenarioError(f"{where}: {component}.{variable.name} is connected; change what feeds it")
                new = number(where, variable, substituted(where, value, instance.values))
                yield Change(scenario.index(change.at), instance, {variable.name: new})


def changed(lookup: Lookup, where: str, name: str) -> list[tuple[str, Variable]]:
    """`observer.k_speed` is that of one FMU, `P_m` that of every FMU that has it and is not fed another one."""
    component, _, own = name.partition(".")
    if component in lookup.components:
        return [(component, lookup.variable(where, component, own, "input", "parameter"))]
    found = lookup.fmus_with(where, name, "input", "parameter")
    free = [(c, v) for c, v in found if not any(v.name in instance.links for instance in lookup.instances[c])]
    return free or found


def feedthrough(lookup: Lookup, instances: Iterable[Instance]) -> list[Instance]:
    """The instances whose outputs depend on connected inputs of the same instant, each after those that feed these.

    Raises ScenarioError for a loop.
    """
    through = {i: lookup.components[i.component].feedthrough for i in instances}
    # only what itself depends on an input has to be right first: plant.E_f = "plant.E_f_start" is no loop
    fed_by = {
        i: {
            source.instance
            for name, source in i.links.items()
            if any(name in inputs for inputs in outputs.values()) and source.variable in through[source.instance]
        }
        for i, outputs in through.items()
        if any(name in inputs for name in i.links for inputs in outputs.values())
    }
    try:
        return list(TopologicalSorter(fed_by).static_order())
    except CycleError as error:
        loop = " <- ".join(instance.label for instance in error.args[1])
        raise ScenarioError(
            f"connect: {loop}: each shows its inputs at once, and none is first; connect one of them elsewhere"
        ) from error
