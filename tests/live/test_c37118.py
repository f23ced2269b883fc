"""The codec by itself: both ways round, the standard's tables, and what is refused."""

from dataclasses import dataclass
from math import inf, isnan, nan, pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenarios.live import c37118
from scenarios.live.c37118 import CONFIG_1, CONFIG_2, CONFIG_3, FrameError, Stamp, Stat

from .frames import FORMATS, configuration, data


@dataclass
class Resolution:
    """Half a step of the format, of a value of that size."""

    phasor: float
    frequency: float
    rocof: float
    analog: float


def resolution(s: c37118.Station) -> Resolution:
    single = 2.0**-24
    largest = 15_000.0
    coarsest = max(p.scale for p in s.phasors)
    integer = coarsest / 2 + 0.5e-4 * largest if s.polar else coarsest / 2 * 2**0.5
    analog = max(abs(a.scale) for a in s.analogs) / 2
    return Resolution(
        2 * single * largest if s.phasors_float else integer,
        60 * single if s.frequency_float else 0.5e-3,
        single if s.frequency_float else 0.5e-2,
        200 * single if s.analogs_float else analog,
    )


@pytest.mark.parametrize("kind", [CONFIG_1, CONFIG_2, CONFIG_3])
@pytest.mark.parametrize("format_", FORMATS)
def test_both_ways_round(kind, format_):
    told = configuration(kind, **format_)
    found = c37118.decode_configuration(c37118.encode_configuration(told))
    if kind != CONFIG_3:
        assert found == told
    layout = c37118.layout(found)
    sent = data(told, 7)
    frame = c37118.encode_data(sent, layout)
    received = c37118.decode_data(frame, layout)
    assert (received.idcode, received.stamp) == (sent.idcode, sent.stamp)
    for s, a, b in zip(told.stations, sent.measurements, received.measurements, strict=True):
        step = resolution(s)
        assert (a.stat, a.digitals) == (b.stat, b.digitals)
        assert np.abs(np.subtract(a.phasors, b.phasors)).max() <= 1.001 * step.phasor
        assert abs(a.frequency - b.frequency) <= 1.001 * step.frequency
        assert abs(a.rocof - b.rocof) <= 1.001 * step.rocof
        assert np.abs(np.subtract(a.analogs, b.analogs)).max() <= 1.001 * step.analog
    # what was received is what the format can hold: sent again it is the same frame
    again = c37118.encode_data(received, layout)
    assert again == frame or format_["polar"] or format_["phasors"] or kind == CONFIG_3  # cos and sin round


def test_cfg_3_has_what_single_precision_holds():
    told = configuration(CONFIG_3, phasors=False)
    found = c37118.decode_configuration(c37118.encode_configuration(told))
    assert found.stations[0].phasors[0].component == 4
    assert found.stations[0].phasors[0].angle_offset == pytest.approx(0.1, rel=1e-7)
    assert found.stations[0].latitude == inf
    assert found._replace(stations=()) == told._replace(stations=())


def test_cfg_3_in_parts():
    frame = c37118.encode_configuration(configuration(CONFIG_3))
    _, _, idcode, stamp, body = c37118.opened(frame, CONFIG_3)
    body = body[2:]
    cuts = [body[:50], body[50:111], body[111:]]
    parts = [
        c37118.framed(CONFIG_3, idcode, stamp, index.to_bytes(2) + cut)
        for index, cut in zip((1, 2, 0xFFFF), cuts, strict=True)
    ]
    assert c37118.decode_configuration(*parts) == c37118.decode_configuration(frame)
    assert [c37118.continuation(part) for part in parts] == [1, 2, 0xFFFF]
    with pytest.raises(FrameError, match=r"parts \[1, 2\] of a CFG-3: some are missing"):
        c37118.decode_configuration(parts[0], parts[1])


def test_a_frame_by_hand():
    """Table 15's command to turn transmission on, put together from the standard; CRC-CCITT of "123456789" is 29B1."""
    from binascii import crc_hqx

    assert crc_hqx(b"123456789", 0xFFFF) == 0x29B1
    frame = c37118.encode_command(7734, Stamp(0x44853600, 0x56071, 0x0F), c37118.Command.DATA_ON, edition=1)
    body = bytes.fromhex("AA41 0012 1E36 44853600 0F056071 0002".replace(" ", ""))
    assert frame == body + crc_hqx(body, 0xFFFF).to_bytes(2)
    assert c37118.decode_command(frame) == (7734, Stamp(0x44853600, 0x56071, 0x0F), 2, b"")


def test_header_and_extended_command():
    stamp = Stamp(1, 2, 3)
    assert c37118.decode_header(c37118.encode_header(9, stamp, "Bus 30, first floor")) == (
        9,
        stamp,
        "Bus 30, first floor",
    )
    frame = c37118.encode_command(9, stamp, c37118.Command.EXTENDED, b"hello!")
    assert c37118.decode_command(frame) == (9, stamp, 8, b"hello!")


def test_time_quality():
    assert Stamp(0, 0, 0x00).time_error == 0
    assert Stamp(0, 0, 0x07).time_error == pytest.approx(1e-3)  # Table 4: within 10^-3 s
    assert Stamp(0, 0, 0x0B).time_error == pytest.approx(10.0)
    assert Stamp(0, 0, 0x0F).time_error == inf
    assert Stamp(0, 0, 0x10).leap_second_near and Stamp(0, 0, 0x20).leap_second_near
    assert not Stamp(0, 0, 0x4F).leap_second_near and Stamp(0, 0, 0x40).leap_second_deleted
    assert c37118.pmu_time_error(0b101 << 6) == pytest.approx(1e-3)  # Table 7: below 1 ms
    assert c37118.pmu_time_error(0b001 << 6) == pytest.approx(1e-7)
    assert c37118.pmu_time_error(0b111 << 6) == inf
    assert c37118.pmu_time_error(0) == 0
    assert Stat(0xC000) == Stat.DATA_INVALID | Stat.PMU_ERROR


def test_the_fraction_has_24_bits():
    """0.75 s with openPDC's TIME_BASE."""
    told = configuration()
    layout = c37118.layout(told)
    late = data(told)._replace(stamp=Stamp(1, 12_582_911, 0xFF))
    assert c37118.decode_data(c37118.encode_data(late, layout), layout).stamp == late.stamp


@pytest.mark.parametrize("polar", [False, True])
def test_absent_values(polar):
    """NaN, and what 16 bits cannot hold, is 8000 hex and comes back as NaN; no value is clipped."""
    told = configuration(polar=polar, phasors=False, frequency=False, analogs=False)
    layout = c37118.layout(told)
    sent = data(told)
    bad = sent.measurements[0]._replace(
        phasors=(complex(nan, 0), complex(1e6, 0), complex(0, 1.0)), frequency=nan, rocof=1e9, analogs=(nan, 1e9)
    )
    frame = c37118.encode_data(sent._replace(measurements=(bad, *sent.measurements[1:])), layout)
    found = c37118.decode_data(frame, layout).measurements[0]
    assert [isnan(abs(value)) for value in found.phasors] == [True, True, False]
    assert isnan(found.frequency) and isnan(found.rocof) and all(map(isnan, found.analogs))


@given(st.lists(st.floats(width=32), min_size=4, max_size=4), st.booleans())
def test_any_float_on_the_wire_is_read(values, polar):
    """Infinite and not-a-number phasors come out as NaN, and nothing raises."""
    told = c37118.Configuration(1, (c37118.Station("A", 1, (c37118.Phasor("V"), c37118.Phasor("I")), polar=polar),), 50)
    layout = c37118.layout(told)
    frame = bytearray(c37118.encode_data(c37118.Data(1, Stamp(0), (c37118.Measurement(0, (1, 1), 50.0, 0.0),)), layout))
    frame[16:32] = b"".join(np.float32(value).tobytes()[::-1] for value in values)
    frame[-2:] = c37118.crc_hqx(bytes(frame[:-2]), 0xFFFF).to_bytes(2)
    found = c37118.decode_data(bytes(frame), layout).measurements[0].phasors
    finite = [np.isfinite(values[k : k + 2]).all() for k in (0, 2)]
    assert [not isnan(phasor.real) for phasor in found] == finite


def test_angles_are_in_1e_4_rad():
    """6.3.1: a polar integer angle has 1e-4 rad a bit, whatever PHUNIT is."""
    told = configuration(polar=True, phasors=False)
    layout = c37118.layout(told)
    frame = c37118.encode_data(data(told), layout)
    raw = layout.whole.unpack(frame)[layout.slices[0]]
    assert raw[1] == round(12_000 / 1.5) and raw[2] == 5000
    assert raw[4] == round(-2.0 * 1e4) and abs(raw[6]) <= round(pi * 1e4)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: c37118.decode_command(b"\xaa\x41\x00\x12"),
            "not a frame of C37.118: 4 bytes that start with aa410012",
        ),
        (lambda: c37118.decode_header(c37118.encode_command(1, Stamp(0), 2)), "a frame of type 4 where 1 was expected"),
        (lambda: c37118.encode_command(70_000, Stamp(0), 2), "does not fit its field"),
        (lambda: c37118.encode_header(1, Stamp(0), "x" * 70_000), "too large; FRAMESIZE counts to 65535"),
        (lambda: c37118.decode_data(bytes(20), c37118.layout(configuration())), "where the configuration has"),
        (
            lambda: c37118.encode_configuration(
                c37118.Configuration(1, (c37118.Station("A", 1, (c37118.Phasor("V", scale=200.0),)),), 50)
            ),
            "the configuration does not fit",
        ),
        (lambda: c37118.encode_configuration(configuration()._replace(rate=40_000)), "the configuration does not fit"),
    ],
)
def test_what_is_refused(call, message):
    with pytest.raises(FrameError, match=message):
        call()


@given(st.binary(min_size=0, max_size=200), st.sampled_from([CONFIG_1, CONFIG_2, CONFIG_3, c37118.COMMAND]))
def test_any_body_is_read_or_refused(body, kind):
    """A frame with a right CHK around anything: FrameError, or a value; nothing else."""
    frame = c37118.framed(kind, 1, Stamp(0), body)
    try:
        if kind == c37118.COMMAND:
            c37118.decode_command(frame)
        else:
            c37118.decode_configuration(frame)
    except FrameError:
        pass


@given(st.data())
def test_any_cut_configuration_is_refused(draw):
    kind = draw.draw(st.sampled_from([CONFIG_2, CONFIG_3]))
    _, _, idcode, stamp, body = c37118.opened(c37118.encode_configuration(configuration(kind)), kind)
    cut = draw.draw(st.integers(2, len(body) - 1))
    with pytest.raises(FrameError):
        c37118.decode_configuration(c37118.framed(kind, idcode, stamp, body[:cut]))
