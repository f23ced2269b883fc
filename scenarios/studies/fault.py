"""A three-phase fault of 100 ms at generator 6: E_f constant, an exciter that forces it, or subtransient circuits."""

import argparse

import numpy as np
from rich.console import Console
from rich.table import Table

from fmu_src.pmu_observer.plants import smib

from . import frames, machines, sixth_order

T_FAULT, T_CLEAR = 5.007, 5.107
"""s; between two frames."""

AFTER = (0.0, 0.1, 0.25, 0.5, 1.0, 2.0)
"""s after what the first frame behind the clearing makes of it."""


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="python -m scenarios.studies.fault",
        description=__doc__,
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    parser.add_argument("--seeds", type=int, default=100, help="noise seeds")
    parser.add_argument("--tve", type=float, default=0.001, help="noise of the phasors, and what is assumed")
    arguments = parser.parse_args()
    plants = {
        "E_f constant": constant_field(),
        "exciter": forced_field(),
        "6th order": sixth_order.simulate(T_CLEAR + 3, T_FAULT, T_CLEAR),
    }
    table = Table(
        title=f"|error of (E'd, E'q)|, pu, median / worst of {arguments.seeds} seeds, TVE {arguments.tve:.1%}"
    )
    for column in ("plant", "E_f", "before", *[f"+{t:g} s" for t in AFTER], "tracking"):
        table.add_column(column, no_wrap=True)
    for plant, truth in plants.items():
        for name, field_voltage in (("measured", 1), ("estimated", 2)):
            s = frames.series(
                truth,
                frames.noise(arguments.tve),
                arguments.seeds,
                tve=arguments.tve,
                field_voltage=field_voltage,
                mechanical_power=2,
            )
            first = np.argmax(s.t >= T_CLEAR) + 1  # what is shown at the first frame behind it knows nothing of it
            rows = [np.argmax(s.t >= T_FAULT) - 1, *[first + round(t / frames.PERIOD) for t in AFTER]]
            table.add_row(
                plant,
                name,
                *[f"{np.median(s.e1[k]):.5f} / {np.max(s.e1[k]):.4f}" for k in rows],
                f"{np.mean(s.status[rows[0] :] == 2):.3f}",
            )
    Console(width=180).print(table)


def constant_field() -> frames.Truth:
    return machines.simulate(machines.g6_behind_line(t_fault=T_FAULT, t_clear=T_CLEAR, x_fault=0.03), T_CLEAR + 3)


def forced_field() -> frames.Truth:
    """E_f by a fast exciter: gain 100, lag 0.02 s, from 0 to 5 pu."""
    plant = machines.g6_behind_line(t_fault=T_FAULT, t_clear=T_CLEAR, x_fault=0.03)
    E_f, V_ref = plant.inputs.E_f, plant.parameters.V_t_start
    field = E_f
    h = frames.PERIOD / machines.SUBSTEPS

    def inputs(t, outputs: smib.Outputs) -> smib.Inputs:
        nonlocal field
        ordered = np.clip(E_f + 100 * (V_ref - outputs.frame.V_t), 0.0, 5.0)
        field = field + h / 0.02 * (ordered - field)
        return plant.inputs._replace(E_f=field)

    return machines.simulate(plant, T_CLEAR + 3, inputs=inputs)


if __name__ == "__main__":
    main()
