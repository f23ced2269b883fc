"""What is found out about a record before anything is fitted to it: events, gross frames, noise, smooth phasors."""

from typing import NamedTuple

import numpy as np

LEAST_TVE = 3e-4
"""What is assumed at least: below it the sampling's own error counts more than the noise."""

REACH, DEGREE = 6, 3
"""Frames on either side, and the polynomial through them, from which a smoothed phasor comes."""

JUMP = 28.0
"""A jump: |Y - Y-|^2 and a third of |Y - 2 Y- + Y--|^2 are beyond 28 variances of a frame's noise."""

GROSS = 6.0
"""Standard deviations by which a gross frame is off the line between its neighbours."""

E_F_JUMP = 0.02
"""pu per interval, by which E_f bends where it has jumped; it has no noise worth speaking of."""

MOST_SHARES = 8
"""Events of a record whose instants are fitted: the largest."""


class Record(NamedTuple):
    """One machine's frames at its terminal, pu on the base of its data; one element a frame."""

    t: np.ndarray  # s
    V: np.ndarray  # complex, like I in one reference frame
    I: np.ndarray  # noqa: E741 - generator convention
    E_f: np.ndarray  # open circuit: E_f = 1 gives V = 1
    P_m: np.ndarray | None = None  # None: not recorded
    valid: np.ndarray | None = None  # False: no frame came
    name: str = "record"


class Prepared(NamedTuple):
    record: Record
    h: np.ndarray  # (T,) s, of the interval that a frame ends
    V: np.ndarray  # raw; where a frame is not good, smoothed
    I: np.ndarray  # noqa: E741 - the paper's name
    smooth_V: np.ndarray  # each from its neighbours, itself left out
    smooth_I: np.ndarray
    good: np.ndarray  # (T,) bool
    events: np.ndarray  # numbers of the frames that end an interval with a jump of the network
    E_f_events: np.ndarray  # likewise of E_f
    tve: float  # learnt from the frames


def prepare(record: Record, tve: float | None = None, events: list[float] | None = None) -> Prepared:
    """Events (or those given, s), gross frames, TVE (or the given one) and smoothed phasors of a record."""
    record = trimmed(record)
    valid = np.ones(len(record.t), bool) if record.valid is None else np.asarray(record.valid) > 0
    turning = np.exp(-1j * frequency(record, valid) * (record.t - record.t[0]))
    h = np.diff(record.t, prepend=record.t[0])
    phasors = filled(np.stack([record.V * turning, record.I * turning]), record.t, valid)
    level = learnt(phasors, valid)
    gross = gross_frames(phasors, level) & valid
    phasors = filled(phasors, record.t, valid & ~gross)
    found = jumps(phasors, level) if events is None else np.searchsorted(record.t, np.asarray(events) + 1e-9)
    found = found[(found > 0) & (found < len(h))]
    good = valid & ~gross
    smooth = smoothed(phasors, record.t, good, found)
    raw = np.where(good, phasors, smooth)
    back = turning.conj()
    return Prepared(
        record,
        h,
        (raw * back)[0],
        (raw * back)[1],
        (smooth * back)[0],
        (smooth * back)[1],
        good,
        found,
        forcing_jumps(record.E_f),
        max(tve or level, LEAST_TVE),
    )


def trimmed(record: Record) -> Record:
    """From the first valid frame to the last one."""
    if record.valid is None:
        return record
    rows = np.flatnonzero(np.asarray(record.valid) > 0)
    kept = slice(rows[0], rows[-1] + 1)
    return record._replace(
        **{name: value[kept] for name, value in record._asdict().items() if isinstance(value, np.ndarray)}
    )


def frequency(record: Record, valid) -> float:
    """rad/s, by which the phasors turn: the median over the frames."""
    V, t = record.V[valid], record.t[valid]
    return float(np.median(np.angle(V[1:] * V[:-1].conj()) / np.diff(t)))


def filled(phasors, t, good):
    """(2, T), with a straight line where frames are not good."""
    if good.all():
        return phasors
    return np.stack([np.interp(t, t[good], p[good].real) + 1j * np.interp(t, t[good], p[good].imag) for p in phasors])


def learnt(phasors, valid) -> float:
    """tve^2 = median(|Y - 2 Y- + Y--|^2/|Y|^2)/(6 ln 2): the second difference has six times the variance of a frame.

    The median of |n|^2 of complex noise is ln 2 of its mean; jumps and gross frames hardly count.
    """
    counted = valid[2:] & valid[1:-1] & valid[:-2]
    bend = np.abs(np.diff(phasors, 2)) ** 2 / np.abs(phasors[:, 1:-1]) ** 2
    return float(np.sqrt(np.median(bend[:, counted]) / (6 * np.log(2))))


def gross_frames(phasors, tve):
    """True where one phasor alone, V or I, is far from the line between its neighbours, for one or two frames.

    An event in the network moves both; no event is over within a frame.
    """
    found = np.zeros(phasors.shape[1], bool)
    size = np.abs(phasors)
    for length in (1, 2):
        first, last = phasors[:, : -length - 1], phasors[:, length + 1 :]
        step = np.abs(last - first) / size[:, : -length - 1]
        off = []
        for i in range(1, length + 1):
            line = first + (last - first) * i / (length + 1)
            off.append(np.abs(phasors[:, i : phasors.shape[1] - length - 1 + i] - line) / size[:, : -length - 1])
        least, most = np.min(off, 0), np.max(off, 0)
        for mine, other in ((0, 1), (1, 0)):
            far = least[mine] > GROSS * tve * np.sqrt(1.5)
            alone = (most[other] < np.maximum(4 * tve, 0.04 * least[mine])) & (step[mine] < least[mine] / 2)
            for k in np.flatnonzero(far & alone):
                found[k + 1 : k + 1 + length] = True
    return found


def jumps(phasors, tve):
    """Frames whose V or I is a jump away from the one before: neither noise nor the going on of the last change."""
    change = np.diff(phasors) / np.abs(phasors[:, 1:])
    bend = np.diff(change, prepend=change[:, :1])
    size = np.minimum(np.abs(change) ** 2, np.abs(bend) ** 2 / 3).max(0)
    found = np.flatnonzero(size > JUMP * tve * tve + 1e-6) + 1
    largest = found[np.argsort(size[found - 1])[::-1][:MOST_SHARES]]
    return np.sort(largest)


def forcing_jumps(E_f):
    change = np.diff(E_f)
    bend = np.diff(change, prepend=change[:1])
    size = np.minimum(np.abs(change), np.abs(bend))
    found = np.flatnonzero(size > E_F_JUMP * np.maximum(1.0, np.abs(E_f).max())) + 1
    return np.sort(found[np.argsort(size[found - 1])[::-1][:MOST_SHARES]])


def smoothed(phasors, t, good, events):
    """Each phasor from a polynomial through its neighbours, itself left out, on its side of every event.

    So the noise of a smoothed phasor is not that of the frame itself.
    """
    frames = phasors.shape[1]
    side = np.zeros(frames, int)
    side[events] = 1
    side = np.cumsum(side)
    offsets = np.array([i for i in range(-REACH, REACH + 1) if i])
    rows = np.arange(frames)[:, None] + offsets
    inside = (rows >= 0) & (rows < frames)
    rows = np.clip(rows, 0, frames - 1)
    used = inside & good[rows] & (side[rows] == side[:, None])
    scale = REACH * np.median(np.diff(t))
    tau = (t[rows] - t[:, None]) / scale
    used &= np.abs(tau) < 2
    count = used.sum(1)
    # as many powers as the neighbours carry, and fewer where they are on one side only
    two_sided = (used & (offsets < 0)).any(1) & (used & (offsets > 0)).any(1)
    degree = np.clip(np.minimum(DEGREE, np.where(two_sided, count - 2, (count - 1) // 2)), 0, DEGREE)
    powers = tau[:, :, None] ** np.arange(DEGREE + 1)
    powers = powers * (np.arange(DEGREE + 1) <= degree[:, None])[:, None, :] * used[:, :, None]
    normal = np.einsum("kia,kib->kab", powers, powers) + 1e-12 * np.eye(DEGREE + 1)
    weights = np.einsum("kb,kib->ki", np.linalg.inv(normal)[:, 0, :], powers)
    found = np.einsum("ki,pki->pk", weights, phasors[:, rows])
    return np.where(count > 0, found, phasors)
