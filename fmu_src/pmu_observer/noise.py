"""What the noise of the phasors does to the measured signals, and how large it is.

A total vector error tve on V and I: complex noise with E|n|^2 = (tve |.|)^2 on each, white, independent.
"""

from typing import NamedTuple

from .interface import Scalar
from .linear import Complex
from .phasors import Signals


def of_phasor(s: Signals):
    """E|n|^2 of the phasor j F = j (V + j x I), pu^2."""
    V, xI = s.measured.V, s.x * s.measured.I
    return s.measured.tve * s.measured.tve * (V * V + xI * xI)


def of_Y1(s: Signals):
    """Mean and variance of the error of Y1 = |j F|^2: s2 and 2 Y1 s2 + s2^2 with s2 = E|n|^2, pu^2 and pu^4."""
    s2 = of_phasor(s)
    return s2, 2 * s.Y1 * s2 + s2 * s2


def of_nu(s: Signals):
    """E|dnu|^2 = 2 tve^2 |nu (1 + nu)|^2: nu = x' conj(I/(j E')) with both I and j E' noisy."""
    re, im = s.nu.re, s.nu.im
    one = 1 + re
    return 2 * s.measured.tve * s.measured.tve * (re * re + im * im) * (one * one + im * im)


def of_nu_and_Y1(s: Signals) -> Complex:
    """E[dnu dY1] = -Y1 tve^2 nu (1 + nu)(1 + 2 conj(nu)), pu^2: the same noise is in both.

    With n = j (dV + j x' dI), dV = v V, dI = i I and eta = conj(nu): n/(j E') = (1 + eta) v - eta i,
    deta = eta (1 + eta)(i - v), dY1 = 2 Y1 Re(n/(j E')), to first order in v and i.
    """
    re, im = s.nu.re, s.nu.im
    a, b = re * (1 + re) - im * im, im * (1 + 2 * re)
    scale = -s.Y1 * s.measured.tve * s.measured.tve
    return Complex(scale * (a * (1 + 2 * re) + 2 * b * im), scale * (b * (1 + 2 * re) - 2 * a * im))


AT_FIRST = -9.21
"""log tve^2 of 1 %; too large is harmless, too small is not."""

FEW = 30
"""Frames from which no tve below the first one is concluded."""


class Estimate(NamedTuple):
    """tve from the frames themselves, as long as it is not given."""

    log_tve2: Scalar = AT_FIRST
    frames: Scalar = 0.0
    Y1: Scalar = 1.0  # of the last two frames
    Y1_before: Scalar = 1.0


LEAST_TVE = 2e-4
"""The least that is assumed: below it the sampling's own error counts, and misleads a filter that is not told."""

MEDIAN = 0.455
"""Of chi-square with one degree of freedom: the median of x^2 is MEDIAN times the variance of a normal x."""


def learn(xp, e: Estimate, s: Signals) -> Estimate:
    """tve^2 = median((Y1 - 2 Y1- + Y1--)^2)/(0.455 * 12 Y1 c),  c = V^2 + (x I)^2.

    The second difference of Y1 has six times the variance of a frame, 2 Y1 tve^2 c. The median is tracked in the
    logarithm by steps of constant size (Robbins and Monro), so that jumps and gross errors hardly count.
    """
    V, xI = s.measured.V, s.x * s.measured.I
    bend = s.Y1 - 2 * e.Y1 + e.Y1_before
    found = bend * bend / (MEDIAN * 12 * s.Y1 * (V * V + xI * xI))
    frames = e.frames + 1
    step = xp.maximum(2.33 / (frames + 5), 0.01)  # 1/(2 x density of log x at its median), x chi-square
    above = found > xp.exp(e.log_tve2)
    enough = frames > 2
    log_tve2 = e.log_tve2 + xp.where(enough, xp.where(above, step, -step), 0.0)
    return Estimate(log_tve2, frames, s.Y1, e.Y1)


def learnt(xp, e: Estimate):
    return xp.exp(xp.where(e.frames < FEW, xp.maximum(e.log_tve2, AT_FIRST), e.log_tve2) / 2)
