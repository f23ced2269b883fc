"""The example of the README: the commands as they stand there, on the file that comes with the project."""

import re
import shlex
import shutil

import numpy as np
import pytest
from fmpy import read_csv

from scenarios import loader, study
from scenarios.__main__ import main
from scenarios.records import example, standard

README = loader.FOLDER / "records" / "README.md"
DATA = loader.FOLDER / "data"


@pytest.fixture
def here(tmp_path, dist, monkeypatch):
    """A folder with scenarios/data, as the README's commands want it."""
    shutil.copytree(DATA, tmp_path / "scenarios" / "data")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(study, "DIST", dist)
    study.build_once.cache_clear()
    yield tmp_path
    study.build_once.cache_clear()


def test_commands_of_the_readme(here, capsys):
    block = re.findall(r"^```sh\n(.*?)^```$", README.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)[1]
    commands = [line.removeprefix("python -m scenarios ") for line in block.splitlines()]
    assert [main(shlex.split(command)) for command in commands] == [0, 0]
    assert "nothing speaks against this record" in capsys.readouterr().out
    path = here / "results" / "observe_g6" / "estimate.csv"
    estimate = np.genfromtxt(path, delimiter=",", names=True, skip_header=3)
    truth = np.genfromtxt(DATA / "record_g6.csv", delimiter=",", names=True)
    late = slice(120, None)
    for name, bound in (("delta", 0.02), ("e1d", 0.01), ("e1q", 0.01)):
        assert np.abs(estimate[name] - truth[name])[late].max() < bound
    assert abs(estimate["delta"][-1] - truth["delta"][-1]) < 2e-3  # "-0.410 rad", as the README says


def test_the_example_is_what_its_command_makes(here, monkeypatch):
    monkeypatch.setattr(example, "DATA", here / "scenarios" / "data")
    before = (DATA / "utility_g6.csv").read_text()
    example.main()
    assert (here / "scenarios" / "data" / "utility_g6.csv").read_text() == before


def test_guessed_map_needs_only_what_no_header_says(here):
    assert main(["convert", "scenarios/data/utility_g6.csv", "--guess"]) == 0
    text = (here / "map.toml").read_text()
    assert "? base, is" in text and '"?"' not in text
    assert main(["convert", "scenarios/data/utility_g6.csv", "--out", "guessed.csv"]) == 0
    assert (
        main(["convert", "scenarios/data/utility_g6.csv", "--map", "scenarios/data/utility_g6.toml", "--out", "g6.csv"])
        == 0
    )
    guessed, right = standard.read("guessed.csv"), standard.read("g6.csv")
    np.testing.assert_array_equal(np.nan_to_num(guessed.V[:100]), np.nan_to_num(right.V[:100]))


def test_fmpy_takes_a_standard_record(here):
    """Without its comment lines; lost rows are nan, and FMPy hands them over with frame_valid = 0."""
    assert (
        main(["convert", "scenarios/data/utility_g6.csv", "--map", "scenarios/data/utility_g6.toml", "--out", "g6.csv"])
        == 0
    )
    lines = [line for line in (here / "g6.csv").read_text().splitlines() if not line.startswith("#")]
    (here / "input.csv").write_text("\n".join(lines) + "\n")
    table = read_csv("input.csv")
    assert {"time", "t_frame", "frame_valid", "V_t"} <= set(table.dtype.names or ()) and np.isnan(
        table["V_t"]
    ).sum() == 43


def test_a_scenario_takes_a_file_with_its_map(here, tmp_path):
    """And the machines of machines.csv, by name."""
    (tmp_path / "s.toml").write_text("""
    title = "A utility's file as a source"
    step = "1/60"
    stop = 4.0
    fmu.observer.model = "PmuObserver"
    fmu.observer.rows = "scenarios/data/machines.csv"
    csv.record = { file = "scenarios/data/utility_g6.csv", map = "scenarios/data/utility_g6.toml" }
    connect.observer = "record"
    [fmu.observer.parameters]
    H = "{H}"
    xd = "{xd}"
    xd1 = "{xd1}"
    xq = "{xq}"
    xq1 = "{xq1}"
    Td10 = "{Td10}"
    Tq10 = "{Tq10}"
    S_n = "{S_n}"
    omega_s = "{omega_s}"
    D = "{D}"
    field_voltage = "estimated"
    mechanical_power = "estimated"
    frame_time = "stamped"
    [[expect]]
    variable = "observer.e1q"
    each.unit = "G6"
    at = 4.0
    near = 1.041
    within = 0.005
    """)
    assert main(["run", str(tmp_path / "s.toml")]) == 0
    (tmp_path / "s.toml").write_text((tmp_path / "s.toml").read_text().replace("utility_g6.toml", "no.toml"))
    assert main(["run", str(tmp_path / "s.toml")]) == 2
