"""Time stamps to nanoseconds: whole numbers of ns since 1970-01-01 UTC, or since the file's own zero.

A float of seconds since 1970 resolves a quarter of a microsecond; ISO stamps of 100 ns keep all their digits.
"""

from datetime import UTC, datetime, timedelta, timezone, tzinfo
from functools import lru_cache
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

import numpy as np

NOT_A_TIME = np.iinfo(np.int64).min
"""As NumPy's NaT."""

SECOND = 1_000_000_000
"""ns."""

FRACSEC = 0x00FFFFFF
"""IEEE C37.118.2: the upper byte of FRACSEC is the quality of the time."""

LATEST = 2**62
"""ns; no stamp is that late."""


def from_numbers(values: np.ndarray, factor: float) -> np.ndarray:
    """Seconds, times `factor`, as float; to the microsecond where they count from 1970, else to the nanosecond."""
    seconds = np.asarray(values, dtype=float) * factor
    good = np.abs(seconds) < LATEST / SECOND
    seconds = np.where(good, seconds, 0.0)
    whole = np.floor(seconds)
    resolved = 1e6 if np.abs(seconds).max(initial=0.0) > 1e8 else 1e9
    fraction = np.rint((seconds - whole) * resolved) * (SECOND / resolved)
    return np.where(good, whole.astype(np.int64) * SECOND + fraction.astype(np.int64), NOT_A_TIME)


def from_soc(soc: np.ndarray, fracsec: np.ndarray, time_base: int) -> np.ndarray:
    """Second of century and FRACSEC of IEEE C37.118.2: SOC + (FRACSEC & 0x00FFFFFF)/TIME_BASE."""
    good = np.isfinite(soc) & np.isfinite(fracsec)
    count = np.where(good, fracsec, 0).astype(np.int64) & FRACSEC
    ns = np.where(good, soc, 0).astype(np.int64) * SECOND + (count * SECOND + time_base // 2) // time_base
    return np.where(good, ns, NOT_A_TIME)


def from_iso(stamps: np.ndarray, zone: str) -> np.ndarray:
    """ISO 8601, `T` or a blank in the middle, `-` or `/` in the date, up to 9 decimals; its own offset beats `zone`."""
    text = np.array([b" ".join(stamp.split()) for stamp in stamps.tolist()]) if has_blanks(stamps) else stamps
    n, width = len(text), text.dtype.itemsize
    if n == 0 or width == 0:
        return np.full(n, NOT_A_TIME)
    characters = np.ascontiguousarray(text).view(np.uint8).reshape(n, width).copy()
    characters[characters == ord("/")] = ord("-")
    characters[characters == ord(",")] = ord(".")
    offset, given = take_offset(characters)
    local = parsed(characters.reshape(-1).view(f"S{width}"))
    good = local != NOT_A_TIME
    away = np.where(given, offset, 0)
    if not given.all():
        away = np.where(given, offset, zone_offset(np.where(good, local, 0), zone))
    return np.where(good, local - away, NOT_A_TIME)


def has_blanks(stamps: np.ndarray) -> bool:
    """Blanks around a stamp, or two in the middle; the first ones tell."""
    return any(stamp != b" ".join(stamp.split()) for stamp in stamps[:50].tolist())


def take_offset(characters: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """UTC offsets at the end of stamps (Z, +02:00, -0500), ns, and where there is one; they are blotted out."""
    n, width = characters.shape
    lengths = width - np.argmax(characters[:, ::-1] != 0, axis=1)
    rows = np.arange(n)
    last = characters[rows, np.maximum(lengths - 1, 0)]
    zulu = (last == ord("Z")) | (last == ord("z"))
    characters[rows[zulu], lengths[zulu] - 1] = 0
    offset, given = np.zeros(n, dtype=np.int64), zulu.copy()
    for size in (6, 5):
        if width < 11 + size:
            continue
        place = np.maximum(lengths - size, 0)
        sign = characters[rows, place]
        found = ~given & (place > 10) & ((sign == ord("+")) | (sign == ord("-")))
        if not found.any():
            continue
        at = [characters[rows[found], place[found] + i].astype(np.int64) - ord("0") for i in range(1, size)]
        hours, minutes = 10 * at[0] + at[1], 10 * at[-2] + at[-1]
        way = np.where(sign[found] == ord("-"), -1, 1)
        offset[found] = way * (hours * 3600 + minutes * 60) * SECOND
        for i in range(size):
            characters[rows[found], place[found] + i] = 0
        given |= found
    return offset, given


def parsed(text: np.ndarray) -> np.ndarray:
    try:
        return text.astype("M8[ns]").astype(np.int64)
    except ValueError:
        return np.array([parsed_one(stamp) for stamp in text], dtype=np.int64)


def parsed_one(stamp: bytes) -> int:
    try:
        return int(np.datetime64(stamp.decode(), "ns").astype(np.int64))
    except ValueError:
        return NOT_A_TIME


def from_pattern(stamps: np.ndarray, pattern: str, zone: str) -> np.ndarray:
    """By a pattern of strptime, `%d.%m.%Y %H:%M:%S.%f`; decimals beyond six are kept."""
    local = np.array([by_pattern(stamp.decode("utf-8", "replace").strip(), pattern) for stamp in stamps])
    good = local != NOT_A_TIME
    return np.where(good, local - zone_offset(np.where(good, local, 0), zone), NOT_A_TIME)


def by_pattern(stamp: str, pattern: str) -> int:
    fine = 0
    if pattern.endswith("%f"):
        before, mark, decimals = stamp.rpartition("." if "." in pattern else ",")
        if mark and decimals.isdigit() and len(decimals) > 6:
            stamp, fine = f"{before}{mark}{decimals[:6]}", int(decimals[6:9].ljust(3, "0"))
    try:
        time = datetime.strptime(stamp, pattern)
    except ValueError:
        return NOT_A_TIME
    return whole_ns(time.replace(tzinfo=UTC)) + fine


def whole_ns(time: datetime) -> int:
    since = time - datetime(1970, 1, 1, tzinfo=UTC)
    return ((since.days * 86_400 + since.seconds) * 1_000_000 + since.microseconds) * 1000


def zone_offset(local: np.ndarray, zone: str) -> np.ndarray:
    """Offset of local time from UTC, ns, by the quarter of an hour."""
    quarters, place = np.unique(local // (900 * SECOND), return_inverse=True)
    return np.array([offset_at(int(quarter), zone) for quarter in quarters], dtype=np.int64)[place]


@lru_cache(maxsize=4096)
def offset_at(quarter: int, zone: str) -> int:
    local = datetime(1970, 1, 1) + timedelta(seconds=900 * quarter)
    away = local.replace(tzinfo=zone_of(zone)).utcoffset() or timedelta()
    return round(away.total_seconds()) * SECOND


def zone_of(name: str) -> tzinfo:
    """`UTC`, `+02:00` or a name of the IANA data base, `Europe/Berlin`. Raises ValueError."""
    if name.upper() in ("UTC", "Z", "GMT"):
        return UTC
    if name[:1] in "+-" and len(name) >= 3:
        hours, _, minutes = name[1:].partition(":")
        if hours.isdigit() and (minutes or "0").isdigit():
            size = timedelta(hours=int(hours), minutes=int(minutes or 0))
            return timezone(-size if name[0] == "-" else size)
    try:
        return ZoneInfo(name)
    except (ZoneInfoNotFoundError, ValueError, OSError):
        raise ValueError(f'zone "{name}" is not known; write UTC, +02:00 or for instance Europe/Berlin') from None


def utc_text(ns: int) -> str:
    """ISO 8601 with nine decimals and a Z."""
    seconds, fraction = divmod(ns, SECOND)
    return f"{datetime.fromtimestamp(seconds, UTC):%Y-%m-%dT%H:%M:%S}.{fraction:09d}Z"
