"""IEEE C37.118.2-2011 (and -2005): frames of synchrophasors as bytes and as named tuples, both ways.

    SYNC  FRAMESIZE  IDCODE  SOC  FRACSEC  ...  CHK      every frame; big-endian; CHK is CRC-CCITT over all before it

SYNC is AA hex, then the frame's type in bits 6-4 and the version (1: 2005, 2: 2011) in bits 3-0 (Table 2). There is no
input or output here and nothing is remembered: a data frame is read with the `Layout` that its configuration gives.

Values are in V, A, Hz, Hz/s and rad, at the terminals that the configuration names. What is absent (NaN; 8000 hex in
16-bit formats) is NaN. Raises FrameError for what is no frame, and for what cannot be one.
"""

import cmath
from binascii import crc_hqx
from enum import IntEnum, IntFlag
from math import inf, isfinite, nan
from struct import Struct, error
from typing import NamedTuple

DATA, HEADER, CONFIG_1, CONFIG_2, COMMAND, CONFIG_3 = 0, 1, 2, 3, 4, 5
"""Frame types (Table 2)."""

EDITION_2005, EDITION_2011 = 1, 2

COMMON = Struct(">BBHHII")
SMALLEST = COMMON.size + 2
LARGEST = 65535
ABSENT = -0x8000
"""Of a 16-bit integer: no value (6.3.1)."""


class FrameError(ValueError):
    """Bytes that are no frame, or values that no frame can hold."""


class Stamp(NamedTuple):
    """SOC and FRACSEC (Tables 3 and 4): the time of measurement is soc + fraction/TIME_BASE."""

    soc: int
    """s since 1970-01-01 UTC, leap seconds not counted: the second after 23:59:59 may repeat one."""
    fraction: int = 0
    """Of 1/TIME_BASE s, 24 bits."""
    quality: int = 0
    """Leap second: bit 6 it is deleted, not added; bit 5 it occurred in the last 24 h; bit 4 it comes within a minute.
    Bits 3-0: the clock is locked (0), within 10^(k - 10) s of UTC (k = 1 to 11), or has failed (15)."""

    @property
    def time_error(self) -> float:
        """s, the largest error of the clock: 0 if it is locked, inf if it has failed."""
        code = self.quality & 0xF
        return 0.0 if code == 0 else 10.0 ** (code - 10) if code <= 11 else inf

    @property
    def leap_second_near(self) -> bool:
        return bool(self.quality & 0x30)

    @property
    def leap_second_deleted(self) -> bool:
        return bool(self.quality & 0x40)


class Stat(IntFlag):
    """STAT, of each station in a data frame (Table 7). Bits 8-6, PMU_TQ: see `pmu_time_error`."""

    DATA_INVALID = 0x8000  # bits 15-14: 1 error at the PMU, no data; 2 test mode; 3 error, do not use
    PMU_ERROR = 0x4000
    NOT_SYNCHRONIZED = 0x2000
    SORTED_BY_ARRIVAL = 0x1000
    TRIGGER = 0x0800
    CONFIGURATION_CHANGE = 0x0400  # within a minute; falls when it has happened
    MODIFIED = 0x0200  # estimated or corrected by a process after the PMU
    # bits 5-4: unlocked for less than 10, 100, 1000 s, or longer;  bits 3-0: reason of the trigger


def pmu_time_error(stat: int) -> float:
    """s, the largest error of time according to PMU_TQ (Table 7, bits 8-6); 0 where the field is not used."""
    code = stat >> 6 & 7
    return 0.0 if code == 0 else inf if code == 7 else 10.0 ** (code - 8)


class Command(IntEnum):
    """CMD (Table 15)."""

    DATA_OFF = 1
    DATA_ON = 2
    SEND_HEADER = 3
    SEND_CONFIG_1 = 4
    SEND_CONFIG_2 = 5
    SEND_CONFIG_3 = 6
    EXTENDED = 8


class Phasor(NamedTuple):
    """A phasor channel: PHUNIT of CFG-1 and CFG-2 (Table 9), PHSCALE of CFG-3 (Table 11)."""

    name: str
    is_current: bool = False
    scale: float = 1.0
    """V or A of one bit; in CFG-3 a factor of the floating-point format as well."""
    angle_offset: float = 0.0
    """rad, to be subtracted (CFG-3 only)."""
    component: int = 1
    """0, 1, 2: zero, positive, negative sequence; 4, 5, 6: phase a, b, c (CFG-3 only)."""
    modifications: int = 0
    """Flags of what was done to it on its way, and in the lowest byte the user's (CFG-3 only)."""


class Analog(NamedTuple):
    """An analog channel: ANUNIT of CFG-1 and CFG-2, which leaves scaling to the user; ANSCALE of CFG-3: M x + B."""

    name: str
    kind: int = 0
    """0 point on wave, 1 rms, 2 peak, 65-255 the user's (CFG-1 and CFG-2 only)."""
    scale: float = 1.0
    """CFG-3: M. CFG-1 and CFG-2: a signed integer of 24 bits that is not applied."""
    offset: float = 0.0
    """B (CFG-3 only)."""


class Digital(NamedTuple):
    """A word of 16 digital channels with DIGUNIT's masks."""

    names: tuple[str, ...]
    normal: int = 0
    valid: int = 0xFFFF


class Station(NamedTuple):
    """A PMU in a configuration: its channels, and how its data are formatted (FORMAT)."""

    name: str
    idcode: int
    phasors: tuple[Phasor, ...] = ()
    analogs: tuple[Analog, ...] = ()
    digitals: tuple[Digital, ...] = ()
    polar: bool = False
    phasors_float: bool = True
    analogs_float: bool = True
    frequency_float: bool = True
    nominal_frequency: int = 60
    """Hz: 50 or 60."""
    changes: int = 0
    """CFGCNT."""
    # of CFG-3 alone
    global_id: bytes = bytes(16)
    latitude: float = inf
    """deg, like the longitude; inf: not specified."""
    longitude: float = inf
    elevation: float = inf
    """m."""
    service_class: str = "M"
    window: int = -1
    """us, of measurement; -1: not specified."""
    group_delay: int = -1
    """us."""


class Configuration(NamedTuple):
    """CFG-1, CFG-2 or CFG-3."""

    idcode: int
    stations: tuple[Station, ...]
    rate: int
    """DATA_RATE: frames a second or, if negative, seconds a frame."""
    time_base: int = 1_000_000
    kind: int = CONFIG_2
    stamp: Stamp = Stamp(0)
    edition: int = EDITION_2011

    @property
    def period(self) -> float:
        """s, from frame to frame."""
        return 1 / self.rate if self.rate > 0 else float(-self.rate)


class Measurement(NamedTuple):
    """What one station reports in a data frame."""

    stat: int
    phasors: tuple[complex, ...]
    """V and A."""
    frequency: float
    """Hz."""
    rocof: float
    """Hz/s."""
    analogs: tuple[float, ...] = ()
    digitals: tuple[int, ...] = ()


class Data(NamedTuple):
    """A data frame: one measurement a station, in the configuration's order."""

    idcode: int
    stamp: Stamp
    measurements: tuple[Measurement, ...]


class Layout(NamedTuple):
    """How the data frames of a configuration lie in bytes; made by `layout`, once a configuration."""

    configuration: Configuration
    whole: Struct
    slices: tuple[slice, ...]
    """Of the unpacked values, one a station."""


# --- every frame ------------------------------------------------------------------------------------------------------


def frame_type(frame: bytes) -> int:
    return frame[1] >> 4 & 7


def size_announced(start: bytes | bytearray) -> int:
    """FRAMESIZE of a frame that starts so (4 bytes)."""
    return start[2] << 8 | start[3]


def is_start(start: bytes | bytearray) -> bool:
    """Can a frame start with these bytes (4 of them): SYNC with a known type and edition, and a size?"""
    return start[0] == 0xAA and start[1] in SECOND_BYTES and size_announced(start) >= SMALLEST


SECOND_BYTES = frozenset(type_ << 4 | edition for type_ in range(6) for edition in (EDITION_2005, EDITION_2011))


def is_intact(frame: bytes) -> bool:
    """Does a whole frame end with the right CHK?"""
    return crc_hqx(frame[:-2], 0xFFFF) == frame[-2] << 8 | frame[-1]


def framed(type_: int, idcode: int, stamp: Stamp, body: bytes, edition: int = EDITION_2011) -> bytes:
    size = COMMON.size + len(body) + 2
    if size > LARGEST:
        raise FrameError(f"a frame of {size} bytes is too large; FRAMESIZE counts to {LARGEST}")
    try:
        fraction_word = stamp.quality << 24 | stamp.fraction
        start = COMMON.pack(0xAA, type_ << 4 | edition, size, idcode, stamp.soc, fraction_word) + body
    except error as wrong:
        raise FrameError(f"idcode {idcode} or {stamp} does not fit its field: {wrong}") from None
    return start + crc_hqx(start, 0xFFFF).to_bytes(2)


def opened(frame: bytes, *types: int) -> tuple[int, int, int, Stamp, bytes]:
    """Type, edition, idcode, stamp and body of a whole frame."""
    if len(frame) < SMALLEST or not is_start(frame) or size_announced(frame) != len(frame):
        raise FrameError(f"not a frame of C37.118: {len(frame)} bytes that start with {frame[:4].hex()}")
    if not is_intact(frame):
        raise FrameError("CHK does not match the frame")
    _, second, _, idcode, soc, fraction = COMMON.unpack_from(frame)
    if second >> 4 not in types:
        raise FrameError(f"a frame of type {second >> 4} where {' or '.join(map(str, types))} was expected")
    stamp = Stamp(soc, fraction & 0xFFFFFF, fraction >> 24)
    return second >> 4, second & 0xF, idcode, stamp, frame[COMMON.size : -2]


# --- header and command -----------------------------------------------------------------------------------------------


def encode_header(idcode: int, stamp: Stamp, text: str) -> bytes:
    """Header frame: text about the PMU for people (6.5)."""
    return framed(HEADER, idcode, stamp, text.encode())


def decode_header(frame: bytes) -> tuple[int, Stamp, str]:
    """Of a header frame: idcode, time, text."""
    _, _, idcode, stamp, body = opened(frame, HEADER)
    return idcode, stamp, body.decode("utf-8", "replace")


def encode_command(
    idcode: int, stamp: Stamp, command: int, extension: bytes = b"", edition: int = EDITION_2011
) -> bytes:
    """Command frame for the stream `idcode` (6.6); an extension is the user's own."""
    return framed(COMMAND, idcode, stamp, int(command).to_bytes(2) + extension, edition)


def decode_command(frame: bytes) -> tuple[int, Stamp, int, bytes]:
    """Of a command frame: idcode, time, command, extension."""
    _, _, idcode, stamp, body = opened(frame, COMMAND)
    if len(body) < 2:
        raise FrameError("a command frame without a command")
    return idcode, stamp, int.from_bytes(body[:2]), body[2:]


# --- configuration ----------------------------------------------------------------------------------------------------

STATION = Struct(">HHHHH")  # IDCODE, FORMAT, PHNMR, ANNMR, DGNMR
PHSCALE = Struct(">HBBff")
ANSCALE = Struct(">ff")
DIGUNIT = Struct(">HH")
PLACE = Struct(">fffcii")  # PMU_LAT, PMU_LON, PMU_ELEV, SVC_CLASS, WINDOW, GRP_DLY


def encode_configuration(configuration: Configuration) -> bytes:
    """CFG-1, CFG-2 (6.4.1, Table 8) or CFG-3 (6.4.2, Table 10), as `kind` says. One frame: CONT_IDX is 0."""
    third = configuration.kind == CONFIG_3
    body = bytes(2) if third else b""
    try:
        body += Struct(">IH").pack(configuration.time_base, len(configuration.stations))
        body += b"".join(encode_station(station, third) for station in configuration.stations)
        body += configuration.rate.to_bytes(2, signed=True)
    except (error, OverflowError) as wrong:
        raise FrameError(f"the configuration does not fit: {wrong}") from None
    return framed(configuration.kind, configuration.idcode, configuration.stamp, body, configuration.edition)


def encode_station(s: Station, third: bool) -> bytes:
    def named(name: str) -> bytes:
        text = name.encode("utf-8" if third else "ascii", "replace")
        return bytes([len(text[:255])]) + text[:255] if third else text[:16].ljust(16)

    names = [channel.name for channel in (*s.phasors, *s.analogs)]
    names += [name for digital in s.digitals for name in (*digital.names, *[""] * 16)[:16]]
    format_ = s.polar | s.phasors_float << 1 | s.analogs_float << 2 | s.frequency_float << 3
    counts = STATION.pack(s.idcode, format_, len(s.phasors), len(s.analogs), len(s.digitals))
    parts = [named(s.name), counts[:2], s.global_id if third else b"", counts[2:], *map(named, names)]
    for phasor in s.phasors:
        flags = phasor.modifications
        parts.append(
            PHSCALE.pack(
                flags >> 8, phasor.is_current << 3 | phasor.component, flags & 0xFF, phasor.scale, phasor.angle_offset
            )
            if third
            else bytes([phasor.is_current]) + round(phasor.scale * 1e5).to_bytes(3)
        )
    for analog in s.analogs:
        whole = round(analog.scale)
        parts.append(
            ANSCALE.pack(analog.scale, analog.offset)
            if third
            else bytes([analog.kind]) + whole.to_bytes(3, signed=True)
        )
    parts += [DIGUNIT.pack(digital.normal, digital.valid) for digital in s.digitals]
    if third:
        service = s.service_class.encode("ascii", "replace")
        parts.append(PLACE.pack(s.latitude, s.longitude, s.elevation, service, s.window, s.group_delay))
    parts.append(Struct(">HH").pack(s.nominal_frequency == 50, s.changes))
    return b"".join(parts)


class Reader:
    """Takes one field after the other from a body."""

    def __init__(self, body: bytes):
        self.body, self.place = body, 0

    def take(self, size: int) -> bytes:
        taken = self.body[self.place : self.place + size]
        if len(taken) < size:
            raise FrameError("the frame ends within a field")
        self.place += size
        return taken

    def unpack(self, struct: Struct) -> tuple:
        return struct.unpack(self.take(struct.size))

    def word(self) -> int:
        return int.from_bytes(self.take(2))


def continuation(frame: bytes) -> int:
    """CONT_IDX of a CFG-3: 0 it is whole, else one of several frames: 1, 2, ..., and FFFF hex for the last."""
    return int.from_bytes(opened(frame, CONFIG_3)[-1][:2])


def decode_configuration(*frames: bytes) -> Configuration:
    """CFG-1, CFG-2 or CFG-3, which may be spread over several frames: all of them, in their order (CONT_IDX)."""
    opened_frames = [opened(frame, CONFIG_1, CONFIG_2, CONFIG_3) for frame in frames]
    kind, edition, idcode, stamp, body = opened_frames[0]
    third = kind == CONFIG_3
    if third:
        indices = [continuation(frame) for frame in frames]
        if indices not in ([0], [*range(1, len(frames)), 0xFFFF]):
            raise FrameError(f"parts {indices} of a CFG-3: some are missing")
        body = b"".join(one[-1][2:] for one in opened_frames)
    reader = Reader(body)
    time_base = int.from_bytes(reader.take(4)) & 0xFFFFFF
    stations = tuple(decode_station(reader, third) for _ in range(reader.word()))
    rate = int.from_bytes(reader.take(2), signed=True)
    if reader.place != len(body):
        raise FrameError(f"{len(body) - reader.place} bytes too many after the last station")
    if time_base == 0 or rate == 0:
        raise FrameError(f"TIME_BASE = {time_base} and DATA_RATE = {rate}: neither may be 0")
    return Configuration(idcode, stations, rate, time_base, kind, stamp, edition)


def decode_station(reader: Reader, third: bool) -> Station:
    def name() -> str:
        text = reader.take(reader.take(1)[0] if third else 16)
        return text.decode("utf-8" if third else "latin-1", "replace").rstrip(" \0")

    station, idcode = name(), reader.word()
    global_id = reader.take(16) if third else bytes(16)
    format_, phasors, analogs, digitals = (reader.word() for _ in range(4))
    phasor_names, analog_names = [name() for _ in range(phasors)], [name() for _ in range(analogs)]
    digital_names = [tuple(name() for _ in range(16)) for _ in range(digitals)]
    take_phasor, take_analog = (phscale, anscale) if third else (phunit, anunit)
    phasor = tuple(take_phasor(reader, name) for name in phasor_names)
    analog = tuple(take_analog(reader, name) for name in analog_names)
    digital = tuple(Digital(names, *reader.unpack(DIGUNIT)) for names in digital_names)
    place = {}
    if third:
        latitude, longitude, elevation, service, window, delay = reader.unpack(PLACE)
        place = {
            "global_id": global_id,
            "latitude": latitude,
            "longitude": longitude,
            "elevation": elevation,
            "service_class": service.decode("latin-1"),
            "window": window,
            "group_delay": delay,
        }
    nominal = 50 if reader.word() & 1 else 60
    return Station(
        station,
        idcode,
        phasor,
        analog,
        digital,
        polar=bool(format_ & 1),
        phasors_float=bool(format_ & 2),
        analogs_float=bool(format_ & 4),
        frequency_float=bool(format_ & 8),
        nominal_frequency=nominal,
        changes=reader.word(),
        **place,
    )


def phunit(reader: Reader, name: str) -> Phasor:
    word = int.from_bytes(reader.take(4))
    return Phasor(name, word >> 24 == 1, (word & 0xFFFFFF) / 1e5)


def phscale(reader: Reader, name: str) -> Phasor:
    flags, kind, user, scale, offset = reader.unpack(PHSCALE)
    return Phasor(name, bool(kind & 8), scale, offset, kind & 7, flags << 8 | user)


def anunit(reader: Reader, name: str) -> Analog:
    word = reader.take(4)
    return Analog(name, word[0], float(int.from_bytes(word[1:], signed=True)))


def anscale(reader: Reader, name: str) -> Analog:
    scale, offset = reader.unpack(ANSCALE)
    return Analog(name, 0, scale, offset)


# --- data -------------------------------------------------------------------------------------------------------------


def layout(configuration: Configuration) -> Layout:
    """How data frames lie (6.3, Tables 5 and 6): per station STAT, phasors, FREQ, DFREQ, analogs, digitals."""
    codes, slices, place = [], [], len("BBHHII")
    for s in configuration.stations:
        phasor = "ff" if s.phasors_float else "Hh" if s.polar else "hh"
        code = "H" + phasor * len(s.phasors) + ("ff" if s.frequency_float else "hh")
        code += ("f" if s.analogs_float else "h") * len(s.analogs) + "H" * len(s.digitals)
        codes.append(code)
        slices.append(slice(place, place + len(code)))
        place += len(code)
    return Layout(configuration, Struct(">BBHHII" + "".join(codes) + "H"), tuple(slices))


def decode_data(frame: bytes, layout: Layout) -> Data:
    """A data frame of that layout."""
    if len(frame) != layout.whole.size:
        raise FrameError(f"a data frame of {len(frame)} bytes where the configuration has {layout.whole.size}")
    if frame[0] != 0xAA or frame_type(frame) != DATA or not is_intact(frame):
        raise FrameError("not a data frame, or CHK does not match it")
    values = layout.whole.unpack(frame)
    stamp = Stamp(values[4], values[5] & 0xFFFFFF, values[5] >> 24)
    third = layout.configuration.kind == CONFIG_3
    stations = zip(layout.configuration.stations, layout.slices, strict=True)
    return Data(values[3], stamp, tuple(measurement(s, values[part], third) for s, part in stations))


def measurement(s: Station, values: tuple, third: bool) -> Measurement:
    after = 1 + 2 * len(s.phasors)
    end = after + 2 + len(s.analogs)
    phasors = tuple(
        to_complex(s, phasor, values[k], values[k + 1], third)
        for phasor, k in zip(s.phasors, range(1, after, 2), strict=True)
    )
    frequency, rocof = values[after], values[after + 1]
    if not s.frequency_float:
        frequency = nan if frequency == ABSENT else s.nominal_frequency + frequency / 1000
        rocof = nan if rocof == ABSENT else rocof / 100
    analogs = values[after + 2 : end]
    if s.analogs and not s.analogs_float:
        analogs = tuple(nan if value == ABSENT else float(value) for value in analogs)
    if third:
        analogs = tuple(a.scale * value + a.offset for a, value in zip(s.analogs, analogs, strict=True))
    return Measurement(values[0], phasors, frequency, rocof, analogs, values[end:])


def to_complex(s: Station, phasor: Phasor, first, second, third: bool) -> complex:
    """Rectangular: real and imaginary part. Polar: magnitude, and angle in rad or, as an integer, in 1e-4 rad."""
    if s.phasors_float:
        if not (isfinite(first) and isfinite(second)):
            return complex(nan, nan)
        value = cmath.rect(first, second) if s.polar else complex(first, second)
        if not third:
            return value
    elif second == ABSENT or (first == ABSENT and not s.polar):
        return complex(nan, nan)
    else:
        value = cmath.rect(first, second * 1e-4) if s.polar else complex(first, second)
    value *= phasor.scale
    return value * cmath.rect(1.0, -phasor.angle_offset) if phasor.angle_offset else value


def encode_data(data: Data, layout: Layout) -> bytes:
    """A data frame. What does not fit its 16 bits is marked as absent, rather than clipped to another value."""
    configuration, stamp = layout.configuration, data.stamp
    third = configuration.kind == CONFIG_3
    second, size = DATA << 4 | configuration.edition, layout.whole.size
    values = [0xAA, second, size, data.idcode, stamp.soc, stamp.quality << 24 | stamp.fraction]
    try:
        for s, m in zip(configuration.stations, data.measurements, strict=True):
            values += raw(s, m, third)
        frame = layout.whole.pack(*values, 0)
    except (error, ValueError, OverflowError) as wrong:
        raise FrameError(f"the data do not fit the configuration: {wrong}") from None
    return frame[:-2] + crc_hqx(frame[:-2], 0xFFFF).to_bytes(2)


def raw(s: Station, m: Measurement, third: bool) -> list[float]:
    """The values of one station as they lie in the frame."""
    values: list[float] = [m.stat]
    for phasor, value in zip(s.phasors, m.phasors, strict=True):
        values += from_complex(s, phasor, value, third)
    if s.frequency_float:
        values += [m.frequency, m.rocof]
    else:
        values += [whole((m.frequency - s.nominal_frequency) * 1000), whole(m.rocof * 100)]
    for analog, value in zip(s.analogs, m.analogs, strict=True):
        scaled = (value - analog.offset) / analog.scale if third else value
        values.append(scaled if s.analogs_float else whole(scaled))
    return [*values, *m.digitals]


def whole(value: float, least: int = -0x7FFF, most: int = 0x7FFF) -> int:
    """The nearest integer, or ABSENT."""
    return round(value) if isfinite(value) and least <= round(value) <= most else ABSENT


def from_complex(s: Station, phasor: Phasor, value: complex, third: bool) -> tuple[float, float]:
    if phasor.angle_offset and third:
        value *= cmath.rect(1.0, phasor.angle_offset)
    if third or not s.phasors_float:
        value /= phasor.scale
    first, second = (abs(value), cmath.phase(value)) if s.polar else (value.real, value.imag)
    if s.phasors_float:
        return first, second
    if not s.polar:
        return whole(first), whole(second)
    magnitude = whole(first, 0, 0xFFFF)
    return (0, ABSENT) if magnitude == ABSENT else (magnitude, whole(second * 1e4))
