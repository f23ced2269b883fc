"""PSS/E's .dyr and .raw: every way to write a record, every model's constants, and what is refused."""

from math import pi

import pytest
from fmpy import read_model_description, simulate_fmu
from fmpy.ssp.ssd import read_ssv

from scenarios.__main__ import main
from scenarios.machines import dyr, psse, ssv, table
from scenarios.machines.table import MachineError

RAW = """0, 100.00, 33, 0, 1, 50.00 / PSS(R)E 33
a case
of four machines
1,'ONE         ', 22.0,2
2,'TWO         ', 15.0,2
7,'HV          ', 400.0,2
0 / END OF BUS DATA, BEGIN LOAD DATA
1,'1 ',1
0 / END OF LOAD DATA, BEGIN FIXED SHUNT DATA
0 / END OF FIXED SHUNT DATA, BEGIN GENERATOR DATA
1,'1 ',500.0,100.0,300.0,-300.0,1.02,0,600.0,0.003,0.25,0.0,0.0,1.0,1
1,'2 ',500.0,100.0,300.0,-300.0,1.02,0,650.0,0.0,0.25,0.0,0.0,1.0,1
2,'H ',80.0,10.0,30.0,-30.0,1.0,0,100.0,0.004,0.2,0.0,0.0,1.0,1
7,'1 ',80.0,10.0,30.0,-30.0,1.0,0,200.0,0.0,0.2,0.002,0.14,1.025,1
0 / END OF GENERATOR DATA, BEGIN BRANCH DATA
Q
"""
DYR = """// a comment, and a line that is no record
  some words
1 'GENROU' 1   8.0 0.03 0.4 0.05   6.5 1.0 1.8 1.7 0.3
   0.55 0.25 0.2 0.1 0.4 /  a remark with / and 'quotes
1, "GENROE", '2 ', 8.0, .03, .4, .05, 6.5,, 1.8, 1.7, .3, .55, .25, .2, .1, .4/
2 GENSAL H 5.0 0.05 0.06 3.0 0.0 1.1 0.7 0.25 0.2 0.12 0.11 0.39 /
1 'TGOV1' 1 0.05 0.49 33.0 0.4 2.1 7.0 0.0 /
7 'USRMDL' 1 'GENTPJU1' 1 1 2 16 6 3   11 12
  7.0 0.04 0.7 0.05 4.0 2.0 2.1 2.0 0.3 0.45 0.22 0.24 0.15 0.09 0.38 0.06 /
9 'GENCLS' 1 3.0 0.0 / 10 'REGCA1' 1 /
10 'REGCA1' 1 0.02 1.0 /
11 'GENXYZ' 1 2.0 /
"""


@pytest.fixture
def case(tmp_path):
    (tmp_path / "a.dyr").write_text(DYR)
    (tmp_path / "a.raw").write_text(RAW)
    return tmp_path


def test_machines_of_a_case(case):
    machines, refused = psse.read(case / "a.dyr", case / "a.raw")
    rou, roe, sal, tpj = machines
    D = 1.0 / (2 * pi * 50)  # PSS/E's is pu torque per pu speed
    expected = {
        "machine_model": "genrou", "Td10": 8.0, "Td20": 0.03, "Tq10": 0.4, "Tq20": 0.05, "H": 6.5, "D": D, "xd": 1.8,
        "xq": 1.7, "xd1": 0.3, "xq1": 0.55, "xd2": 0.25, "xl": 0.2, "S10": 0.1, "S12": 0.4, "S_n": 600.0, "Ra": 0.003,
        "omega_s": 2 * pi * 50,
    }  # fmt: skip
    assert rou.parameters == expected
    assert (rou.unit, rou.bus, rou.id, rou.V_n) == ("ONE_1_1", "1", "1", 22.0)
    assert roe.parameters == {**expected, "D": 0.0, "S_n": 650.0, "Ra": 0.0} and "exponential" in roe.comment
    assert sal.parameters == {
        "machine_model": "gensal", "Td10": 5.0, "Td20": 0.05, "Tq20": 0.06, "H": 3.0, "D": 0.0, "xd": 1.1, "xq": 0.7,
        "xd1": 0.25, "xd2": 0.2, "xl": 0.12, "S10": 0.11, "S12": 0.39, "S_n": 100.0, "Ra": 0.004,
        "omega_s": 2 * pi * 50,
    }  # fmt: skip
    assert tpj.parameters == {
        "machine_model": "gentpj", "Td10": 7.0, "Td20": 0.04, "Tq10": 0.7, "Tq20": 0.05, "H": 4.0, "D": 2 * D,
        "xd": 2.1, "xq": 2.0, "xd1": 0.3, "xq1": 0.45, "xd2": 0.22, "xq2": 0.24, "xl": 0.15, "S10": 0.09,
        "S12": 0.38, "Kis": 0.06, "S_n": 200.0, "Ra": 0.0, "omega_s": 2 * pi * 50, "x_T": 0.14, "r_T": 0.002,
        "tap": 1 / 1.025,
    }  # fmt: skip
    assert tpj.V_n is None  # 400 kV is not the machine's
    assert {r.model: r.bus for r in refused} == {"GENCLS": 9, "REGCA1": 10, "GENXYZ": 11}
    assert "constant voltage" in refused[0].reason and "converter" in refused[1].reason


@pytest.mark.parametrize(
    ("right", "wrong", "message"),
    [
        ("0.1 0.4 /", "0.1 x /", 'a.dyr, line 3: the record "1 GENROU 1 8.0 ...": "x" is no number'),
        (
            "0.55 0.25 0.2 0.1 0.4 /",
            "0.55 /",
            "a.dyr, line 3: the GENROU at bus 1, id 1 has 10 constants; GENROU has 14",
        ),
        (
            "11 'GENXYZ' 1 2.0 /",
            "11 'GENXYZ' 1 2.0",
            'a.dyr, line 12: the record "11 GENXYZ 1 2.0 ..." has no / at its end',
        ),
        ("'GENTPJU1' 1 1 2 16", "'GENTPJU1' 1 1 x 16", "line 8: the record"),
    ],
)
def test_broken_dyr(right, wrong, message, case):
    assert right in DYR
    (case / "a.dyr").write_text(DYR.replace(right, wrong, 1))
    with pytest.raises(MachineError) as error:
        psse.read(case / "a.dyr", case / "a.raw")
    assert message in str(error.value)


@pytest.mark.parametrize(
    ("right", "wrong", "message"),
    [
        ("0, 100.00, 33", "a case", 'a.raw, line 1: "a case, 0, 1, 50.00 / PSS(R)E 33" is not IC, SBASE, REV, ...'),
        ("-300.0,1.02,0,600.0", "-300.0,1.02,0,-600", "line 11: \"1,'1 ',500.0"),
        ("BEGIN GENERATOR DATA", "BEGIN NOTHING", None),
        (", 0, 1, 50.00", "", "the nominal frequency is not known"),
    ],
)
def test_broken_raw(right, wrong, message, case):
    assert right in RAW
    (case / "a.raw").write_text(RAW.replace(right, wrong, 1))
    if message is None:  # the order of the sections tells
        assert len(psse.read(case / "a.dyr", case / "a.raw")[0]) == 4
        return
    with pytest.raises(MachineError) as error:
        psse.read(case / "a.dyr", case / "a.raw")
    assert message in str(error.value)


def test_version_35_has_a_section_and_a_field_more(case):
    text = RAW.replace(", 33,", ", 35,").replace(
        "1,'ONE", "GENERAL, THRSHZ=0.0001\n0 / END, BEGIN BUS DATA\n@!I\n1,'ONE"
    )
    lines = [line.replace(",0,600.0", ",0,0,600.0").replace(",0,650.0", ",0,0,650.0") for line in text.splitlines()]
    lines = [line.replace(",1.0,0,100.0", ",1.0,0,0,100.0").replace(",1.0,0,200.0", ",1.0,0,0,200.0") for line in lines]
    (case / "a.raw").write_text("\n".join(lines))
    assert [m["S_n"] for m in psse.read(case / "a.dyr", case / "a.raw")[0]] == [600.0, 650.0, 100.0, 200.0]


def test_what_the_raw_lacks_or_a_zero_is_refused_with_its_reason(case):
    (case / "a.raw").write_text(RAW.replace("2,'H '", "2,'G '"))
    (case / "a.dyr").write_text(DYR.replace("8.0 0.03 0.4", "8.0 0.03 0.0"))
    refused = {r.bus: r.reason for r in psse.read(case / "a.dyr", case / "a.raw")[1]}
    assert "has no generator H at bus 2" in refused[2]
    assert refused[1] == "line 3: Tq10 is not above 0"


def test_command(case, capsys):
    out = case / "machines.csv"
    assert main(["machine", str(case / "a.dyr"), "--raw", str(case / "a.raw"), "--out", str(out)]) == 0
    machines, _ = psse.read(case / "a.dyr", case / "a.raw")
    assert table.read_machines(out) == {m.unit: m for m in machines}
    assert "not used: 1 GENCLS" in capsys.readouterr().out
    assert main(["machine", str(case / "a.dyr"), "--raw", str(case / "a.raw"), "--out", str(out)]) == 2
    assert "is there already" in capsys.readouterr().err
    assert main(["machine", str(case / "a.dyr"), "--raw", str(case / "a.raw"), "--bus", "5"]) == 2
    assert "there is no usable machine at bus 5" in capsys.readouterr().err
    alone = ["machine", str(case / "a.dyr"), "--bus", "2", "--S-n", "100", "--frequency", "50"]
    assert main(alone) == 0
    assert "--start-values machine_model 4 " in capsys.readouterr().out
    assert main(alone[:2]) == 2
    assert "give --frequency 60" in capsys.readouterr().err


def test_fields_between_commas():
    assert dyr.fields("1, 'A B' ,,2 3,, 4") == ["1", "A B", None, "2", "3", None, "4"]


def test_the_fmu_takes_the_parameter_set(case, dist):
    """FMPy reads the .ssv; and the observer knows every name of it that it has a parameter for."""
    machines, _ = psse.read(case / "a.dyr", case / "a.raw")
    ssv.write(machines[0], case / "m.ssv")
    values = {parameter.name: parameter.value for parameter in read_ssv(str(case / "m.ssv")).parameters}
    assert {name: float(values[name]) for name in ("H", "xd", "D")} == {n: machines[0][n] for n in ("H", "xd", "D")}
    fmu = dist / "python" / "PmuObserver.fmu"
    known = {v.name for v in read_model_description(str(fmu)).modelVariables if v.causality == "parameter"}
    assert {"H", "D", "xd", "xd1", "xq", "xq1", "Td10", "Tq10", "Ra", "omega_s", "S_n"} <= values.keys() & known
    texts = ssv.start_values(machines[0]).split()
    starts = dict(zip(texts[::2], texts[1::2], strict=True))
    starts = {name: value for name, value in starts.items() if name in known and name != "machine_model"}
    simulate_fmu(str(fmu), start_values=starts, stop_time=0.1)
