"""Every format and unit variant of one record converts back to the same standard record."""

from dataclasses import replace

import numpy as np
import pytest

from scenarios import loader
from scenarios.records import map, standard
from scenarios.records.conversion import Converted, convert

from . import exports

FRAMES = 300
DIGITS = {
    "COMTRADE, FLOAT32": 3e-7,  # 24 bits of the largest value, degrees
    "COMTRADE, ASCII": 3e-9,  # 1e-9 kV on 22 kV line-line, in pu, and the writer's 1e-10
}
"""pu and rad, where the format has fewer digits than 1e-9."""


@pytest.fixture(scope="session")
def truth() -> standard.StandardRecord:
    whole = standard.read(loader.FOLDER / "data" / "genrou_k3_fault.csv")
    arrays = {name: getattr(whole, name)[:FRAMES] for name in standard.COLUMNS}
    lag = arrays["theta_t"] - arrays["phi_t"]
    arrays["P_t"], arrays["Q_t"] = (arrays["V_t"] * arrays["I_t"] * part(lag) for part in (np.cos, np.sin))
    return replace(whole, **arrays)


@pytest.fixture
def converted(tmp_path):
    """Converts a file by the text of a map: the record and what was met."""

    def run(path, text: str) -> tuple[standard.StandardRecord, Converted]:
        (tmp_path / "map.toml").write_text(text, encoding="utf-8")
        chosen = map.load(tmp_path / "map.toml")
        table = map.open_table(chosen, path)
        out = tmp_path / "record.csv"
        done = convert(table, chosen, "map.toml", out, path.name)
        return standard.read(out), done

    return run


def assert_same(record, truth, tolerance):
    assert len(record) == len(truth)
    np.testing.assert_allclose(record.time, np.arange(len(truth)) / 60, atol=1e-9)
    np.testing.assert_allclose(record.t_frame, record.time, atol=1e-9)
    assert record.frame_valid.all()
    for name in ("V_t", "I_t", "P_t", "Q_t", "P_m", "E_f"):
        np.testing.assert_allclose(getattr(record, name), getattr(truth, name), rtol=tolerance, atol=tolerance)
    for name in ("theta_t", "phi_t"):
        turn = np.exp(1j * (getattr(record, name) - getattr(truth, name)))
        np.testing.assert_allclose(np.angle(turn), 0, atol=tolerance)


@pytest.mark.parametrize("name", exports.EXPORTS)
def test_export_converts_back(name, truth, converted, tmp_path):
    path, text = exports.EXPORTS[name](exports.frames(truth), tmp_path)
    record, done = converted(path, text)
    assert_same(record, truth, DIGITS.get(name, 1e-9))
    assert record.rate == 60 and record.S_base == 100
    assert record.utc_start == "2024-07-01T10:00:00.000000000Z"
    assert done.raster.frames == FRAMES and done.raster.lost == 0 and done.broken == 0


def test_a_standard_record_converts_to_itself(truth, converted, tmp_path):
    standard.write(truth, tmp_path / "a.csv")
    text = 'V = { magnitude = "V_t", angle = "theta_t" }\nI = { magnitude = "I_t", angle = "phi_t" }\n'
    text += "".join(
        f'{n} = {{ column = "{c}" }}\n' for n, c in (("P", "P_t"), ("Q", "Q_t"), ("P_m", "P_m"), ("E_f", "E_f"))
    )
    record, _ = converted(tmp_path / "a.csv", text)
    assert_same(record, truth, 1e-9)
