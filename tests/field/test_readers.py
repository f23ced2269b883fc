"""What real files have: dropouts, words for numbers, quality, short rows, secondary values, cuts anywhere."""

from datetime import timedelta

import numpy as np
import pytest

from scenarios import loader
from scenarios.records import map, standard
from scenarios.records.conversion import convert
from scenarios.records.readers import delimited, open_table

from . import exports

FRAMES = 90


@pytest.fixture(scope="session")
def frames():
    return exports.frames(standard.read(loader.FOLDER / "data" / "genrou_k3_fault.csv"))[:FRAMES]


@pytest.fixture
def converted(tmp_path):
    def run(path, text: str):
        (tmp_path / "map.toml").write_text(text, encoding="utf-8")
        chosen = map.load(tmp_path / "map.toml")
        done = convert(map.open_table(chosen, path), chosen, "map.toml", tmp_path / "record.csv", path.name)
        return standard.read(tmp_path / "record.csv"), done

    return run


def lost(record) -> list[int]:
    return np.flatnonzero(~record.frame_valid).tolist()


def test_zeros_blanks_and_words_are_lost_frames(frames, tmp_path, converted):
    rows = [exports.row(x) for x in frames]
    rows[3][3:5] = [0.0, 0.0]  # a dropout of I
    rows[4][1:5] = [0.0] * 4
    rows[5][1] = ""
    rows[6][4] = "Bad Input"
    rows[7][8] = "No Data"  # E_f alone: the frame is good
    exports.wide(tmp_path / "a.csv", rows)
    record, done = converted(tmp_path / "a.csv", exports.MAP)
    assert lost(record) == [3, 4, 5, 6] and done.unusable == 4
    assert np.flatnonzero(np.isnan(record.E_f)).tolist() == [3, 4, 5, 6, 7]


def test_short_rows_blank_lines_and_a_cut_end(frames, tmp_path, converted):
    exports.wide(tmp_path / "a.csv", [exports.row(x) for x in frames])
    lines = (tmp_path / "a.csv").read_text().splitlines()
    lines[10] = lines[10][:40]
    lines.insert(20, "")
    (tmp_path / "a.csv").write_text("\ufeff" + "\n".join(lines)[:-60], encoding="utf-8")
    record, done = converted(tmp_path / "a.csv", exports.MAP)
    assert done.broken == 2 and lost(record) == [9]
    assert len(record) == FRAMES - 1


CUT = [
    "kV line-neutral, degrees, A, MW, ISO times",
    "semicolons, decimal commas, a units row, Windows line ends, cp1252",
    "openPDC's CsvExporter",
]


@pytest.mark.parametrize("size", [3000, 9000])
@pytest.mark.parametrize("name", CUT)
def test_blocks_cut_anywhere(name, size, frames, tmp_path, converted, monkeypatch):
    path, text = exports.EXPORTS[name](frames, tmp_path)
    whole, _ = converted(path, text)
    monkeypatch.setattr(delimited, "BLOCK", size)
    pieces, done = converted(path, text)
    for column in ("V_t", "theta_t", "I_t", "phi_t", "P_t", "Q_t", "P_m", "E_f"):
        np.testing.assert_array_equal(getattr(pieces, column), getattr(whole, column))
    assert done.raster.lost == 0


def test_a_signal_that_fails_in_openpdc(frames, tmp_path, converted):
    path, text = exports.EXPORTS["openPDC's CsvExporter"](frames, tmp_path)
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join(line for i, line in enumerate(lines) if i != 1 + 8 * 30 + 2))  # I of frame 30
    record, _ = converted(path, text)
    assert lost(record) == [30] and len(record) == FRAMES


QUALITY = {
    "words": (lambda k: "Good" if k != 8 else "Questionable", 'good = ["good"]'),
    "numbers": (lambda k: 1 if k != 8 else 0, "good = [1]"),
    "Booleans": (lambda k: "TRUE" if k != 8 else "FALSE", "good = [true]"),
    "STAT word": (lambda k: "0x0010" if k != 8 else "0x4000", "bad_bits = 0xF000"),
    "STAT word, decimal": (lambda k: 16 if k != 8 else 16384, "bad_bits = 0xF000"),
}


@pytest.mark.parametrize("kind", QUALITY)
def test_quality(kind, frames, tmp_path, converted):
    word, text = QUALITY[kind]
    rows = [[*exports.row(x), str(word(k))] for k, x in enumerate(frames)]
    exports.wide(tmp_path / "a.csv", rows, names=(*exports.NAMES, "QUAL"))
    record, _ = converted(tmp_path / "a.csv", exports.MAP + f'valid = {{ column = "QUAL", {text} }}\n')
    assert lost(record) == [8]


def test_comtrade_on_the_secondary_side(frames, tmp_path, converted):
    """22 kV/110 V and 20 000 A/1 A: the file holds secondary values, and says the ratios."""
    path, text = exports.EXPORTS["COMTRADE, ASCII"](frames, tmp_path)
    primary, _ = converted(path, text)
    lines = path.read_text().splitlines()
    for place, ratio in ((2, 200), (4, 20_000)):
        cells = lines[place].split(",")
        cells[5] = repr(float(cells[5]) / ratio)
        lines[place] = ",".join([*cells[:-3], str(ratio), "1", "S"])
    path.write_text("\n".join(lines) + "\n")
    secondary, _ = converted(path, text)
    np.testing.assert_allclose(secondary.V_t, primary.V_t, atol=1e-9)
    np.testing.assert_allclose(secondary.I_t, primary.I_t, atol=1e-9)
    np.testing.assert_allclose(secondary.theta_t, primary.theta_t, atol=1e-9)


def test_comtrade_in_local_time(frames, tmp_path, converted):
    path, text = exports.EXPORTS["COMTRADE, ASCII"](frames, tmp_path)
    local = (exports.START - timedelta(hours=5, minutes=30)).strftime("%d/%m/%Y,%H:%M:%S.%f")
    utc = exports.START.strftime("%d/%m/%Y,%H:%M:%S.%f")
    path.write_text(path.read_text().replace(utc, local).replace("1\n0,0\n", "1\n-5h30,-5h30\n"))
    record, _ = converted(path, text)
    assert record.utc_start == "2024-07-01T10:00:00.000000000Z"


def test_comtrade_without_its_data(frames, tmp_path):
    path, _ = exports.EXPORTS["COMTRADE, ASCII"](frames, tmp_path)
    path.with_suffix(".dat").unlink()
    with pytest.raises(standard.RecordError, match=r"its data file a\.dat is not beside it"):
        open_table(path)
    path.write_text("no station\n")
    with pytest.raises(standard.RecordError, match="is no COMTRADE that can be read"):
        open_table(path)


@pytest.mark.parametrize("rate", [25, 50])
def test_frames_of_a_50_Hz_system(rate, tmp_path, converted):
    """25 and 50 frames a second, stamps cut to 7 digits as openPDC writes them."""
    ns = int(exports.START.timestamp()) * 10**9 + np.rint(np.arange(100) * 1e9 / rate).astype(int)
    rows = [[exports.iso(int(t), 7), 12.7, 10.0 + k, 17e3, -10.0 + k] for k, t in enumerate(ns)]
    exports.wide(tmp_path / "a.csv", rows, names=exports.NAMES[:5])
    record, _ = converted(tmp_path / "a.csv", exports.ISO + exports.V_MAP + exports.I_MAP + "frequency = 50\n")
    assert (record.rate, record.f0, len(record), lost(record)) == (rate, 50.0, 100, [])
    np.testing.assert_allclose(record.t_frame, np.arange(100) / rate, atol=1e-9)


def test_frequency_as_a_deviation_in_mHz(frames, tmp_path, converted):
    rows = [[*exports.row(x), -15.0 + k] for k, x in enumerate(frames)]
    exports.wide(tmp_path / "a.csv", rows, names=(*exports.NAMES, "DF"))
    text = exports.MAP + 'f = { column = "DF", unit = "mHz", deviation = true }\nfrequency = 60\n'
    record, _ = converted(tmp_path / "a.csv", text)
    np.testing.assert_allclose(record.f, 60 + (np.arange(FRAMES) - 15) / 1e3, atol=1e-9)
