"""`observe`: the FMU over a record, against the truth of another simulator; and what can be wrong with it."""

import json

import numpy as np
import pytest

from scenarios import loader, study
from scenarios.__main__ import main
from scenarios.records import standard

from . import exports

FRAMES = 360

MACHINES = """unit,machine_model,S_n,V_n,omega_s,H,D,xd,xd1,xd2,xq,xq1,xl,Td10,Tq10,Td20,Tq20,Ra
G6,two_axis,1000,22,376.99111843077515,3.48,0,2.54,0.5,,2.41,0.5,,7.3,0.4,,,0
G6 round,genrou,1000,22,376.99111843077515,3.48,0,2.54,0.5,0.4,2.41,0.5,0.224,7.3,0.4,0.05,0.035,0
"""


@pytest.fixture(scope="module")
def truth():
    return np.genfromtxt(loader.FOLDER / "data" / "record_g6.csv", delimiter=",", names=True)


@pytest.fixture
def folder(tmp_path, dist, monkeypatch):
    """A record of the first seconds, and its machine."""
    monkeypatch.setattr(study, "DIST", dist)
    study.build_once.cache_clear()
    (tmp_path / "machines.csv").write_text(MACHINES)
    whole = standard.read(loader.FOLDER / "data" / "record_g6.csv")
    lines = (loader.FOLDER / "data" / "record_g6.csv").read_text().splitlines()
    (tmp_path / "record.csv").write_text("\n".join(lines[: FRAMES + 1]) + "\n")
    assert len(whole) > FRAMES
    yield tmp_path
    study.build_once.cache_clear()


def names(estimate: np.ndarray) -> tuple[str, ...]:
    return estimate.dtype.names or ()


def observed(folder, *arguments, record="record.csv", unit="G6") -> tuple[int, np.ndarray]:
    machine = ["--machine", str(folder / "machines.csv"), "--unit", unit, "--out", str(folder / "out")]
    code = main(["observe", str(folder / record), *machine, *arguments])
    path = folder / "out" / "estimate.csv"
    return code, np.genfromtxt(path, delimiter=",", names=True, skip_header=2) if path.exists() else np.array([])


def test_rotor_angle_of_a_record(folder, truth, capsys):
    code, estimate = observed(folder)
    assert code == 0
    assert "captured (status 2)" in capsys.readouterr().out
    np.testing.assert_allclose(estimate["time"], truth["time"][:FRAMES], atol=1e-8)
    for name in ("delta", "e1d", "e1q"):
        # 1e-3: what the step of the network at 1 s leaves within a frame
        np.testing.assert_allclose(estimate[name][120:], truth[name][120:FRAMES], atol=1e-3)
    assert set(estimate["status"][30:]) == {2}
    assert "E_f_hat" not in names(estimate)  # it is the input
    summary = json.loads((folder / "out" / "summary.json").read_text())
    assert summary["captured_s"] < 0.5 and summary["frames"] == FRAMES and summary["findings"] == []
    assert (folder / "out" / "estimate.png").stat().st_size > 10_000


def test_what_was_not_recorded_is_estimated_and_lost_frames_are_held(folder, truth):
    record = standard.read(folder / "record.csv")
    lost = (record.time > 4) & (record.time < 4.3)
    for name in standard.VALUES:
        getattr(record, name)[lost] = np.nan
    record.P_m[:], record.E_f[:] = np.nan, np.nan
    record.frame_valid[lost] = False
    standard.write(record, folder / "poor.csv")
    code, estimate = observed(folder, record="poor.csv")
    assert code == 0
    assert {"E_f_hat", "P_m_hat"} <= set(names(estimate))
    assert all(np.isfinite(estimate[name]).all() for name in names(estimate))
    assert set(estimate["status"][lost[:FRAMES]]) == {3}
    # the band holds the truth, and is no wider than 0.1 pu
    late = slice(180, FRAMES)
    error = np.abs(estimate["E_f_hat"] - truth["E_f"][:FRAMES])[late]
    assert (error < 4 * estimate["E_f_std"][late]).all() and np.median(estimate["E_f_std"][late]) < 0.1


VARIANTS = [
    "semicolons, decimal commas, a units row, Windows line ends, cp1252",
    "openPDC's CsvExporter",
    "load convention",
]


def test_every_export_gives_the_same_estimate(folder, capsys):
    reference = None
    frames = exports.frames(standard.read(folder / "record.csv"))[:120]
    for name in VARIANTS:
        path, text = exports.EXPORTS[name](frames, folder)
        (folder / "map.toml").write_text(text)
        out = str(folder / "converted.csv")
        assert main(["convert", str(path), "--map", str(folder / "map.toml"), "--out", out, "--force"]) == 0
        _, estimate = observed(folder, record="converted.csv")
        values = np.array([estimate[n] for n in names(estimate)])
        reference = values if reference is None else reference
        np.testing.assert_allclose(values, reference, atol=1e-7)


def test_a_pmu_at_the_high_side(folder, truth):
    """x_T = 0.143 on 1000 MVA, Yd11, tap 1.025."""
    record = standard.read(folder / "record.csv")
    turn = np.exp(1j * np.pi / 6)
    V, I = turn / 1.025 * (record.V - 0.0143j * record.I), 1.025 * turn * record.I  # noqa: E741 - the paper's name
    S = V * np.conj(I)
    for name, values in {"V_t": abs(V), "theta_t": np.angle(V), "I_t": abs(I), "phi_t": np.angle(I)}.items():
        getattr(record, name)[:] = values
    record.P_t[:], record.Q_t[:] = S.real, S.imag
    standard.write(record, folder / "high.csv")
    given = ["--set", "x_T=0.143", "--set", "tap=1.025", "--set", "shift=0.5235987755982988"]
    _, estimate = observed(folder, *given, record="high.csv")
    for name in ("delta", "e1d", "e1q"):
        np.testing.assert_allclose(estimate[name][120:], truth[name][120:FRAMES], atol=1e-3)


def test_nonsense_is_said_and_the_exit_code_is_1(folder, capsys):
    record = standard.read(folder / "record.csv")
    record.Q_t[:] *= -1
    standard.write(record, folder / "wrong.csv")
    code, _ = observed(folder, record="wrong.csv")
    assert code == 1
    assert "Q has the sign of the load convention: Q: direction" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "unit", "message"),
    [
        (["--set", "tv=0"], "G6", 'no parameter "tv"; did you mean "tve"?'),
        (["--set", "tve"], "G6", "--set tve: write NAME=VALUE"),
        (["--set", "field_voltage=guessed"], "G6", "field_voltage = 'guessed' is not allowed"),
        (["--set", "H=-1"], "G6", "H = -1 is not allowed"),
        ([], "G7", 'machines.csv has no unit "G7"; known: G6, G6 round'),
    ],
)
def test_wrong_usage_is_one_line_and_nothing_is_written(arguments, unit, message, folder, capsys):
    code, _ = observed(folder, *arguments, unit=unit)
    said = capsys.readouterr().err
    assert code == 2 and message in said and said.count("\n") == 1
    assert not list(folder.glob("out/*"))
