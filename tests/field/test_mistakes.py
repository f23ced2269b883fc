"""Every wrong file, map, unit and name: one clear line, exit code 2, nothing half-written."""

import pytest

from scenarios.__main__ import main

CSV = """Time,VM [kV],VA,IM,IA,MW
2024-07-01 10:00:00.000,12.9,10,17000,-12,650
2024-07-01 10:00:00.020,12.9,11,17000,-11,650
2024-07-01 10:00:00.040,12.9,12,17000,-10,650
2024-07-01 10:00:00.060,12.9,13,17000,-9,650
"""
MAP = """
time = { column = "Time", format = "iso", zone = "UTC" }
V = { magnitude = "VM [kV]", angle = "VA", unit = ["kV", "deg"], base = "22 kV line-line", is = "line-neutral" }
I = { magnitude = "IM", angle = "IA", unit = ["A", "deg"] }
P_m = { column = "MW", unit = "MW" }
"""

MAP_MISTAKES = {
    "no TOML": ("V = {", "V = ", "map.toml is not TOML"),
    "no column": ('"VM [kV]"', '"VN"', 'map.toml: V: there is no column "VN"; known: Time, VM [kV], VA'),
    "no unit": ('"kV", "deg"', '"kW", "deg"', 'map.toml: V: unit "kW" is a unit of active power; write V, kV, pu or %'),
    "unknown unit": ('"kV", "deg"', '"kv2", "deg"', 'map.toml: V: unit "kv2" is no unit; known: V, kV,'),
    "unit of the angle": ('["A", "deg"]', '["A"]', 'I: the unit of "IA" is not known; write unit = ["A", "deg"]'),
    "no base": (
        ', base = "22 kV line-line"',
        "",
        'V: base is missing; write base = "22 kV line-line", or give --machine',
    ),
    "base of what": ("22 kV line-line", "22 kV phase", '"phase" is not known; write "22 kV line-line" or'),
    "base of 0": ("22 kV line-line", "0 kV", "it must be positive"),
    "between what": (', is = "line-neutral"', "", "V: say what a voltage in kV is between"),
    "word": ('"line-neutral"', '"star"', 'V.is = "star" is not known; write "line-neutral", "line-line" or "AB"'),
    "unknown key": ("magnitude", "magnitud", 'V.magnitud is not known; did you mean "magnitude"?'),
    "unknown part": ("P_m", "Pm", 'map.toml: Pm is not known; did you mean "P_m"?'),
    "no V": ("V = {", "v = {", "map.toml: V is missing; add it"),
    "half a phasor": (', angle = "VA"', "", "V: give magnitude and angle, or real and imaginary"),
    "two of three": (
        'magnitude = "IM"',
        'magnitude = ["IM", "VA"]',
        "I: give one column for each of the two, or three",
    ),
    "time format": ('"iso"', '"ISO8601"', 'format "ISO8601" is not known; known: iso, epoch, seconds, soc'),
    "zone": ('"UTC"', '"Mars"', 'zone "Mars" is not known; write UTC, +02:00'),
    "no time": ("time = {", "# {", 'map.toml: time is missing; write time = { column = "...", format = "iso" }'),
    "soc without columns": ('format = "iso"', 'format = "soc"', 'format = "soc" goes with soc and fracsec'),
    "text for a table": ('P_m = { column = "MW", unit = "MW" }', 'P_m = "MW"', 'write a table: { column = "MW", ... }'),
    "shift without a unit": ('["A", "deg"] }', '["A", "deg"], shift = 30 }', "write an angle with its unit"),
    "rate": ("P_m", "rate = -1\nP_m", "rate = -1: input should be greater than 0"),
    "which frames are good": ("P_m", 'valid = { column = "MW" }\nP_m', "valid: give good = [1, "),
    "wrong time column": ('"Time"', '"MW"', "the times do not increase; see time in the map"),
    "epoch of text": ('"iso"', '"epoch"', "no row has a time that can be read; see time in the map"),
}


@pytest.fixture
def convert(tmp_path, capsys):
    """The exit code and what is said; nothing else may be said or written."""

    def run(csv: str | bytes = CSV, map: str = MAP, *more: str) -> tuple[int, str]:
        path = tmp_path / "a.csv"
        path.write_bytes(csv if isinstance(csv, bytes) else csv.encode())
        (tmp_path / "map.toml").write_text(map)
        code = main(["convert", str(path), "--map", str(tmp_path / "map.toml"), *more])
        assert [p.name for p in tmp_path.iterdir() if "record" in p.name] == [] or code < 2
        return code, capsys.readouterr().err

    return run


def test_the_right_one_is_right(convert, tmp_path):
    assert convert()[0] in (0, 1)
    assert (tmp_path / "a_record.csv").exists()


@pytest.mark.parametrize("mistake", MAP_MISTAKES)
def test_mistake_in_a_map(mistake, convert):
    right, wrong, message = MAP_MISTAKES[mistake]
    assert right in MAP
    code, said = convert(CSV, MAP.replace(right, wrong, 1))
    assert code == 2
    assert message in said, said
    assert all(line.startswith("error: ") or "map.toml" in line for line in said.splitlines())


FILES = {
    "empty": ("", "a.csv is empty"),
    "text": ("Dear reader,\nthis is a letter.\n", "a.csv has no rows of numbers; is it a table of text with a header?"),
    "no header": ("\n".join(CSV.splitlines()[1:]), "a.csv has no header: give each column a name in its first row"),
    "binary": (b"\x00\x01\x02" * 99, "a.csv is no text"),
    "UTF-16": ("Time,V\n1,2\n".encode("utf-16"), "a.csv is UTF-16 text; save it as UTF-8"),
    "header only": (CSV.splitlines()[0], "a.csv has no rows of numbers"),
    "newest first": ("\n".join([CSV.splitlines()[0], *CSV.splitlines()[:0:-1]]), "the newest frame stands first; sort"),
    "two days": (CSV + "2024-07-09 10:00:00.000,12.9,10,17000,-12,650\n", "the times jump by 8.0 days"),
    "nothing but zeros": (CSV.replace("12.9", "0").replace("17000", "0"), "no frame is usable; see"),
}


@pytest.mark.parametrize("name", FILES)
def test_wrong_file(name, convert):
    content, message = FILES[name]
    code, said = convert(content)
    assert code == 2 and message in said and said.count("\n") == 1, said


def test_nothing_is_written_over(convert, tmp_path):
    (tmp_path / "out.csv").write_text("mine")
    code, said = convert(CSV, MAP, "--out", str(tmp_path / "out.csv"))
    assert code == 2 and "out.csv is there already; give another name, or --force" in said
    assert (tmp_path / "out.csv").read_text() == "mine"


def test_no_such_files(tmp_path, capsys):
    for arguments, message in (
        (
            ["convert", "no.csv"],
            "there is no file map.toml; python -m scenarios convert FILE --guess writes a first map",
        ),
        (["convert", "no.csv", "--guess", "--map", str(tmp_path / "m.toml")], "there is no file no.csv"),
        (["check", "no.csv"], "there is no file no.csv"),
        (["check", str(tmp_path / "a.csv"), "--machine", "no.csv"], "there is no file no.csv"),
        (["machine", "no.dyr"], "there is no file no.dyr"),
    ):
        assert main(arguments) == 2
        assert message in capsys.readouterr().err


MACHINES = "unit,S_n,omega_s,H,xd,xd1,xq,xq1,Td10,Tq10\nG6,1000,377,3.48,2.54,0.5,2.41,0.5,7.3,0.4\n"
MACHINE_MISTAKES = {
    "capital": ("xd1", "Xd1", 'column "Xd1" is not known; did you mean "xd1"?'),
    "no number": ("3.48", "3,48", "the row G6,1000,377,3,48"),
    "text": ("3.48", "big", 'G6: H = "big" is no number'),
    "missing": (",0.4\n", ",\n", "G6: two_axis needs Tq10; fill in the column"),
    "no name": ("\nG6", "\n", "a machine without a name: give it one in the column unit"),
    "no unit column": ("unit", "name", 'column "name" is not known'),
    "model": ("unit,", "unit,machine_model,", None),
    "twice": ("0.4\n", "0.4\nG6,1000,377,3.48,2.54,0.5,2.41,0.5,7.3,0.4\n", "G6 stands twice"),
    "header only": (MACHINES.splitlines()[1], "", "has no machine"),
}


@pytest.mark.parametrize("mistake", MACHINE_MISTAKES)
def test_mistake_in_machines(mistake, tmp_path, capsys):
    right, wrong, message = MACHINE_MISTAKES[mistake]
    text = MACHINES.replace(right, wrong, 1)
    if message is None:
        text, message = text.replace("G6,", "G6,genrow,"), 'machine_model "genrow" is not known; did you mean "genrou"?'
    (tmp_path / "machines.csv").write_text(text)
    (tmp_path / "a.csv").write_text("time,V_t,theta_t,I_t,phi_t\n0,1,0,1,0\n0.02,1,0,1,0\n")
    assert main(["check", str(tmp_path / "a.csv"), "--machine", str(tmp_path / "machines.csv")]) == 2
    assert message in capsys.readouterr().err


RECORDS = {
    "time backwards": ("0.02", "-0.02", "time does not increase after 0.000000 s"),
    "no column": ("phi_t", "phi", 'has no column "phi_t"; did you mean "phi"?'),
    "words": ("0.02,1", "0.02,one", "is not a table of numbers separated by commas"),
    "one row": ("0.02,1,0,1,0\n", "", "holds 1 rows: too few to observe anything"),
    "base": ("time", "# S_base = a lot\ntime", "# S_base = a lot: write a number and its unit"),
}


@pytest.mark.parametrize("mistake", RECORDS)
def test_mistake_in_a_standard_record(mistake, tmp_path, capsys):
    right, wrong, message = RECORDS[mistake]
    text = "time,V_t,theta_t,I_t,phi_t\n0,1,0,1,0\n0.02,1,0,1,0\n".replace(right, wrong, 1)
    (tmp_path / "a.csv").write_text(text)
    assert main(["check", str(tmp_path / "a.csv")]) == 2
    said = capsys.readouterr().err
    assert message in said and said.count("\n") == 1
