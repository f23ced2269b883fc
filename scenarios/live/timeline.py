"""Time stamps of a stream as one continuous time: frames that are missing, late or repeated are known by it.

UTC repeats or leaves out a second at a leap second, and a station's clock may be set. The time here does neither: it
runs on, so that an observer's interval between two frames is the one that passed.
"""

from typing import NamedTuple

from .c37118 import Stamp

JITTER = 0.5
"""Of a frame's period: a frame that is nearer to the last one repeats it."""

LONGEST_GAP = 10.0
"""s; a longer step of the time stamps is a clock that was set, or a station that was away: what follows starts anew."""

LATE_IN_A_ROW = 1.0
"""s of frames that all are late: then it is the clock that was set back."""


class Place(NamedTuple):
    t: float
    """s, since the second in which the stream began."""
    missing: int
    """Frames before this one that did not come."""
    anew: bool
    """There is no telling how much time has passed since the frame before: a first frame, or the clock was set."""


class Timeline:
    def __init__(self, time_base: int, period: float):
        self.time_base, self.period = time_base, period
        self.origin: int | None = None
        self.shift = 0.0
        """s, by leap seconds and by steps of the clock."""
        self.last = 0.0
        self.late_in_a_row = 0

    def place(self, stamp: Stamp) -> Place | None:
        """Where a frame belongs; None if that is not after the last one."""
        first = anew = self.origin is None
        origin = self.origin = stamp.soc if self.origin is None else self.origin
        t = stamp.soc - origin + stamp.fraction / self.time_base + self.shift
        step = t - self.last
        if not first:
            leap = self.leap(stamp, step)
            self.shift, t, step = self.shift + leap, t + leap, step + leap
        if not first and step <= JITTER * self.period:
            self.late_in_a_row += 1
            if self.late_in_a_row * self.period < LATE_IN_A_ROW:
                return None
            anew = True
        if not first and step > LONGEST_GAP:
            anew = True
        if anew and not first:  # time goes on by a period, whatever the clock says
            forward = self.last + self.period - t
            self.shift, t = self.shift + forward, t + forward
        self.last, self.late_in_a_row = t, 0
        missing = 0 if anew else max(round(step / self.period) - 1, 0)
        return Place(t, missing, anew)

    def leap(self, stamp: Stamp, step: float) -> int:
        """s by which UTC stepped back (1) or forward (-1) between the last frame and this one: a leap second."""
        if not stamp.leap_second_near:
            return 0
        leap = -1 if stamp.leap_second_deleted else 1
        expected = JITTER * self.period < step + leap <= max(0.25, 3 * self.period)
        return leap if expected and not JITTER * self.period < step <= 3 * self.period else 0
