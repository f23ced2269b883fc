"""MRG32k3a: random numbers in doubles, the same to the bit on every carrier.

L'Ecuyer, "Good parameters and implementations for combined multiple recursive random number generators", Operations
Research 47 (1999) 159-164: period 2^191, every intermediate result a whole number below 2^53. Its streams, 2^127
numbers apart, are those of L'Ecuyer, Simard, Chen and Kelton, Operations Research 50 (2002) 1073-1075 (RngStreams).
"""

from typing import NamedTuple

from .interface import Scalar

M1, M2 = 4294967087.0, 4294944443.0
NORM = 2.328306549295727688e-10  # 1/(M1 + 1)
SEED = 12345.0  # of stream 0

LARGEST_STREAM_BITS = 31


class Generator(NamedTuple):
    """The last three numbers of either component, oldest first; whole numbers in [0, M1) and in [0, M2)."""

    s10: Scalar = SEED
    s11: Scalar = SEED
    s12: Scalar = SEED
    s20: Scalar = SEED
    s21: Scalar = SEED
    s22: Scalar = SEED


def uniform(xp, g: Generator):
    """The next generator, and a number in (0, 1)."""
    p1 = modulo(xp, 1403580.0 * g.s11 - 810728.0 * g.s10, M1)
    p2 = modulo(xp, 527612.0 * g.s22 - 1370589.0 * g.s20, M2)
    u = xp.where(p1 > p2, p1 - p2, p1 - p2 + M1) * NORM
    return Generator(g.s11, g.s12, p1, g.s21, g.s22, p2), u


def modulo(xp, x, m):
    """x mod m, exactly for |x| < 2^53."""
    return x - m * xp.floor(x / m)


def stream(xp, number) -> Generator:
    """The start of a stream, by its number in 0 ... 2^31 - 1: A^(2^127 number) applied to stream 0, bit by bit.

    Neighbouring numbers give independent streams. Seeds that differ by 1 would not: their sequences differ, mod 1, by
    numbers that are the same for every such pair.
    """
    first, second = (SEED,) * 3, (SEED,) * 3
    for bit, (jump1, jump2) in enumerate(JUMPS):
        half = number / 2.0**bit
        is_set = xp.floor(half) - 2 * xp.floor(half / 2) > 0
        first = [xp.where(is_set, a, b) for a, b in zip(jumped(xp, jump1, first, M1), first)]
        second = [xp.where(is_set, a, b) for a, b in zip(jumped(xp, jump2, second, M2), second)]
    return Generator(*first, *second)


def jumped(xp, matrix, v, m):
    """matrix v mod m."""
    return [modulo(xp, sum(multiplied(xp, a, x, m) for a, x in zip(row, v)), m) for row in matrix]


def multiplied(xp, a, x, m):
    """a x mod m for a constant a < 2^32 and x < 2^32, in two parts that stay below 2^53."""
    high, low = divmod(a, 2**17)
    return modulo(xp, modulo(xp, high * x, m) * 2.0**17 + low * x, m)


def _jumps():
    """A1 and A2 to the powers 2^127, 2^128, ...: one pair for each bit of a stream's number."""
    a1, a2 = ((0, 1, 0), (0, 0, 1), (-810728, 1403580, 0)), ((0, 1, 0), (0, 0, 1), (-1370589, 0, 527612))
    pairs = []
    for exponent in range(127 + LARGEST_STREAM_BITS):
        if exponent >= 127:
            pairs.append((a1, a2))
        a1, a2 = _squared(a1, int(M1)), _squared(a2, int(M2))
    return pairs


def _squared(a, m):
    return [[sum(a[i][k] * a[k][j] for k in range(3)) % m for j in range(3)] for i in range(3)]


JUMPS = _jumps()
