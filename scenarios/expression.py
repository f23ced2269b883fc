"""Expressions of a scenario: "observer.e1d - plant.e1d", "2*pi*60*(omega - 1) [rad/s]".

The unit stands behind the expression in brackets. It may be left out where it follows from the variables: in sums and
differences of variables of one unit.
"""

import ast
import operator
import re
from collections.abc import Mapping
from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np

OPERATORS = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
}
FUNCTIONS = {name: getattr(np, name) for name in ("abs", "sin", "cos", "atan2", "sqrt", "exp", "hypot")}
CONSTANTS = {"pi": pi}


@dataclass(frozen=True)
class Expression:
    source: str
    """As written."""
    text: str
    """Without the unit."""
    written_unit: str | None
    tree: ast.expr
    names: frozenset[str]
    """Of the variables: `plant.delta`, or a column of a record."""

    @property
    def keys(self) -> list[str]:
        """What is to be filled in before it has a value: `unit` in plant.G{unit}.delta."""
        return KEY.findall(self.source)

    def __call__(self, values: Mapping[str, Any]) -> Any:
        """The value, from those of the variables in `names` (numbers or arrays of one shape)."""
        return evaluate(self.tree, values)

    def unit(self, units: Mapping[str, str]) -> str:
        """The unit, from those of the variables. Raises ValueError if it is missing or contradicts them."""
        follows = unit_of(self.tree, units)
        unit = self.written_unit or follows
        if unit is None:
            raise ValueError(f'the unit of "{self.text}" is missing; write it behind in brackets: "{self.text} [pu]"')
        if follows not in (None, unit):
            raise ValueError(f'"{self.text}" is in {follows}, not in {unit}; write [{follows}], or convert the value')
        return unit


KEY = re.compile(r"{(\w+)}")


def parse(text: str) -> Expression:
    """An expression, perhaps with values of a sweep still to be filled in.

    Raises ValueError, saying what is wrong, for what is not one.
    """
    match = re.fullmatch(r"\s*(?P<expression>.*?)\s*(\[(?P<unit>[^\[\]]+)\])?\s*", text)
    if match is None or not match["expression"]:
        raise ValueError('this is not an expression; write for instance "observer.e1d - plant.e1d [pu]"')
    try:
        tree = ast.parse(KEY.sub(r"\1", match["expression"]), mode="eval").body
    except SyntaxError as error:
        raise ValueError(f"this is not an expression: {error.msg}") from error
    return Expression(text, match["expression"], match["unit"], tree, frozenset(names_in(tree)))


def names_in(node: ast.expr) -> set[str]:
    """The variables of an expression. Raises ValueError for anything that is not arithmetic."""
    match node:
        case ast.Constant(value=int() | float()):
            return set()
        case ast.Name(id=name) if name in CONSTANTS:
            return set()
        case ast.Name() | ast.Attribute(value=ast.Name() | ast.Attribute()):
            return {ast.unparse(node)}
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return names_in(operand)
        case ast.BinOp(op=op) if type(op) in OPERATORS:
            return names_in(node.left) | names_in(node.right)
        case ast.Call(func=ast.Name(id=name), args=arguments, keywords=[]) if name in FUNCTIONS:
            return set().union(*map(names_in, arguments))
    raise ValueError(
        f'"{ast.unparse(node)}" is not allowed in an expression; it is made of variables, numbers, '
        f"+ - * / ** ( ), {', '.join(CONSTANTS)}, {', '.join(FUNCTIONS)}"
    )


def evaluate(node: ast.expr, values: Mapping[str, Any]) -> Any:
    match node:
        case ast.Constant():
            return node.value
        case ast.Name(id=name) if name in CONSTANTS:
            return CONSTANTS[name]
        case ast.UnaryOp():
            return -evaluate(node.operand, values)
        case ast.BinOp():
            return OPERATORS[type(node.op)](evaluate(node.left, values), evaluate(node.right, values))
        case ast.Call(func=ast.Name(id=name)):
            return FUNCTIONS[name](*[evaluate(argument, values) for argument in node.args])
    return values[ast.unparse(node)]


def unit_of(node: ast.expr, units: Mapping[str, str]) -> str | None:
    """The unit of an expression where it follows from those of its variables, else None.

    Raises ValueError for the sum of two units.
    """
    match node:
        case ast.Name() | ast.Attribute():
            return units.get(ast.unparse(node))
        case ast.UnaryOp():
            return unit_of(node.operand, units)
        case ast.Call(func=ast.Name(id="abs")):
            return unit_of(node.args[0], units)
        case ast.BinOp(op=ast.Add() | ast.Sub()):
            found = {unit_of(side, units) for side in (node.left, node.right) if names_in(side)}
            if len(found - {None}) > 1:
                both = " and ".join(sorted(unit for unit in found if unit))
                raise ValueError(f'"{ast.unparse(node)}" adds {both}; convert one of them')
            return found.pop() if len(found) == 1 else None
    return None
