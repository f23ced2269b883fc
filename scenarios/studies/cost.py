"""Time of one step of the observer: on Python floats while the bank runs and while it rests, and on numpy arrays."""

import argparse
from time import perf_counter

import numpy as np
from rich.console import Console
from rich.table import Table

from fmu_src.pmu_observer import observer
from fmu_src.pmu_observer.carriers import floats
from fmu_src.pmu_observer.phasors import Frame

from . import frames, machines


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="python -m scenarios.studies.cost",
        description=__doc__,
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    parser.add_argument("--machines", type=int, default=10000, help="random machines at once on numpy")
    arguments = parser.parse_args()
    table = Table(title="median time of one step")
    for column in ("", "us"):
        table.add_column(column)
    for name, value in {**on_floats(), **on_arrays(arguments.machines)}.items():
        table.add_row(name, f"{value:.1f}")
    Console().print(table)


def on_floats() -> dict[str, float]:
    truth = frames.record(frames.RECORD_G6)
    p = observer.Parameters(machine=truth.machine)
    rng, channel = np.random.default_rng(1), frames.noise(0.01)
    times: dict[str, list[float]] = {"floats, bank running": [], "floats, tracker only": []}
    seen = []
    for k in range(600):
        V, I, _ = channel(k, rng, truth.V[k], truth.I[k])  # noqa: E741
        frame = Frame(*[float(v) for v in frames.frame(V, I)])
        seen.append(observer.Inputs(frame, float(truth.P_m[k]), float(truth.E_f[k])))
    state, _ = observer.start("robust", floats, p, seen[0], 0.0)
    for k, inputs in enumerate(seen):
        rests = state.estimator.supervision.age + frames.PERIOD <= 0
        begin = perf_counter()
        state, _ = observer.step("robust", floats, p, state, inputs, k * frames.PERIOD, frames.PERIOD)
        times["floats, tracker only" if rests else "floats, bank running"].append(perf_counter() - begin)
    return {name: 1e6 * float(np.median(v)) for name, v in times.items()}


def on_arrays(count: int) -> dict[str, float]:
    truth = machines.simulate(machines.random_machines(count, np.random.default_rng(1)), 0.2)
    times, last = [], perf_counter()
    for _ in frames.observe(truth, frames.noise(0.003), 1):
        times.append(perf_counter() - last)
        last = perf_counter()
    return {f"numpy, bank running, per machine of {count}": 1e6 * float(np.median(times[1:])) / count}


if __name__ == "__main__":
    main()
