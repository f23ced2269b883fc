"""The co-simulation: all outputs are exchanged at t, then all instances step to t + h (Jacobi).

Outputs that depend on inputs of the same instant (a PMU's) are read again after these have been set.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from .component import Slave
from .plan import Instance, Plan, Signal


@dataclass
class Results:
    plan: Plan
    time: np.ndarray
    """s, the communication points."""
    values: Mapping[Instance, Mapping[str, np.ndarray]]
    """Of every watched variable, at the communication points."""
    wall_time: float
    """s, of the stepping."""

    def of(self, signal: Signal) -> np.ndarray:
        """The values of a signal at the communication points."""
        values = {name: self.values[source.instance][source.variable] for name, source in signal.sources.items()}
        return signal.expression(values) * np.ones_like(self.time)


def run(plan: Plan, progress: Callable[[float], None] = lambda done: None) -> Results:
    """Run a plan; `progress` is told the share that is done after every step.

    Raises ScenarioError with the message of an FMU that refuses a value or a step.
    """
    scenario = plan.scenario
    steps = scenario.index(scenario.stop)
    rows = {instance: np.empty((steps + 1, len(instance.watched))) for instance in plan.instances}
    start = perf_counter()
    for index, outputs in enumerate(points(plan)):
        start = start if index else perf_counter()  # the wall time is that of the stepping
        for instance, values in outputs.items():
            rows[instance][index] = list(values.values())
        progress(index / steps)
    wall_time = perf_counter() - start
    time = np.array([scenario.time(index) for index in range(steps + 1)])
    series = {i: dict(zip(sorted(i.watched), rows[i].T, strict=True)) for i in plan.instances}
    return Results(plan, time, series, wall_time)


def points(plan: Plan) -> Iterator[dict[Instance, dict[str, float]]]:
    """The watched variables of all instances at the communication points, one after the other, from 0 s to `stop`.

    Raises ScenarioError with the message of an FMU that refuses a value or a step.
    """
    scenario = plan.scenario
    with ExitStack() as open_slaves:
        slaves: dict[Instance, Slave] = {}
        for instance in plan.instances:
            slaves[instance] = plan.components[instance.component].instantiate(instance.label)
            open_slaves.callback(slaves[instance].close)
        names = {instance: sorted(instance.watched) for instance in plan.instances}
        steps = scenario.index(scenario.stop)

        def read(instances: Iterable[Instance]) -> dict[Instance, dict[str, float]]:
            return {i: dict(zip(names[i], slaves[i].get(names[i]), strict=True)) for i in instances}

        def feed(instances: Iterable[Instance], outputs: Mapping[Instance, Mapping[str, float]]) -> None:
            for instance in instances:
                if instance.links:
                    slaves[instance].set({name: outputs[s.instance][s.variable] for name, s in instance.links.items()})

        def change(index: int) -> None:
            for point, instance, values in plan.changes:
                if point == index:
                    slaves[instance].set(values)

        def exchange(index: int) -> dict[Instance, dict[str, float]]:
            change(index)
            outputs = read(plan.instances)
            for instance in plan.feedthrough:
                feed([instance], outputs)
                outputs.update(read([instance]))
            feed(plan.instances, outputs)
            return outputs

        initialize(plan, slaves, read, feed)
        for index in range(steps + 1):
            yield exchange(index)
            if index < steps:
                t, end = scenario.time(index), scenario.time(index + 1)
                for slave in slaves.values():
                    slave.step(t, end - t)


def initialize(plan: Plan, slaves: Mapping[Instance, Slave], read, feed) -> None:
    """Initialisation mode: outputs are exchanged until nothing changes, so that the first frames are right.

    What passes through a chain of n instances has arrived after n exchanges.
    """
    for instance, slave in slaves.items():
        slave.set(instance.parameters)
        slave.enter_initialization(float(plan.scenario.stop))
        slave.set(instance.inputs)
    outputs = read(slaves)
    for _ in slaves:
        feed(slaves, outputs)
        before, outputs = outputs, read(slaves)
        if outputs == before:
            break
    for slave in slaves.values():
        slave.exit_initialization()
