"""Scalars are CasADi expressions: the equations become a graph, and the graph becomes C."""

from casadi import (
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
)
from casadi import fabs as abs
from casadi import fmax as maximum
from casadi import fmin as minimum
from casadi import if_else as where

from .. import tree

__all__ = ["abs", "atan2", "cond", "cos", "exp", "expm1", "floor", "log", "logical_and", "logical_not"]
__all__ += ["logical_or", "maximum", "minimum", "sin", "sqrt", "where"]

logical_and, logical_or, logical_not = logic_and, logic_or, logic_not


def cond(condition, then, otherwise):
    return tree.map(lambda x, y: where(condition, x, y), then(), otherwise())
