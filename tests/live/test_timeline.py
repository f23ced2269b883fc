"""Time stamps to one continuous time."""

from itertools import accumulate

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenarios.live.c37118 import Stamp
from scenarios.live.timeline import LATE_IN_A_ROW, Timeline

from .frames import SOC

PENDING, OCCURRED, DELETED = 0x10, 0x20, 0x40


def stamp(k: int, rate: int = 60, time_base: int = 1_000_000, quality: int = 0, soc: int = SOC) -> Stamp:
    """Of frame k; FRACSEC rounded as a PMU rounds it."""
    seconds, rest = divmod(k, rate)
    return Stamp(soc + seconds, round(rest * time_base / rate), quality)


def timeline(rate: int = 60) -> Timeline:
    return Timeline(1_000_000, 1 / rate)


@given(st.sampled_from([1, 10, 25, 50, 60, 120]), st.integers(0, 59), st.lists(st.integers(1, 9), max_size=50))
def test_missing_frames_are_counted(rate, first, steps):
    line, order = timeline(rate), [*accumulate([first, *steps])]
    places = [line.place(stamp(k, rate)) for k in order]
    start = (order[0] % rate) / rate
    for place, k, before in zip(places, order, [order[0] - 1, *order], strict=False):
        assert place is not None
        assert place.t == pytest.approx(start + (k - order[0]) / rate, abs=1.1e-6)
        assert place.missing == k - before - 1
        assert place.anew == (k == order[0])


def test_repeated_and_late_frames_are_left_out():
    line = timeline()
    places = [line.place(stamp(k)) for k in (0, 1, 1, 3, 2, 4)]
    assert [place and place.missing for place in places] == [0, 0, None, 1, None, 0]


@pytest.mark.parametrize("rate", [10, 60])
def test_a_leap_second_is_no_step_back(rate):
    """UTC repeats a second, with the bit `pending` before it and `occurred` after; 3 s are 3 s."""
    line = timeline(rate)
    midnight = SOC + 1
    stamps = [stamp(k, rate, quality=PENDING) for k in range(rate)]
    stamps += [stamp(k, rate, quality=PENDING, soc=midnight - 1) for k in range(rate)]
    stamps += [stamp(k, rate, quality=OCCURRED, soc=midnight) for k in range(rate)]
    places = [line.place(one) for one in stamps]
    assert [place and round(place.t * rate, 3) for place in places] == list(range(3 * rate))
    assert all(place is not None and place.missing == 0 for place in places)


def test_a_deleted_second_is_no_gap():
    line = timeline()
    quality = PENDING | DELETED
    places = [line.place(stamp(k, quality=quality)) for k in range(30)]
    places += [line.place(stamp(k, quality=OCCURRED | DELETED)) for k in range(90, 120)]
    assert [place and round(place.t * 60, 3) for place in places] == list(range(60))
    assert all(place and not place.missing for place in places)


def test_a_late_frame_in_the_minute_of_a_leap_second_is_late():
    line = timeline()
    places = [line.place(stamp(k, quality=PENDING)) for k in (30, 31, 33, 32, 34)]
    assert [place is None for place in places] == [False, False, False, True, False]
    assert places[-1] is not None and places[-1].t == pytest.approx(34 / 60, abs=1e-6)


@pytest.mark.parametrize("hours", [-5, 5])
def test_a_clock_that_is_set_starts_anew(hours):
    """Forward at once, backward after a second of late frames; the time goes on, and says that it is not known."""
    line = timeline()
    for k in range(120):
        line.place(stamp(k))
    places = [line.place(stamp(k, soc=SOC + 3600 * hours)) for k in range(120)]
    late = places.count(None)
    assert late == (round(60 * LATE_IN_A_ROW) - 1 if hours < 0 else 0)
    first, *rest = [place for place in places if place]
    assert first.anew and first.missing == 0 and first.t == pytest.approx(2.0, abs=1e-5)
    assert not any(place.anew or place.missing for place in rest)
    assert rest[-1].t == pytest.approx(first.t + len(rest) / 60, abs=1e-5)


@given(st.lists(st.tuples(st.integers(0, 2**32 - 1), st.integers(0, 2**24 - 1), st.integers(0, 255)), max_size=50))
def test_time_only_goes_on(stamps):
    line, last = timeline(), -1.0
    for one in stamps:
        place = line.place(Stamp(*one))
        if place:
            assert place.t > last or place.anew
            assert place.missing >= 0
            last = place.t
