"""Scalars are numpy arrays: ten thousand machines, or noise seeds, in one call."""

from numpy import (
    abs,
    all,
    any,
    atan2,
    broadcast_arrays,
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
    ndim,
    reshape,
    shape,
    sin,
    sqrt,
    stack,
    where,
)

from .. import tree

__all__ = ["abs", "atan2", "cond", "cos", "exp", "expm1", "floor", "fold", "log", "logical_and", "logical_not"]
__all__ += ["logical_or", "map", "maximum", "minimum", "sin", "sqrt", "where"]


def cond(condition, then, otherwise):
    if all(condition):
        return then()
    if not any(condition):
        return otherwise()
    return tree.map(lambda x, y: where(condition, x, y), then(), otherwise())


def map(function, items, shared=()):
    """With the items as one more axis, in front of all others."""
    columns = [tree.leaves(item) for item in items]
    axes = max([ndim(leaf) for leaf in tree.leaves((items, shared))])
    stacked = [
        stack(broadcast_arrays(*[with_axes(leaf, axes) for leaf in leaf_of_all])) for leaf_of_all in zip(*columns)
    ]
    result = function(tree.like(items[0], stacked), shared)
    return tuple(
        [tree.map(lambda leaf, k=k: leaf[k] if ndim(leaf) > axes else leaf, result) for k in range(len(items))]
    )


def with_axes(leaf, axes):
    return reshape(leaf, (1,) * (axes - ndim(leaf)) + shape(leaf))


def fold(function, carry, items, shared=()):
    for item in items:
        carry = function(carry, item, shared)
    return carry
