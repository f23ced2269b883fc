"""The three-phase fault of scenarios/smib_fault.toml: E_f constant, forced by an exciter, or subtransient circuits."""

import argparse

import numpy as np
from rich.console import Console
from rich.table import Table

from ..bench import frames, machines, sixth_order, smib_fault

FAULT = smib_fault.fault(later=-4.993)
"""That of the scenario: sooner, and between two frames."""

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
    seconds = FAULT.t_clear + 3
    plants = {
        "E_f constant": machines.simulate(smib_fault.plant(FAULT), seconds),
        "exciter": smib_fault.with_exciter(FAULT, seconds),
        "6th order": sixth_order.simulate(seconds, FAULT),
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
            first = (
                np.argmax(s.t >= FAULT.t_clear) + 1
            )  # what is shown at the first frame behind it knows nothing of it
            rows = [np.argmax(s.t >= FAULT.t_fault) - 1, *[first + round(t / frames.PERIOD) for t in AFTER]]
            table.add_row(
                plant,
                name,
                *[f"{np.median(s.e1[k]):.5f} / {np.max(s.e1[k]):.4f}" for k in rows],
                f"{np.mean(s.status[rows[0] :] == 2):.3f}",
            )
    Console(width=180).print(table)


if __name__ == "__main__":
    main()
