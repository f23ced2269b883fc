"""Capture from nothing: random machines, operating points and true states."""

import argparse

import numpy as np
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from ..bench import frames, machines

RIGHT = 0.1
"""pu; an error of (E'd, E'q) below it is the right well."""

TIMES = (0.25, 0.5, 1.0, 2.0, 5.0)


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="python -m scenarios.studies.capture",
        description=__doc__,
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    parser.add_argument("--machines", type=int, default=10000, help="random machines")
    parser.add_argument("--tve", type=float, default=0.003, help="noise of the phasors, and what is assumed")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    plants = machines.random_machines(arguments.machines, arguments.seed)
    truth = machines.simulate(plants, TIMES[-1] + 0.1)
    console = Console(width=140)

    ranges = Table(title="machines, pu on their own base")
    for column in ("", "from", "to"):
        ranges.add_column(column)
    for name, r in machines.RANGES.items():
        ranges.add_row(escape(name), f"{r.low:g}", f"{r.high:g}{' (logarithmic)' if r.logarithmic else ''}")
    console.print(ranges)

    table = Table(
        title=f"{arguments.machines} machines, TVE {arguments.tve:.1%}: share captured (tracking, error < 0.1)"
    )
    for column in (
        "",
        *[f"{t:g} s" for t in TIMES],
        "wrong at capture",
        "wrong 1 s later",
        "wrong at 5 s",
        "worst right",
    ):
        table.add_column(column, no_wrap=True)
    failures = Table(title="failures")
    for column in ("", "machine", "captured at", "right from", "error at 5 s", "P", "Q", "x'", "T'q0"):
        failures.add_column(column)
    for name, field_voltage in (("E_f measured", 1), ("E_f estimated", 2)):
        s = frames.series(
            truth,
            frames.noise(arguments.tve),
            1,
            seed=arguments.seed,
            tve=arguments.tve,
            field_voltage=field_voltage,
            mechanical_power=2,
        )
        study(name, s, plants, table, failures)
    console.print(table)
    console.print(failures)


def study(name, s: frames.Series, plants, table: Table, failures: Table) -> None:
    error, tracking = s.e1[..., 0], s.status[..., 0] == 2
    right = error < RIGHT
    last = np.argmin(abs(s.t - TIMES[-1]))
    first = np.where(tracking.any(0), tracking.argmax(0), len(s.t) - 1)
    each = np.arange(error.shape[1])
    wrong = tracking[first, each] & ~right[first, each]
    later = np.minimum(first + round(1 / frames.PERIOD), len(s.t) - 1)
    still = wrong & ~right[later, each]
    captured = [np.mean((tracking & right)[np.argmin(abs(s.t - t))]) for t in TIMES]
    good = (tracking & right)[last]
    table.add_row(
        name,
        *[f"{share:.4f}" for share in captured],
        f"{wrong.sum()}",
        f"{still.sum()}",
        f"{(tracking[last] & ~right[last]).sum()}",
        f"{error[last][good].max():.4f}",
    )
    m, u = plants.parameters.machine, plants.inputs
    V, I = s_first(plants)  # noqa: E741 - the paper's name
    for i in np.flatnonzero(wrong | ~good)[:40]:
        from_then = np.flatnonzero(~right[:, i])
        failures.add_row(
            name,
            str(i),
            f"{s.t[first[i]]:.2f} s" if tracking[:, i].any() else "never",
            f"{s.t[min(from_then[-1] + 1, len(s.t) - 1)]:.2f} s" if len(from_then) else "0 s",
            f"{error[last, i]:.4f}",
            f"{u.P_m[i]:.2f}",
            f"{(V * np.conj(I)).imag[i]:.2f}",
            f"{m.xd1[i]:.2f}",
            f"{m.Tq10[i]:.2f}",
        )


def s_first(plants):
    truth = machines.simulate(plants, 0.0)
    return truth.V[0], truth.I[0]


if __name__ == "__main__":
    main()
