"""States, parameters and outputs are trees: NamedTuples of scalars and of further NamedTuples."""

from itertools import islice
from typing import Any, Iterable, List


def leaves(tree: Any) -> List[Any]:
    """The scalars of a tree, in order."""
    if not isinstance(tree, tuple):
        return [tree]
    found: List[Any] = []
    _collect(tree, found.append)
    return found


def _collect(tree, add):
    for branch in tree:
        if isinstance(branch, tuple):
            _collect(branch, add)
        else:
            add(branch)


def changed(tree: Any, before: Any) -> List[Any]:
    """The scalars of a tree, less those of the branches that it shares with another one of its shape."""
    found: List[Any] = []
    _collect_changed(tree, before, found.append)
    return found


def _collect_changed(tree, before, add):
    for branch, old in zip(tree, before):
        if branch is old:
            continue
        if isinstance(branch, tuple):
            _collect_changed(branch, old, add)
        else:
            add(branch)


def names(tree: Any) -> List[str]:
    """The dotted name of every leaf, in the order of `leaves`: `gpebo.xi.d`, ...; a plain tuple counts from 0"""
    if not isinstance(tree, tuple):
        return [""]
    fields = getattr(tree, "_fields", range(len(tree)))
    return [f"{field}.{name}".rstrip(".") for field, branch in zip(fields, tree) for name in names(branch)]


def like(tree: Any, scalars: Iterable[Any]) -> Any:
    """A tree of the same shape with other leaves. Raises StopIteration if there are too few."""
    return _like(tree, iter(scalars))


def _like(tree, scalars):
    if not isinstance(tree, tuple):
        return next(scalars)
    size = len(tree)
    if not any(isinstance(branch, tuple) for branch in tree):
        return _of_type(tree, islice(scalars, size))
    return _of_type(tree, [_like(branch, scalars) for branch in tree])


def map(function, *trees: Any) -> Any:
    """`function` applied to the leaves of trees of one shape."""
    first = trees[0]
    if not isinstance(first, tuple):
        return function(*trees)
    return _of_type(first, [map(function, *branches) for branches in zip(*trees)])


def _of_type(tree, branches):
    # a plain tuple groups what a function returns; a NamedTuple takes its branches one by one
    return type(tree)(*branches) if hasattr(tree, "_fields") else tuple(branches)
