"""The GENROU records of an independent simulator, ANDES: see scenarios/data/README.md."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fmu_src.pmu_observer.machines.data import Machine, on_system_base

DATA = Path(__file__).parent.parent / "scenarios" / "data"

K3 = Machine(
    H=6.175, D=0.0, xd=1.8, xd1=0.3, xq=1.7, xq1=0.55, Td10=8.0, Tq10=0.4, Ra=0.0025, omega_s=2 * np.pi * 60,
    xd2=0.25, xq2=0.25, xl=0.2, Td20=0.03, Tq20=0.05, S10=0.10, S12=0.40,
)  # fmt: skip
"""pu on 900 MVA."""

G6 = Machine(
    H=3.48, D=0.0, xd=2.54, xd1=0.5, xq=2.41, xq1=0.814, Td10=7.3, Tq10=0.4, Ra=0.0, omega_s=2 * np.pi * 60,
    xd2=0.431, xq2=0.431, xl=0.224, Td20=0.05, Tq20=0.035, S10=0.10, S12=0.35,
)  # fmt: skip
"""pu on 1000 MVA."""

GENROU_RECORDS = {
    "k3_fault": (on_system_base(K3, 900.0, 100.0), (2.005, 2.105)),
    "k3_loadstep": (on_system_base(K3, 900.0, 100.0), (2.005,)),
    "g6_loadstep": (on_system_base(G6, 1000.0, 100.0), (2.005,)),
}


@dataclass(frozen=True)
class Record:
    machine: Machine  # pu on 100 MVA
    events: tuple[float, ...]  # s
    columns: dict[str, np.ndarray]

    def __getitem__(self, name: str) -> np.ndarray:
        return self.columns[name]


def genrou_record(name: str) -> Record:
    machine, events = GENROU_RECORDS[name]
    with (DATA / f"genrou_{name}.csv").open(encoding="utf-8") as file:
        names = file.readline().strip().split(",")
        return Record(machine, events, dict(zip(names, np.loadtxt(file, delimiter=",").T, strict=True)))
