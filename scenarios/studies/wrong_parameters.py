"""Machine parameters wrong by 10 %, and the assumed noise by factors: the errors that result on the record."""

import argparse

import numpy as np
from rich.console import Console
from rich.table import Table

from . import frames

TVE = 0.003


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="python -m scenarios.studies.wrong_parameters",
        description=__doc__,
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    parser.add_argument("--seeds", type=int, default=30, help="noise seeds")
    parser.add_argument("--seconds", type=float, default=20.0, help="of the record")
    arguments = parser.parse_args()
    record = frames.record(frames.RECORD_G6)
    rows = round(arguments.seconds / frames.PERIOD) + 1
    truth = frames.Truth(record.machine, *[v[:rows] for v in record[1:]])

    table = Table(title=f"RMS errors from 5 s on, {arguments.seeds} seeds, TVE {TVE:.1%}, P_m estimated")
    for column in ("", "delta, rad", "E'd, pu", "E'q, pu", "with E_f estimated: delta", "E'd", "E'q"):
        table.add_column(column)
    m = truth.machine
    cases = {"all right": (m, TVE), "tve / 3": (m, TVE / 3), "tve x 3": (m, TVE * 3)}
    for names in (("xd",), ("xq",), ("Td10",), ("Tq10",), ("xd1", "xq1")):
        for factor in (0.9, 1.1):
            wrong = m._replace(**{name: factor * getattr(m, name) for name in names})
            cases[f"{' and '.join(names)} {factor - 1:+.0%}"] = (wrong, TVE)
    for name, (machine, tve) in cases.items():
        cells = []
        for field_voltage in (1, 2):
            s = frames.series(
                truth._replace(machine=machine),
                frames.noise(TVE),
                arguments.seeds,
                tve=tve,
                field_voltage=field_voltage,
                mechanical_power=2,
            )
            cells += [f"{np.sqrt(np.mean(v[s.t > 5] ** 2)):.5f}" for v in (s.delta, s.e1d, s.e1q)]
        table.add_row(name, *cells)
    Console(width=140).print(table)


if __name__ == "__main__":
    main()
