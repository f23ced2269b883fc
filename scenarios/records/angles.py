"""How far angles go as a file has them, before they are wrapped: degrees read as rad go far, and jump."""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np


class AngleRange(NamedTuple):
    """Of all angles of a record, in what the map calls rad; 0 where there are none."""

    largest: float = 0.0
    jump: float = 0.0
    """Between two frames."""

    def widened(self, angles: Iterable[np.ndarray]) -> "AngleRange":
        found = self
        for angle in angles:
            finite = angle[np.isfinite(angle)]
            largest = float(np.abs(finite).max(initial=found.largest))
            found = AngleRange(largest, float(np.abs(np.diff(finite)).max(initial=found.jump)))
        return found
