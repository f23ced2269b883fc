"""Independent judges of the codec: Wireshark's dissector reads what we write, and we read what pyc37 writes."""

import cmath
import re
import shutil
import struct
import subprocess
from pathlib import Path

import pytest

from scenarios.live import c37118
from scenarios.live.c37118 import CONFIG_1, CONFIG_2, CONFIG_3, Stamp

from .frames import FORMATS, SOC, configuration, data

PYC37 = Path(__file__).parent / "data" / "pyc37_frames.txt"
RAW_IP = 101
"""Link type of a capture file whose packets begin with their IP header."""

needs_tshark = pytest.mark.skipif(shutil.which("tshark") is None, reason="tshark is not installed (apt install tshark)")


def write_capture(path: Path, frames: list[bytes]) -> None:
    """A pcap file: every frame in a UDP datagram from 4713, the standard's port."""
    with path.open("wb") as file:
        file.write(struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 1 << 18, RAW_IP))
        for frame in frames:
            udp = struct.pack(">HHHH", 4713, 40_000, 8 + len(frame), 0) + frame
            ip = struct.pack(">BBHHHBBHII", 0x45, 0, 20 + len(udp), 0, 0, 64, 17, 0, 0x7F000001, 0x7F000001)
            file.write(struct.pack("<IIII", 0, 0, len(ip + udp), len(ip + udp)) + ip + udp)


def dissected(path: Path, frames: list[bytes]) -> list[str]:
    """What tshark says of each frame, as text."""
    write_capture(path, frames)
    run = subprocess.run(["tshark", "-r", path, "-V"], capture_output=True, text=True, timeout=60, check=True)
    return re.split(r"^Frame \d+: ", run.stdout, flags=re.M)[1:]


def numbers(pattern: str, text: str) -> list[float]:
    return [float(found) for found in re.findall(pattern, text)]


def complex_numbers(text: str) -> list[complex]:
    """ "alt 540.302+j841.471V": three decimals."""
    return [complex(float(re_), float(im)) for re_, im in re.findall(r"alt\s+(-?[\d.]+)\+j\s*(-?[\d.]+)[VA]", text)]


@needs_tshark
@pytest.mark.parametrize("kind", [CONFIG_1, CONFIG_2, CONFIG_3])
def test_wireshark_reads_the_same_values(kind, tmp_path):
    """All formats x three stations, in one capture: a configuration and a data frame each, with its own stream id.

    (Wireshark takes a data frame's layout from CFG-2 or CFG-3 only, so that CFG-1's data come with a CFG-2.)
    """
    frames, told = [], []
    for number, format_ in enumerate(FORMATS):
        c = configuration(kind, **format_)._replace(idcode=1000 + number)
        reader = c._replace(kind=CONFIG_2) if kind == CONFIG_1 else c
        d = data(c, number)
        d = d._replace(stamp=d.stamp._replace(quality=0x36))
        first = d.measurements[0]._replace(stat=0x2E95)
        d = d._replace(measurements=(first, *d.measurements[1:]))
        frames += [c37118.encode_configuration(c)] if kind == CONFIG_1 else []
        frames += [c37118.encode_configuration(reader), c37118.encode_data(d, c37118.layout(reader))]
        told.append((reader, d))
    texts = dissected(tmp_path / "frames.pcap", frames)
    assert len(texts) == len(frames)
    assert all("Checksum Status: Good" in text for text in texts)
    assert not any("Malformed" in text for text in texts)
    for (c, d), text in zip(told, [text for text in texts if "Data Frame" in text], strict=True):
        check_data(c, d, text)
    names = {CONFIG_1: "Configuration Frame 1", CONFIG_2: "Configuration Frame 2", CONFIG_3: "Configuration Frame 3"}
    of_kind = [text for text in texts if names[kind] in text]
    assert len(of_kind) == len(FORMATS)
    for (c, _), text in zip(told, of_kind, strict=True):
        check_configuration(c, text)


def check_data(c: c37118.Configuration, d: c37118.Data, text: str) -> None:
    """To the digits that tshark prints; its values are those that a 16-bit format can hold, as ours are."""
    layout = c37118.layout(c)
    ours = c37118.decode_data(c37118.encode_data(d, layout), layout)
    expected = [phasor for m in ours.measurements for phasor in m.phasors]
    theirs = complex_numbers(text)
    assert len(theirs) == len(expected) == 9
    for a, b in zip(theirs, expected, strict=True):
        assert abs(a - b) < 2e-3, (a, b)  # three decimals, and single precision of 15 kV
    frequencies = numbers(r"ctual frequency(?: value)?: ([\d.]+)", text)
    assert frequencies == pytest.approx([m.frequency for m in ours.measurements], abs=6e-4)
    assert numbers(r"Rate of change of frequency: (-?[\d.]+)", text) == pytest.approx(
        [m.rocof for m in ours.measurements], abs=6e-4
    )
    assert numbers(r'Analog value #\d: "[^"]*",\s*(-?[\d.]+)', text) == pytest.approx(
        [value for m in ours.measurements for value in m.analogs], abs=6e-4
    )
    digitals = re.findall(r"Digital status word #1: 0x([0-9a-f]{4})", text)
    assert [int(word, 16) for word in digitals] == [word for m in ours.measurements for word in m.digitals]
    assert f"Fraction of second (raw): {d.stamp.fraction}" in text
    # (not the direction of a leap second: 0 is "add" in Table 4 and in pyc37, and "Delete" in Wireshark 4.0)
    for line in (
        "Leap second occurred: True",
        "Leap second pending: True",
        "Clock unlocked, time within 10^-4 s",
        "Time synchronized: Synchronization lost",
        "Configuration changed: Within 1 minute",
        "Trigger detected: Trigger detected",
        "Data modified by a post-processing device",
        "Estimated maximum time error < 1 µs",
        "Unlocked for 10-100 s",
        "Trigger reason: df/dt high",
    ):
        assert line in text, line


def check_configuration(c: c37118.Configuration, text: str) -> None:
    assert re.findall(r'Station #\d: "([^"]*?) *"', text) == [s.name for s in c.stations]
    assert numbers(r"Resolution of fractional second time stamp: (\d+)", text) == [c.time_base]
    assert numbers(r"PMU/DC ID number \(Data source ID\): (\d+)", text) == [s.idcode for s in c.stations]
    assert numbers(r"Nominal line frequency: (\d+)", text) == [s.nominal_frequency for s in c.stations]
    assert numbers(r"Configuration change count: (\d+)", text) == [s.changes for s in c.stations]
    formats = re.findall(r"Phasor notation: (polar|rectangular)", text)
    assert formats == ["polar" if s.polar else "rectangular" for s in c.stations]
    assert numbers(r"Rate of transmission: (\d+)", text) == [c.rate]
    assert len(re.findall(r'label #16: "BREAKER 15', text)) == len(c.stations)


@needs_tshark
def test_wireshark_reads_commands_and_headers(tmp_path):
    stamp = Stamp(SOC, 1)
    commands = [c37118.encode_command(5, stamp, command) for command in c37118.Command]
    texts = dissected(tmp_path / "frames.pcap", [*commands, c37118.encode_header(5, stamp, "Station Bus 30")])
    assert all("Checksum Status: Good" in text for text in texts)
    for text, words in zip(
        texts,
        (
            "data transmission off",
            "data transmission on",
            "send HDR frame",
            "send CFG-1 frame",
            "send CFG-2 frame",
            "send CFG-3",
            "extended frame",
            b"Station Bus 30".hex(),
        ),
        strict=True,
    ):
        assert words in text


def pyc37() -> list[bytes]:
    return [bytes.fromhex(line) for line in PYC37.read_text().splitlines() if not line.startswith("#")]


def test_annex_d_example_of_another_implementation():
    """The 2005 edition's example of a PMU at Station A: integers, rectangular."""
    configuration_frame, data_frame, *_ = pyc37()
    c = c37118.decode_configuration(configuration_frame)
    d = c37118.decode_data(data_frame, c37118.layout(c))
    (s,), (m,) = c.stations, d.measurements
    assert (c.idcode, c.rate, c.time_base, s.name, s.nominal_frequency, s.changes) == (
        7734,
        30,
        10**6,
        "Station A",
        60,
        22,
    )
    assert [p.is_current for p in s.phasors] == [False, False, False, True]
    assert s.digitals[0].names[9] == "BREAKER A STATUS"
    raw = [14635, complex(-7318, -12676), complex(-7318, 12675), 1092]
    scale = [9.15527, 9.15527, 9.15527, 0.45776]
    assert m.phasors == pytest.approx([a * b for a, b in zip(raw, scale, strict=True)])
    assert (m.frequency, m.rocof, m.analogs, m.digitals) == (62.5, 0.0, (100.0, 1000.0, 10000.0), (0x3C12,))
    assert abs(m.phasors[0]) == pytest.approx(134e3, rel=1e-3)  # 134.0 kV
    assert d.stamp == Stamp(1149580800, 16817)


def test_two_stations_of_another_implementation():
    _, _, configuration_frame, data_frame, command, header = pyc37()
    c = c37118.decode_configuration(configuration_frame)
    d = c37118.decode_data(data_frame, c37118.layout(c))
    assert [s.name for s in c.stations] == ["Bus 1", "Bus 2"] and c.time_base == 16_777_215
    assert [s.nominal_frequency for s in c.stations] == [50, 60]
    first, second = d.measurements
    assert first.phasors == pytest.approx([cmath.rect(13000.5, 0.75), cmath.rect(800.25, -3.0)], rel=1e-6)
    assert second.phasors == (complex(-12.5, 99.25),)
    assert (first.frequency, first.rocof, first.analogs, first.digitals) == (49.98, -0.5, (1.5,), (0x0F0F,))
    assert (second.frequency, second.rocof, second.analogs, second.digitals) == (60.02, 0.25, (-2.0,), (1,))
    assert c37118.decode_command(command)[0::2] == (7734, 2)
    assert c37118.decode_header(header)[2] == "Hello I'm Header Frame."
