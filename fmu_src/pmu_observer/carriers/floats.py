"""Scalars are Python floats: the standard library only, for the Python FMU."""

from math import atan2, cos, exp, expm1, log, sin, sqrt

__all__ = ["abs", "atan2", "cond", "cos", "exp", "expm1", "floor", "fold", "log", "logical_and", "logical_not"]
__all__ += ["logical_or", "map", "maximum", "minimum", "sin", "sqrt", "where"]

abs = abs


def floor(x):
    return x // 1.0  # math.floor raises for NaN and inf


def where(condition, x, y):
    return x if condition else y


def cond(condition, then, otherwise):
    return then() if condition else otherwise()


def minimum(x, y):
    return x if x < y else y


def maximum(x, y):
    return x if x > y else y


def logical_and(x, y):
    return x and y


def logical_or(x, y):
    return x or y


def logical_not(x):
    return not x


def map(function, items, shared=()):
    return tuple([function(item, shared) for item in items])


def fold(function, carry, items, shared=()):
    for item in items:
        carry = function(carry, item, shared)
    return carry
