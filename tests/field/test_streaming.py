"""A record in pieces is the record."""

import numpy as np
import pytest

from scenarios import loader
from scenarios.records import standard, streaming
from scenarios.records.readers import delimited
from scenarios.records.standard import RecordError

RECORD = loader.FOLDER / "data" / "genrou_k3_fault.csv"


@pytest.fixture
def path(tmp_path, monkeypatch):
    """A record with a lost frame, read in blocks of some twenty rows."""
    record = standard.read(RECORD)
    for name in standard.VALUES:
        getattr(record, name)[70] = np.nan
    record.frame_valid[70] = False
    standard.write(record, tmp_path / "a.csv")
    monkeypatch.setattr(delimited, "BLOCK", 3000)
    return tmp_path / "a.csv"


def test_pieces_together_are_the_record(path):
    whole = standard.read(path)
    pieces = list(streaming.pieces(path))
    assert len(pieces) > 20 and pieces[-1][1] == 1.0
    for name in standard.COLUMNS:
        together = np.concatenate([getattr(piece, name) for piece, _ in pieces])
        np.testing.assert_array_equal(together, getattr(whole, name))
    assert all(piece.facts == whole.facts for piece, _ in pieces)


def test_a_sample_of_a_long_record(path, monkeypatch):
    monkeypatch.setattr(streaming, "LARGE", 1)
    monkeypatch.setattr(streaming, "SOME", 3)
    found, whole = streaming.sample(path), standard.read(path)
    assert 100 < len(found) < len(whole) / 2
    assert set(found.time) < set(whole.time)


def test_time_that_goes_back_between_two_pieces(path):
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join([*lines[:500], *lines[400:]]))
    with pytest.raises(RecordError, match="time does not increase after"):
        list(streaming.pieces(path))
