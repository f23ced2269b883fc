"""The tables of the 39-bus system, as they lie beside this file."""

import csv
from pathlib import Path
from typing import Dict, List, NamedTuple

import numpy as np

FOLDER = Path(__file__).parent


class Branches(NamedTuple):
    """Lines and transformers: pi sections with an ideal transformer of ratio `tap` at the `fbus` end."""

    fbus: np.ndarray
    tbus: np.ndarray
    r: np.ndarray  # pu, like x and the total charging b
    x: np.ndarray
    b: np.ndarray
    tap: np.ndarray


class Machines(NamedTuple):
    """What the model uses of machine.csv (1 = prime), avr.csv and pss.csv; one element a generator."""

    bus: np.ndarray
    H: np.ndarray  # s
    xd: np.ndarray  # pu, like xd1, xq, xq1
    xd1: np.ndarray
    xq: np.ndarray
    xq1: np.ndarray
    Td10: np.ndarray  # s, like all T
    Tq10: np.ndarray
    TR: np.ndarray
    KA: np.ndarray
    TA: np.ndarray
    TB: np.ndarray
    TC: np.ndarray
    E_f_max: np.ndarray  # pu
    E_f_min: np.ndarray
    K: np.ndarray  # of the PSS, pu voltage per pu speed
    Tw: np.ndarray
    T1: np.ndarray
    T2: np.ndarray
    T3: np.ndarray
    T4: np.ndarray
    V_s_max: np.ndarray  # pu
    V_s_min: np.ndarray


def read(name: str) -> Dict[str, List[str]]:
    """The columns of a table by their names, without the comments on top."""
    with open(FOLDER / name, encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    return {column: [row[column] for row in rows] for column in rows[0]}


# when imported: a host may delete the folder of an unpacked FMU, and load the FMU again from sys.modules
BUS, BRANCH, SETPOINTS, MACHINE, AVR, PSS = (
    read(name) for name in ("bus.csv", "branch.csv", "setpoints.csv", "machine.csv", "avr.csv", "pss.csv")
)


def numbers(table: Dict[str, List[str]]) -> Dict[str, np.ndarray]:
    return {column: np.array(values, dtype=float) for column, values in table.items()}


def branches() -> Branches:
    table = numbers(BRANCH)
    return Branches(table["fbus"].astype(int), table["tbus"].astype(int), *[table[c] for c in ("r", "x", "b", "tap")])


def machines(salient: bool) -> Machines:
    """The generators, with x'q := x'd as the paper has them, or x'q of the table if `salient`."""
    machine, avr, pss = numbers(MACHINE), numbers(AVR), numbers(PSS)
    return Machines(
        bus=machine["bus"].astype(int),
        H=machine["H"],
        xd=machine["xd"],
        xd1=machine["xd_t"],
        xq=machine["xq"],
        xq1=machine["xq_t" if salient else "xd_t"],
        Td10=machine["Td0_t"],
        Tq10=machine["Tq0_t"],
        **{name: avr[name] for name in ("TR", "KA", "TA", "TB", "TC")},
        E_f_max=avr["Efd_max"],
        E_f_min=avr["Efd_min"],
        **{name: pss[name] for name in ("K", "Tw", "T1", "T2", "T3", "T4")},
        V_s_max=pss["Vmax"],
        V_s_min=pss["Vmin"],
    )
