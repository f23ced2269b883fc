"""The raster of a record: what is lost, repeated, late, rounded or spread, against counts that the test knows."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenarios.records import times
from scenarios.records.raster import Raster, rate_of
from scenarios.records.standard import RecordError

SECOND = 1_000_000_000
START = 1_719_829_800 * SECOND


def stamps(rate: float, n: int, rounding: int = 1) -> np.ndarray:
    exact = START + np.rint(np.arange(n) * SECOND / rate).astype(np.int64)
    return (exact + rounding // 2) // rounding * rounding


@pytest.mark.parametrize("rate", [10, 12.5, 24, 25, 30, 48, 50, 60, 100, 120, 59.3])
@pytest.mark.parametrize("rounding", [1, 100, 1000, 1_000_000], ids=["ns", "100 ns", "us", "ms"])
def test_rate_from_rounded_stamps_with_gaps(rate, rounding):
    ns = stamps(rate, 3000, rounding)
    keep = np.random.default_rng(3).random(len(ns)) > 0.1
    assert rate_of(ns[keep]) == pytest.approx(rate, rel=1e-4)


@given(st.integers(0, 2**32), st.sampled_from([25, 30, 50, 60, 120]))
def test_every_frame_has_its_row_and_every_gap_its_lost_ones(seed, rate):
    rng = np.random.default_rng(seed)
    ns = stamps(rate, 400, 1_000_000)
    keep = rng.random(400) > 0.2
    keep[[0, -1]] = True
    raster = Raster.learnt(ns[keep], float(rate))
    values = np.arange(400.0)
    pieces = []
    for half in np.array_split(np.flatnonzero(keep), 3):  # a raster goes on from block to block
        placed, count = raster.place(ns[half], {"x": values[half]})
        pieces.append(placed)
        assert count == len(placed["time"])
    x, time, t_frame = (np.concatenate([p[name] for p in pieces]) for name in ("x", "time", "t_frame"))
    np.testing.assert_array_equal(x, np.where(keep, values, np.nan))
    np.testing.assert_allclose(time, np.arange(400) / rate, atol=1e-9)
    np.testing.assert_array_equal(t_frame, time)  # rounded stamps are put back
    assert (raster.frames, raster.lost) == (keep.sum(), 400 - keep.sum())
    assert raster.start == START


def test_repeated_and_older_frames_are_left_out_and_counted():
    ns = stamps(50, 10)[[0, 1, 1, 2, 3, 1, 2, 4, 5, 6, 7, 8, 9]]
    raster = Raster.learnt(ns, 50.0)
    placed, _ = raster.place(ns, {"x": np.arange(13.0)})
    assert (raster.frames, raster.repeated, raster.backward, raster.lost) == (10, 1, 2, 0)
    np.testing.assert_array_equal(placed["x"], [0, 1, 3, 4, 7, 8, 9, 10, 11, 12])  # the first of each


def test_a_float_of_seconds_since_1970_keeps_its_microseconds():
    microseconds = np.arange(0, 10**6, 997, dtype=np.int64)
    ns = times.from_numbers(START // SECOND + microseconds / 1e6, 1.0)
    np.testing.assert_array_equal(ns, START + 1000 * microseconds)
    assert times.from_numbers(np.array([1.000000017, np.nan]), 1.0).tolist() == [1_000_000_017, times.NOT_A_TIME]


def test_spread_stamps_are_kept_as_they_are():
    spread = np.random.default_rng(1).uniform(-0.3, 0.3, 500) / 50 * SECOND
    ns = stamps(50, 500) + spread.astype(np.int64)
    raster = Raster.learnt(ns, None)
    placed, _ = raster.place(ns, {})
    assert raster.rate == 50 and not raster.snap
    np.testing.assert_allclose(np.diff(placed["t_frame"]), np.diff(ns) / SECOND, atol=1e-9)
    np.testing.assert_allclose(np.diff(placed["time"]), 0.02, atol=1e-9)


def test_a_phase_of_its_own():
    """Frames half a period off the second: their raster is theirs."""
    ns = stamps(50, 100) + 10_000_000
    raster = Raster.learnt(ns, None)
    placed, _ = raster.place(ns, {})
    assert raster.start == START + 10_000_000 and raster.lost == 0 and raster.snap
    np.testing.assert_allclose(placed["t_frame"], np.arange(100) / 50, atol=1e-9)


def test_a_day_between_two_frames_is_refused():
    ns = stamps(50, 100)
    ns[60:] += 90_000 * SECOND
    raster = Raster.learnt(ns, None)
    with pytest.raises(RecordError, match=r"the times jump by 1\.0 days, to 2024-07-02"):
        raster.place(ns, {})


ISO = {
    b"2024-07-01T10:30:00Z": START,
    b"2024-07-01 10:30:00.123456789": START + 123_456_789,
    b"2024/07/01 10:30:00.1": START + 100_000_000,
    b"2024-07-01T10:30:00,25Z": START + 250_000_000,
    b"2024-07-01T12:30:00+02:00": START,
    b"2024-07-01T05:00:00.5-0530": START + 500_000_000,
    b" 2024-07-01  10:30:00 ": START,
    b"2024-07-01T10:30": START,
    b"not a time": times.NOT_A_TIME,
    b"": times.NOT_A_TIME,
    b"2024-07-01T10:30:61Z": times.NOT_A_TIME,
}


def test_iso_stamps():
    assert times.from_iso(np.array(list(ISO)), "UTC").tolist() == list(ISO.values())
    for text, ns in ISO.items():  # and each alone
        assert times.from_iso(np.array([text]), "UTC").tolist() == [ns], text


def test_local_time_through_the_change_of_the_clock():
    """Berlin, 2024-03-31: 01:59:59 is followed by 03:00:00."""
    local = np.array([b"2024-03-31 01:59:59", b"2024-03-31 03:00:00"])
    before, after = times.from_iso(local, "Europe/Berlin")
    assert after - before == SECOND


@given(st.integers(0, 2**33 * SECOND))
def test_utc_text_and_back(ns):
    assert times.from_iso(np.array([times.utc_text(ns).encode()]), "UTC")[0] == ns


def test_fracsec_quality_is_masked():
    soc, fracsec = np.array([1_719_829_800.0, np.nan]), np.array([float((0x0F << 24) + 750_000), 0.0])
    assert times.from_soc(soc, fracsec, 1_000_000).tolist() == [START + 750_000_000, times.NOT_A_TIME]
