"""The ten machines of the IEEE 39-bus system while the loads vary, over noise seeds; no initial guess."""

import argparse

from rich.console import Console
from rich.table import Table

from fmu_src.pmu_observer.plants.ieee39.plant import GENERATORS

from ..bench import frames, ieee39
from ..bench.frames import rms


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
    truth = ieee39.simulate(20.0, load_sigma=arguments.load_sigma)
    s = frames.series(truth, frames.noise(arguments.tve), arguments.seeds)
    title = f"TVE {arguments.tve:.1%}, from 5 s to 20 s, worst of {arguments.seeds} seeds"
    table = Table("machine", "max |error of (E'd, E'q)|, pu", "RMS of delta, rad", "RMS of omega, rad/s", title=title)
    steady = s.t >= 5
    for k, name in enumerate(GENERATORS):
        by_seed = [max(rms(v[steady, k, seed]) for seed in range(arguments.seeds)) for v in (s.delta, s.omega)]
        table.add_row(name, f"{s.e1[steady, k].max():.5f}", *[f"{value:.5f}" for value in by_seed])
    Console().print(table)


if __name__ == "__main__":
    main()
