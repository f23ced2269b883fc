"""Small matrices as tuples of rows of scalars, and symmetric ones as their upper triangle, row by row."""

from functools import cache
from typing import Sequence, Tuple

from .interface import Scalar

Column = Tuple[Scalar, ...]
Rows = Tuple[Column, ...]
Symmetric = Tuple[Scalar, ...]


def dot(v: Sequence, w: Sequence):
    if len(v) == 2:  # most are of 2 or 3, and a loop takes Python twice as long
        return v[0] * w[0] + v[1] * w[1]
    if len(v) == 3:
        return v[0] * w[0] + v[1] * w[1] + v[2] * w[2]
    total = v[0] * w[0]
    for a, b in zip(v[1:], w[1:]):
        total = total + a * b
    return total


def apply(a: Rows, v: Sequence) -> Column:
    return tuple([dot(row, v) for row in a])


def product(a: Rows, b: Rows) -> Rows:
    columns = list(zip(*b))
    return tuple([tuple([dot(row, column) for column in columns]) for row in a])


def plus(a: Rows, b: Rows) -> Rows:
    return tuple([tuple([x + y for x, y in zip(row, other)]) for row, other in zip(a, b)])


def scaled(factor, a: Rows) -> Rows:
    return tuple([tuple([factor * x for x in row]) for row in a])


def transposed(a: Rows) -> Rows:
    return tuple(zip(*a))


def columns(*vectors: Column) -> Rows:
    """The matrix with these columns."""
    return tuple(zip(*vectors))


def full(s: Symmetric, n: int) -> Rows:
    """All n x n entries."""
    return tuple([tuple([s[k] for k in row]) for row in places(n)])


@cache
def places(n: int) -> Tuple[Tuple[int, ...], ...]:
    """Of all n x n entries, in the upper triangle."""
    return tuple([tuple([place(min(i, j), max(i, j), n) for j in range(n)]) for i in range(n)])


def place(i: int, j: int, n: int) -> int:
    """Of entry (i, j), i <= j, in the upper triangle."""
    return i * n - i * (i - 1) // 2 + j - i


def outer(v: Sequence) -> Symmetric:
    """v v^T."""
    return tuple([x * y for i, x in enumerate(v) for y in v[i:]])


def solve(a: Rows, b: Rows) -> Rows:
    """a^-1 b by elimination without pivoting."""
    n = len(a)
    rows = [list(row) + list(right) for row, right in zip(a, b)]
    for k in range(n):
        inverse = 1 / rows[k][k]
        pivot = [inverse * x for x in rows[k][k + 1 :]]
        rows[k][k + 1 :] = pivot
        for i in range(n):
            if i != k:
                factor = rows[i][k]
                rows[i][k + 1 :] = [x - factor * y for x, y in zip(rows[i][k + 1 :], pivot)]
    return tuple([tuple(row[n:]) for row in rows])


SQUARINGS = 3


def exponential_halves(a: Rows, h) -> Tuple[Rows, Rows]:
    """exp(a h/2) and exp(a h): the Pade approximant (2, 2) of exp(a h/8), squared.

    exp X = 1 + X/(1 - X/2 + X^2/12) to 5th order; for X with eigenvalues of negative real part it needs no pivoting and
    never grows. For h = 1/25 s and T'' = 0.03 s the error is 1e-7.
    """
    n = len(a)
    X = scaled(h / 2**SQUARINGS, a)
    X2 = product(X, X)
    D = [[(1.0 if i == j else 0.0) - X[i][j] / 2 + X2[i][j] / 12 for j in range(n)] for i in range(n)]
    part = solve(tuple(map(tuple, D)), X)
    e = tuple([tuple([1 + x if i == j else x for j, x in enumerate(row)]) for i, row in enumerate(part)])
    for _ in range(SQUARINGS - 1):
        e = product(e, e)
    return e, product(e, e)
