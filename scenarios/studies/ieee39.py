"""The ten machines of the IEEE 39-bus system while the loads vary, over noise seeds; no initial guess."""

import argparse
from math import pi

import numpy as np
from rich.console import Console
from rich.table import Table

from fmu_src.pmu_observer import tree
from fmu_src.pmu_observer.machines.data import Machine
from fmu_src.pmu_observer.plants.ieee39 import plant, tables

from . import frames
from .noise import rms


def truth(duration: float, **parameters) -> frames.Truth:
    """A run of the plant: frames of its ten machines."""
    p = plant.Parameters(**parameters)
    state, outputs = plant.start(None, p, plant.Inputs(), 0.0)
    rows = [tree.leaves(outputs.generators)]
    for k in range(round(duration / frames.PERIOD)):
        state, outputs = plant.step(None, p, state, plant.Inputs(), k * frames.PERIOD, frames.PERIOD)
        rows.append(tree.leaves(outputs.generators))
    names = tree.names(plant.Generator())
    columns = np.array(rows).reshape(len(rows), len(plant.GENERATORS), len(names)).transpose(2, 0, 1)
    g = dict(zip(names, columns, strict=True))
    m = tables.machines(p.salient)
    return frames.Truth(
        machine=Machine(m.H, 0.0, m.xd, m.xd1, m.xq, m.xq1, m.Td10, m.Tq10, 0.0, 2 * pi * 60),
        V=g["frame.V_t"] * np.exp(1j * g["frame.theta_t"]),
        I=g["frame.I_t"] * np.exp(1j * g["frame.phi_t"]),
        **{name: g[name] for name in ("P_m", "E_f", "delta", "omega", "e1d", "e1q")},
    )


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="python -m scenarios.studies.ieee39",
        description=__doc__,
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    parser.add_argument("--seeds", type=int, default=20, help="noise seeds")
    parser.add_argument("--tve", type=float, default=0.005, help="total vector error of the PMUs")
    parser.add_argument("--load-sigma", type=float, default=0.01, help="standard deviation of the loads")
    arguments = parser.parse_args()
    true = truth(20.0, load_sigma=arguments.load_sigma)
    s = frames.series(true, frames.noise(arguments.tve), arguments.seeds)
    title = f"TVE {arguments.tve:.1%}, from 5 s to 20 s, worst of {arguments.seeds} seeds"
    table = Table("machine", "max |error of (E'd, E'q)|, pu", "RMS of delta, rad", "RMS of omega, rad/s", title=title)
    steady = s.t >= 5
    for k, name in enumerate(plant.GENERATORS):
        by_seed = [max(rms(v[steady, k, seed]) for seed in range(arguments.seeds)) for v in (s.delta, s.omega)]
        table.add_row(name, f"{s.e1[steady, k].max():.5f}", *[f"{value:.5f}" for value in by_seed])
    Console().print(table)


if __name__ == "__main__":
    main()
