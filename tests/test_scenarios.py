"""Every scenario holds what it expects, and the master does what the scenario format says."""

import csv
import json
import subprocess
import sys
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
from fmpy import simulate_fmu
from fmpy.util import read_csv
from rich.console import Console

import build_fmu
from scenarios import figures, loader, master, report, study
from scenarios.__main__ import main
from scenarios.expectations import judge
from scenarios.fmu import Fmu
from scenarios.master import Results

PAPER = """
title = "The paper's case"
step = 0.02
stop = 1.0
inputs = { P_m = 0.1, E_f = 0.1 }
fmu.plant.model = "SmibPlant"
fmu.observer.model = "PmuObserver"
connect.observer = "plant"
"""


@pytest.fixture
def run(tmp_path):
    """Runs the text of a scenario file, and returns `values(reference)`: one row of values an instance."""

    def run(text: str):
        path = tmp_path / "test.toml"
        path.write_text(text)
        with study.prepared(loader.load(str(path))) as plan:
            results = master.run(plan)
        return lambda reference: np.array([results.of(signal) for signal in plan.signals[reference]])

    return run


def watched(*variables: str) -> str:
    panels = ", ".join(f'{{ curves = "{variable}" }}' for variable in variables)
    return f'figure = [{{ name = "all", title = "all", panel = [{panels}] }}]\n'


@pytest.mark.parametrize("name", loader.names())
@pytest.mark.usefixtures("native_dist")
def test_scenario_holds(name, tmp_path):
    """With either kind of FMU, and the kinds agree."""
    scenario = loader.load(name)
    python, native = (with_all_outputs(scenario, kind) for kind in study.KINDS)
    for results in (python, native):
        verdicts = judge(results)
        assert verdicts
        assert not [verdict for verdict in verdicts if not verdict.holds]
    if sys.platform == "linux":  # elsewhere the binary has another libm than Python
        assert disagreement(python, native) <= 1e-10
    check_reports(python, tmp_path)


def with_all_outputs(scenario, kind: str) -> Results:
    """A run with every output of every instance, not only what the scenario looks at."""
    with study.prepared(scenario, kind) as plan:
        for instance in plan.instances:
            variables = plan.components[instance.component].variables.values()
            instance.watched.update(v.name for v in variables if v.causality == "output")
        return master.run(plan)


def disagreement(python: Results, native: Results) -> float:
    """The largest difference of any variable at any time, as a share of the variable's nominal."""
    nominal = {
        (name, v.name): float(v.nominal or 1.0)
        for name, component in python.plan.components.items()
        if isinstance(component, Fmu)
        for v in component.description.modelVariables
    }
    worst = 0.0
    for (instance, values), others in zip(python.values.items(), native.values.values(), strict=True):
        for name in values.keys() & {name for component, name in nominal if component == instance.component}:
            difference = np.abs(values[name] - others[name]).max()
            worst = max(worst, difference / nominal[instance.component, name])
    print(f"{python.plan.scenario.name}: native and Python FMU differ by {worst:.3g} of the nominal at most")
    return worst


def check_reports(results: Results, folder) -> None:
    """Table, CSV, figures and summary of a run."""
    scenario, verdicts = results.plan.scenario, judge(results)
    study.write(results, verdicts, folder)
    tables = Console(width=100, file=StringIO(), record=True)
    report.print_tables(tables, results, verdicts)
    assert "…" not in tables.export_text()  # nothing is cut off

    lines = [line for line in (folder / f"{scenario.name}.csv").read_text().splitlines() if not line.startswith("#")]
    header = next(csv.reader(lines[:1]))
    assert header[0] == "time" and len(set(header)) == len(header)
    assert len(lines) == scenario.stop / scenario.step + 2  # the header, and the start
    assert all(np.isfinite(values).all() for of_one in results.values.values() for values in of_one.values())
    assert {path.stem for path in folder.glob("*.png")} == {figure.name for figure in scenario.figure}
    assert json.loads((folder / "summary.json").read_text())["holds"]


def test_first_frames_are_exchanged_during_initialisation(run):
    """At t = 0 the plant is at the equilibrium of the field voltage it asked for; the observer has seen its frame."""
    connected = PAPER.replace(
        'connect.observer = "plant"',
        'connect = { observer = "plant", "plant.E_f" = "plant.E_f_start", "observer.E_f" = "plant.E_f_start" }',
    )
    text = connected + watched("plant.delta", "plant.e1q", "plant.E_f_start", "observer.status", "observer.load_angle")
    values = run(text + 'fmu.plant.parameters = { start_mode = "P_m_V_t", V_t_start = 1.02, x_line = 0.3 }\n')
    for variable in ("plant.delta", "plant.e1q"):
        assert np.ptp(values(variable)) < 1e-9  # the equilibrium's own accuracy is 1e-6 a second
    assert values("plant.E_f_start")[0, 0] > 1.0  # not the start value, 0.1
    assert values("observer.status")[0, 0] > 0  # not waiting for a first frame


def test_the_record_of_a_plant_is_as_good_as_the_plant(run, tmp_path):
    """Bit for bit: the observer gets the frame of time t for its step from t, whoever it comes from."""
    frame = ("V_t", "theta_t", "I_t", "phi_t", "P_t", "Q_t")
    estimates = tuple(f"observer.{name}" for name in ("delta", "omega", "e1d", "e1q"))
    values = run(PAPER + watched(*estimates, *[f"plant.{name}" for name in frame]))
    time = np.arange(51) / 50
    columns = [time] + [values(f"plant.{name}")[0] for name in frame]
    lines = ["# a comment", ",".join(("t", *frame))] + [
        ",".join(map(repr, row)) for row in np.array(columns).T.tolist()
    ]
    (tmp_path / "record.csv").write_text("\n".join(lines))
    units = dict(zip(frame, ("pu", "rad", "pu", "rad", "pu", "pu"), strict=True))
    table = "csv.plant.columns = { " + ", ".join(f'{n} = "{n} [{unit}]"' for n, unit in units.items()) + " }\n"
    recorded = PAPER.replace(
        'fmu.plant.model = "SmibPlant"\n', 'csv.plant.file = "record.csv"\ncsv.plant.time = "t [s]"\n'
    )
    from_record = run(recorded + table + watched(*estimates))
    for name in estimates:
        np.testing.assert_array_equal(from_record(name), values(name))


def test_changes_of_inputs_and_tunable_parameters(run):
    """With x_line = 0 the terminal is the infinite bus: V_t shows V_inf at once. A gain of zero stops theta."""
    parameters = 'fmu.observer.parameters = { estimator = "drem", drem.gamma = 1e18 }\n'
    changes = "change = [{ at = 0.5, set = { V_inf = 0.9 } }, { at = 0.9, set = { observer.drem.gamma = 0.0 } }]\n"
    values = run(PAPER + parameters + changes + watched("plant.V_t", "observer.drem.theta1"))
    voltage, theta = values("plant.V_t")[0], values("observer.drem.theta1")[0]
    np.testing.assert_allclose(voltage, np.where(np.arange(51) < 25, 1.0, 0.9), atol=1e-12)
    assert np.ptp(theta[40:45]) > 0
    assert np.ptp(theta[45:]) == 0


def test_instances_of_a_sweep_are_fed_by_those_that_sweep_the_same(run):
    """Two plants and, for each, two observers; x_line = 0, so that each observer shows the V_inf of its plant."""
    sweep = """
    fmu.plant.each.V = [0.9, 1.1]
    fmu.plant.inputs.V_inf = "{V}"
    fmu.observer.each.V = [0.9, 1.1]
    fmu.observer.each.k = [10.0, 20.0]
    fmu.observer.parameters.k_speed = "{k}"
    fmu.observer.parameters.frame_period = 0.0
    """
    text = (
        PAPER.replace("stop = 1.0", "stop = 0.1")
        + sweep
        + 'error.load_angle = "observer.load_angle - plant.load_angle"'
    )
    values = run(text)
    same_plant = values("load_angle").reshape(2, 2, -1)
    np.testing.assert_array_equal(same_plant[:, 0], same_plant[:, 1])  # load_angle does not depend on k_speed
    assert not np.array_equal(same_plant[0], same_plant[1])


def test_prefixed_outputs(tmp_path):
    """observer = "grid.G2.*" takes V_t from G2.V_t: the pattern for many machines in one FMU."""
    columns = ", ".join(f'{machine}.V_t = "{machine} [pu]"' for machine in ("G1", "G2"))
    (tmp_path / "grid.csv").write_text("t,G1,G2\n0,1.0,1.1\n1,1.0,1.1\n")
    (tmp_path / "test.toml").write_text(f"""
    title = "Two machines"
    step = 0.5
    stop = 1.0
    csv.grid = {{ file = "grid.csv", time = "t [s]", columns = {{ {columns} }} }}
    fmu.observer = {{ model = "PmuObserver", each.machine = ["G1", "G2"] }}
    connect.observer = "grid.{{machine}}.*"
    """)
    with study.prepared(loader.load(str(tmp_path / "test.toml"))) as plan:
        linked = [i.links["V_t"].variable for i in plan.instances if i.component == "observer"]
    assert linked == ["G1.V_t", "G2.V_t"]


MACHINES = """
title = "Two machines, of a table"
step = 0.5
stop = 1.0
csv.grid = { file = "grid.csv", time = "t [s]", columns = { G1.V_t = "G1 [pu]", G2.V_t = "G2 [pu]" } }
fmu.observer = { model = "PmuObserver", rows = "machines.csv", parameters = { H = "{inertia}" } }
connect.observer = "grid.G{unit}.*"
error.twice = "2*grid.G{unit}.V_t [pu]"
figure = [{ name = "all", title = "", facet = "unit", panel = [{ curves = ["grid.G{unit}.V_t", "observer.delta"] }] }]
"""


def test_rows_of_a_table_as_instances_and_values_filled_in(tmp_path):
    (tmp_path / "grid.csv").write_text("t,G1,G2\n0,1.0,1.1\n1,1.0,1.1\n")
    (tmp_path / "machines.csv").write_text("# a comment\nunit,inertia\n2,3.5\n1,4\n")
    (tmp_path / "test.toml").write_text(MACHINES)
    scenario = loader.load(str(tmp_path / "test.toml"))
    with study.prepared(scenario) as plan:
        results = master.run(plan)
    observers = [i for i in plan.instances if i.component == "observer"]
    assert [i.label for i in observers] == ["observer[unit = 2]", "observer[unit = 1]"]
    assert [i.parameters["H"] for i in observers] == [3.5, 4]
    assert [i.links["V_t"].variable for i in observers] == ["G2.V_t", "G1.V_t"]
    voltages, twice = plan.signals["grid.G{unit}.V_t"], plan.signals["twice"]
    assert [signal.name for signal in voltages] == ["grid.G2.V_t", "grid.G1.V_t"]
    assert [results.of(signal)[-1] for signal in voltages + twice] == [1.1, 1.0, 2.2, 2.0]
    assert figures.facets(results, scenario.figure[0]) == [{"unit": 2}, {"unit": 1}]


CHANNEL = (
    PAPER.replace('connect.observer = "plant"', 'connect = { "channel.plant.*" = "plant", observer = "channel" }')
    + 'fmu.channel = { model = "PmuChannel", parameters = { rate = 50.0, tve = 0.0 } }\n'
)


def test_what_passes_at_once_is_fed_with_fresh_outputs(run):
    """A channel without noise is no channel: its frame of time t is the plant's of time t, and so are the inputs."""
    change = "change = [{ at = 0.5, set = { P_m = 0.2, V_inf = 0.9 } }]\n"
    estimates = tuple(f"observer.{name}" for name in ("delta", "omega", "e1d", "e1q"))
    direct = run(PAPER + change + watched(*estimates))
    values = run(CHANNEL + change + watched(*estimates, "plant.V_t", "channel.V_t", "channel.P_m"))
    np.testing.assert_array_equal(values("channel.V_t"), values("plant.V_t"))
    np.testing.assert_array_equal(values("channel.P_m")[0], np.where(np.arange(51) < 25, 0.1, 0.2))
    for name in estimates:
        np.testing.assert_allclose(values(name), direct(name), rtol=1e-7, atol=1e-7)  # P and Q: rounded anew


def test_what_passes_at_once_passes_on_in_order(run):
    """The second channel is declared, and so would be stepped, before the first."""
    text = CHANNEL.replace('"channel.plant.*" = "plant"', '"channel.plant.*" = "first", "first.plant.*" = "plant"')
    first = 'fmu.first = { model = "PmuChannel", parameters = { rate = 50.0, tve = 0.0 } }\n'
    values = run(text + first + watched("plant.theta_t", "channel.theta_t"))
    np.testing.assert_array_equal(values("channel.theta_t"), values("plant.theta_t"))


def test_times_do_not_drift():
    scenario = loader.load("smib_revolutions")
    assert scenario.time(3600) == 60.0
    assert scenario.time(1) == 1 / 60


def test_exit_codes(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(study, "RESULTS", tmp_path)
    path = tmp_path / "test.toml"
    expect = 'error.e1d = "observer.e1d - plant.e1d"\nexpect = [{ error = "e1d", at = 1.0, LIMIT = 10.0 }]\n'
    for limit, code in (("below", 0), ("above", 1), ("under", 2)):
        path.write_text(PAPER + expect.replace("LIMIT", limit))
        assert main(["run", str(path)]) == code
    assert "expect.0.under is not known" in capsys.readouterr().err
    assert main(["list"]) == 0 and main(["show", "record_g6"]) == 0
    shown = capsys.readouterr().out
    assert "paper_drem" in shown and "E_f <- record.E_f" in shown
    assert main(["run", "paper_drm"]) == 2
    assert 'did you mean "paper_drem"?' in capsys.readouterr().err
    with pytest.raises(SystemExit) as exit_:
        main(["walk"])
    assert exit_.value.code == 2


@pytest.mark.usefixtures("native_dist")
def test_native_fmus_run_where_there_are_any(tmp_path, monkeypatch, capsys):
    """What has none says so, once, and runs as the Python FMU."""
    monkeypatch.setattr(study, "RESULTS", tmp_path)
    study.build_once.cache_clear()
    (tmp_path / "grid.toml").write_text("""
    title = "One machine of ten"
    step = "1/60"
    stop = 0.1
    fmu = { plant.model = "Ieee39Plant", observer.model = "PmuObserver" }
    connect.observer = "plant.G1.*"
    expect = [{ variable = "observer.status", at = 0.1, above = 0.5 }]
    """)
    assert main(["run", "--fmu", "native", str(tmp_path / "grid.toml")]) == 0
    said = capsys.readouterr().out
    assert said.count("Ieee39Plant: no native FMU") == 1
    assert "PmuObserver: equations to C" in said
    with study.prepared(loader.load(str(tmp_path / "grid.toml")), "native") as plan:
        fmus = {name: component for name, component in plan.components.items() if isinstance(component, Fmu)}
        need_python = {n: (Path(fmu.folder) / "resources" / "slavemodule.txt").is_file() for n, fmu in fmus.items()}
    assert need_python == {"plant": True, "observer": False}


HIDDEN = {
    "casadi": "sys.modules['casadi'] = None",
    "ziglang": "def version(name): raise metadata.PackageNotFoundError(name)\nmetadata.version = version",
}


@pytest.mark.parametrize("missing", HIDDEN)
def test_native_fmus_without_what_builds_them(missing):
    program = f"import sys\nfrom importlib import metadata\nfrom scenarios.__main__ import main\n{HIDDEN[missing]}\n"
    program += "sys.exit(main(['run', '--fmu', 'native', 'paper_drem']))"
    root = Path(build_fmu.__file__).parent
    result = subprocess.run([sys.executable, "-c", program], cwd=root, capture_output=True, text=True, check=False)
    assert result.returncode == 2
    assert result.stderr == f"error: --fmu native needs {missing}: pip install '.[native]'\n"


def test_plain_fmpy_runs_the_observer_on_the_record(dist):
    """The README's way without the master: FMPy steps on every frame of the CSV, and in between."""
    csv_file = loader.FOLDER / "data" / "record_g6.csv"
    record = np.genfromtxt(csv_file, delimiter=",", names=True)
    machine = loader.load("record_g6").parameters
    estimate = simulate_fmu(
        str(dist / "python" / "PmuObserver.fmu"),
        input=read_csv(csv_file),
        stop_time=20.0,
        start_values={**machine, "frame_period": 1 / 60},
    )
    for name in ("delta", "e1d", "e1q"):
        estimated = np.interp(record["time"], estimate["time"], estimate[name])
        # 1e-3: what the step of the network at 1 s and 11 s leaves within a frame
        np.testing.assert_allclose(estimated[120:], record[name][120:], atol=1e-3)
