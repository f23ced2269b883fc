"""Checks of the times, and of frames that stand still."""

from collections.abc import Iterator

import numpy as np

from ..findings import DOUBTFUL, NONSENSE, Finding
from ..raster import rate_of
from ..times import SECOND
from .case import Case, first, near

BEFORE = 20
"""Frames; what moves before it stands still was no simulation at rest."""


def raster(case: Case) -> Iterator[Finding]:
    """The times against the rate; repeated, backward, missing rows."""
    record, made = case.record, case.raster
    if made is not None:
        measured, rate, frames = made.measured_rate, made.rate, max(made.frames, 1)
        repeated, backward, off = made.repeated, made.backward, made.off
    else:
        stamps = np.rint(record.t_frame[record.frame_valid] * SECOND).astype(np.int64)
        measured, rate, frames = rate_of(stamps), record.rate, max(len(stamps), 1)
        repeated, backward = int(np.sum(np.diff(stamps) == 0)), int(np.sum(np.diff(stamps) < 0))
        place = (stamps - stamps[0]) * (rate / SECOND)
        off = int(np.sum(np.abs(place - np.rint(place)) > 0.25))
    if not near(measured, rate, 0.02):
        causes = first(
            (near(measured, rate * 1e3), "time unit"), (near(measured, rate / 1e3), "time unit"), (True, "rate")
        )
        yield Finding("raster", NONSENSE, f"frames come {measured:g} times a second, the rate is {rate:g}", causes)
    elif not 1 <= measured <= 250:
        yield Finding("raster", NONSENSE, f"frames come {measured:g} times a second", ("time unit",))
    elif off / frames > 0.1:
        measured_text = f"{off / frames:.0%} of the frames are off the raster by more than a quarter of a period"
        yield Finding("raster", DOUBTFUL, measured_text, ("time off raster", "rate"))
    for count, what, cause in ((repeated, "twice", "repeated"), (backward, "later than one behind it", "backward")):
        if count / frames > 1e-3:
            grade = NONSENSE if count / frames > 0.05 else DOUBTFUL
            yield Finding("raster", grade, f"{count} stamps ({count / frames:.1%}) stand {what}", (cause,))
    lost = 1 - np.mean(record.frame_valid)
    if lost > 0.2:
        grade = NONSENSE if lost > 0.9 else DOUBTFUL
        yield Finding("raster", grade, f"{lost:.0%} of the frames are lost", ("lost", "rate"))


def held(case: Case) -> Iterator[Finding]:
    """Frames that are bit-identical to the one before, among such as move."""
    r = case.record
    frames = np.column_stack([r.V_t, r.theta_t, r.I_t, r.phi_t])
    change = np.abs(np.diff(frames, axis=0)).max(axis=1)
    change = change[np.isfinite(change)]
    if len(change) < 10:
        return
    same = change == 0
    moving = (change > 1e-6) | same
    beside = np.convolve(change > 1e-6, np.ones(9), mode="same") >= 3  # moves on either side, most of the time
    share = float(np.mean(same & beside & moving))
    lively = change > 1e-5
    inner = [
        stop - start for start, stop in runs(same) if start >= BEFORE and np.mean(lively[start - BEFORE : start]) > 0.6
    ]
    longest = max(inner, default=0) / r.rate
    if share > 0.05:
        measured = f"{share:.0%} of the frames are the one before once more, while others move"
        yield Finding("held", NONSENSE if share > 0.3 else DOUBTFUL, measured, ("held",))
    elif longest > 0.3:
        measured = f"the values stand still for {longest:.2g} s, and move before and after"
        yield Finding("held", DOUBTFUL, measured, ("held",))


def runs(same: np.ndarray) -> list[tuple[int, int]]:
    """Where stretches begin and end."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], same.astype(int), [0]])))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))
