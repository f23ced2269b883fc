"""A record to check, what is known beside it, and what several checks look at."""

from dataclasses import dataclass, field
from functools import cached_property
from math import pi

import numpy as np

from ...machines.table import Machine
from ..angles import AngleRange
from ..findings import Finding
from ..raster import Raster
from ..standard import StandardRecord

NEAR = 0.06
"""A ratio this close to that of a known mistake, relatively, is it: transformers and noise are within 3 %."""


@dataclass(frozen=True)
class Case:
    """A record to check, and what is known beside it."""

    record: StandardRecord
    machine: Machine | None = None
    raster: Raster | None = None
    """Of a conversion."""
    angles: AngleRange | None = None
    """As the file has them; else those of the record."""
    reported: list[Finding] = field(default_factory=list)

    @cached_property
    def good(self) -> np.ndarray:
        """Frames in which the machine is on line."""
        r = self.record
        return r.frame_valid & (r.V_t * r.I_t > 1e-3 * np.nanmedian(r.V_t * r.I_t) + 1e-12)

    def of(self, values: np.ndarray) -> np.ndarray:
        found = values[self.good]
        return found[np.isfinite(found)]

    def median(self, values: np.ndarray) -> float:
        found = self.of(values)
        return float(np.median(found)) if len(found) else np.nan

    @property
    def reported_power(self) -> bool:
        """Whether V, I, P and Q are wrong already: what rests on them is then not told."""
        return any(f.check in ("voltage", "current", "power", "angle unit") for f in self.reported)

    @property
    def rating(self) -> float | None:
        """pu of the record."""
        return self.machine["S_n"] / self.record.S_base if self.machine else None

    @cached_property
    def ratio(self) -> complex:
        """(P + jQ)/(V conj I), the median of each part; nan if P and Q follow from V and I, or were not recorded."""
        r = self.record
        return self._median_ratio(r.P_t + 1j * r.Q_t, r.V * np.conj(r.I))

    def _median_ratio(self, a: np.ndarray, b: np.ndarray) -> complex:
        with np.errstate(all="ignore"):
            found = self.of(a / b)
        return complex(np.median(np.real(found)), np.median(np.imag(found))) if len(found) else complex(np.nan)

    @cached_property
    def speed(self) -> tuple[float, float]:
        """Mean speed of theta, rad/s, and its slope against 2 pi (f - f0): nan without f, or where nothing moves."""
        r = self.record
        turn = np.angle(r.V[1:] * np.conj(r.V[:-1])) * r.rate
        steady = np.diff(r.time) < 1.5 / r.rate
        turn = np.where(steady, turn, np.nan)
        mean = float(np.nanmedian(turn)) if np.isfinite(turn).any() else np.nan
        if not (r.f0 and r.has("f")):
            return mean, np.nan
        span = max(round(0.5 * r.rate), 1)
        whole = len(turn) // span * span
        away = 2 * pi * (r.f[1:] - r.f0)
        y, x = (v[:whole].reshape(-1, span).mean(axis=1) for v in (turn, away))
        both = np.isfinite(x) & np.isfinite(y)
        x, y = x[both], y[both]
        if len(x) < 4 or np.mean(x * x) < 0.01**2:  # 1.6 mHz: nothing to compare
            return mean, np.nan
        return mean, float(np.sum(x * y) / np.sum(x * x))


def near(value: float, target: float, tolerance: float = NEAR) -> bool:
    return target != 0 and abs(value / target - 1) < tolerance


def first(*found: tuple[bool, str]) -> tuple[str, ...]:
    """The causes whose condition holds."""
    return tuple(cause for holds, cause in found if holds)
