"""What the innovations say of the standard deviations.

An estimator that knows its machine and its noise has innovations with a mean square of 1. Where it is more, something
is wrong that no covariance knows of, and the variances that are shown grow in proportion.
"""

from typing import NamedTuple

from .interface import Scalar

MEMORY, LARGEST_SHARE = 1.0, 0.1
"""s, and of a frame: the mean is over a second, or over ten frames where they come slowly."""

MOST = 1e4
"""A squared innovation beyond this counts no further."""


class MeanSquares(NamedTuple):
    """Of the last second's innovations."""

    radial: Scalar = 1.0  # of |E'|
    angle: Scalar = 1.0  # of the angle of E'


def observed(xp, before: MeanSquares, innovation, angle_innovation, capturing, h) -> MeanSquares:
    """With a frame, h s after the one before; what comes before the capture says nothing of what comes after it."""
    share = xp.minimum(1 - xp.exp(-h / MEMORY), LARGEST_SHARE)

    def averaged(mean, innovation):
        moved = mean + share * (xp.minimum(innovation * innovation, MOST) - mean)
        return xp.where(capturing > 0, 1.0, moved)

    return MeanSquares(averaged(before.radial, innovation), averaged(before.angle, angle_innovation))


def growth(xp, mean_square):
    """By which a variance is multiplied."""
    return xp.maximum(mean_square, 1.0)
