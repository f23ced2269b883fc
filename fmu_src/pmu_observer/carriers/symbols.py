"""Scalars are CasADi expressions: the equations become a graph, and the graph becomes C."""

from casadi import (
    SX,
    Function,
    atan2,
    cos,
    exp,
    expm1,
    floor,
    log,
    logic_and,
    logic_not,
    logic_or,
    sin,
    sqrt,
    vertcat,
)
from casadi import fabs as abs
from casadi import fmax as maximum
from casadi import fmin as minimum
from casadi import if_else as where

from .. import tree

__all__ = ["abs", "atan2", "cond", "cos", "exp", "expm1", "floor", "fold", "log", "logical_and", "logical_not"]
__all__ += ["logical_or", "map", "maximum", "minimum", "sin", "sqrt", "where"]

logical_and, logical_or, logical_not = logic_and, logic_or, logic_not


def cond(condition, then, otherwise):
    return tree.map(lambda x, y: where(condition, x, y), then(), otherwise())


def map(function, items, shared=()):
    """A call of a function that calls another one for each item, so that the C has a loop there."""
    item, common = symbols_like(items[0]), symbols_like(shared)
    result = function(item, common)
    body = never_inlined("body", [item, common], result)
    every, given = symbols_like(tuple(items)), symbols_like(shared)
    results = [body(vector(one), vector(given)) for one in every]
    loop = Function("map", [vector(every), vector(given)], [vertcat(*results)], {"never_inline": True})
    found = loop(vector(tuple(items)), vector(shared)).elements()
    size = len(found) // len(items)
    return tuple([tree.like(result, found[k * size :]) for k in range(len(items))])


def fold(function, carry, items, shared=()):
    """Likewise, each call with the result of the last one."""
    first, item, common = symbols_like(carry), symbols_like(items[0]), symbols_like(shared)
    body = never_inlined("body", [first, item, common], function(first, item, common))
    every, given = symbols_like(tuple(items)), symbols_like(shared)
    result = vector(first)
    for one in every:
        result = body(result, vector(one), vector(given))
    arguments = [vector(first), vector(every), vector(given)]
    loop = Function("fold", arguments, [result], {"never_inline": True})
    found = loop(vector(carry), vector(tuple(items)), vector(shared)).elements()
    return tree.like(carry, found)


def never_inlined(name, arguments, result):
    return Function(name, [vector(a) for a in arguments], [vector(result)], {"never_inline": True})


def symbols_like(shape):
    return tree.like(shape, [SX.sym(name) for name in tree.names(shape)])


def vector(branch):
    return SX(vertcat(*tree.leaves(branch)))
