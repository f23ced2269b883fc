"""Public cases, field by field as ANDES reads them (extra: bench). GENSAL by hand: ANDES gives it a q-axis winding."""

from math import pi
from pathlib import Path

import pytest

from scenarios.machines import psse

andes = pytest.importorskip("andes", reason="extra bench")

CASES = {
    "wecc": ("wecc/wecc.raw", "wecc/wecc_full.dyr"),
    "npcc": ("npcc/npcc.raw", "npcc/npcc_full.dyr"),
    "nordic44": ("nordic44/N44_BC.raw", "nordic44/N44_BC.dyr"),
    "kundur": ("kundur/kundur.raw", "kundur/kundur_full.dyr"),
    "ieee14": ("ieee14/ieee14.raw", "ieee14/ieee14.dyr"),
}
COUNT = {"wecc": 29, "npcc": 27, "nordic44": 80, "kundur": 4, "ieee14": 5}
"""Machines: 145 together."""

FIELDS = {
    "Td10": "Td10",
    "Td20": "Td20",
    "Tq20": "Tq20",
    "xd": "xd",
    "xq": "xq",
    "xd1": "xd1",
    "xd2": "xd2",
    "xl": "xl",
}
FIELDS |= {"Ra": "ra", "S_n": "Sn", "S10": "S10", "S12": "S12"}
ROUND = {"Tq10": "Tq10", "xq1": "xq1"}


@pytest.mark.parametrize("name", CASES)
def test_as_andes_reads_it(name):
    raw, dyr = (Path(andes.get_case(case)) for case in CASES[name])
    machines, _ = psse.read(dyr, raw)
    system = andes.load(str(raw), addfile=str(dyr), setup=False, no_output=True, default_config=True)
    rows = {}
    for _, row in system.GENROU.as_df().iterrows():
        rows[str(row["bus"]), str(row["gen"])] = row
    assert len(machines) == COUNT[name] == len(rows)
    left = list(rows.values())
    for m in machines:
        # ANDES numbers the generators anew: those of a bus come in the order of the file
        row = next(row for row in left if str(row["bus"]) == m.bus)
        left = [other for other in left if other is not row]
        salient = m.parameters["machine_model"] == "gensal"
        for ours, theirs in {**FIELDS, **({} if salient else ROUND)}.items():
            assert m.parameters[ours] == pytest.approx(row[theirs], rel=1e-12, abs=1e-12), (m.unit, ours)
        assert 2 * m["H"] == pytest.approx(row["M"]), m.unit
        assert m["D"] * m["omega_s"] == pytest.approx(row["D"], abs=1e-12), m.unit
        if salient:
            assert not {"xq1", "Tq10"} & m.parameters.keys()  # there is no such winding


def test_gensal_by_hand():
    """The first GENSAL of Nordic44, at bus 3115: its constants as they stand in the file."""
    raw, dyr = (Path(andes.get_case(case)) for case in CASES["nordic44"])
    m = next(m for m in psse.read(dyr, raw)[0] if m.parameters["machine_model"] == "gensal")
    expected = {
        "Td10": 7.57, "Td20": 0.045, "Tq20": 0.1, "H": 4.741, "D": 0.0, "xd": 0.946, "xq": 0.565, "xd1": 0.29,
        "xd2": 0.23, "xl": 0.11077, "S10": 0.10239, "S12": 0.2742, "S_n": 1100.0, "Ra": 0.0, "omega_s": 2 * pi * 50,
    }  # fmt: skip
    assert m.parameters == {"machine_model": "gensal", **expected}
