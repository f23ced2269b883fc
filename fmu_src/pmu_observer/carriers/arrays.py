"""Scalars are numpy arrays: ten thousand machines, or noise seeds, in one call."""

from numpy import (
    abs,
    all,
    any,
    atan2,
    cos,
    exp,
    expm1,
    floor,
    log,
    logical_and,
    logical_not,
    logical_or,
    maximum,
    minimum,
    sin,
    sqrt,
    where,
)

from .. import tree

__all__ = ["abs", "atan2", "cond", "cos", "exp", "expm1", "floor", "log", "logical_and", "logical_not"]
__all__ += ["logical_or", "maximum", "minimum", "sin", "sqrt", "where"]


def cond(condition, then, otherwise):
    if all(condition):
        return then()
    if not any(condition):
        return otherwise()
    return tree.map(lambda x, y: where(condition, x, y), then(), otherwise())
