"""Scalars are sets of what they depend on: which outputs of a model follow which inputs, for modelDescription.xml."""

from typing import Any

from .. import tree

__all__ = ["abs", "atan2", "cond", "cos", "exp", "expm1", "floor", "fold", "log", "logical_and", "logical_not"]
__all__ += ["logical_or", "map", "maximum", "minimum", "sin", "sqrt", "where"]


class Dependent:
    """What a scalar depends on, as the bits of an integer."""

    __slots__ = ("bits",)

    def __init__(self, bits: int):
        self.bits = bits

    def __bool__(self):
        raise TypeError("a branch on a value: take `xp.where` or `xp.cond`")


def together(*scalars: Any) -> Dependent:
    """What is calculated from these."""
    bits = 0
    for scalar in scalars:
        bits |= scalar.bits if isinstance(scalar, Dependent) else 0
    return Dependent(bits)


for operation in ("add", "sub", "mul", "truediv", "pow", "radd", "rsub", "rmul", "rtruediv", "rpow"):
    setattr(Dependent, f"__{operation}__", together)
for operation in ("neg", "pos", "abs", "lt", "le", "gt", "ge", "eq", "ne"):
    setattr(Dependent, f"__{operation}__", together)

abs = atan2 = cos = exp = expm1 = floor = log = sin = sqrt = together
logical_and = logical_not = logical_or = maximum = minimum = where = together


def cond(condition, then, otherwise):
    return tree.map(lambda x, y: together(condition, x, y), then(), otherwise())


def map(function, items, shared=()):
    return tuple([function(item, shared) for item in items])


def fold(function, carry, items, shared=()):
    for item in items:
        carry = function(carry, item, shared)
    return carry
