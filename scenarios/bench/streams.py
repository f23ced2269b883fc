"""Random numbers that belong to a machine and a noise seed: the same whatever runs beside them, and wherever."""

import numpy as np

from fmu_src.pmu_observer import mrg32k3a
from fmu_src.pmu_observer.carriers import arrays

PER_SEED = 1_000_000
"""Streams of a study's `--seed`, which may be up to 500 then."""

MACHINES, WANDERING = 2**30, 3 * 2**29
"""Where the streams begin that machines are drawn from, and those that wander; those of noise begin at 0."""


class Streams:
    """One of MRG32k3a's independent streams for each of `numbers`, whole numbers from 0 to 2^31 - 1 in an array."""

    def __init__(self, numbers):
        self.generator = mrg32k3a.stream(arrays, np.asarray(numbers, float))

    def uniform(self, low=0.0, high=1.0):
        """A number in (low, high) from each stream."""
        self.generator, u = mrg32k3a.uniform(arrays, self.generator)
        return low + (high - low) * u

    def normal(self):
        """A normal number from each stream (Box and Muller 1958)."""
        r, angle = np.sqrt(-2 * np.log(self.uniform())), self.uniform(0.0, 2 * np.pi)
        return r * np.cos(angle)


def numbers(seed: int, shape, first: int = 0):
    """Of the machine-seeds from `first` on, an array of that shape."""
    return seed * PER_SEED + first + np.arange(np.prod(shape, dtype=int)).reshape(shape)
