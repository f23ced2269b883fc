"""A CasADi function as C: one operation a line, and branches around what only one side of a condition needs.

CasADi's own generator computes both sides of every `where` and `cond`. Here what only one side needs is inside an `if`,
as it is for the Python FMU, where that saves enough work to be worth one.
"""

from collections import Counter, defaultdict
from heapq import heappop, heappush
from itertools import count, permutations
from math import isnan
from re import findall, sub
from textwrap import wrap
from typing import Dict, Iterable, List, NamedTuple, Optional, Tuple

import casadi

OPERATIONS = {
    casadi.OP_ADD: "{} + {}",
    casadi.OP_SUB: "{} - {}",
    casadi.OP_MUL: "{} * {}",
    casadi.OP_DIV: "{} / {}",
    casadi.OP_NEG: "-{}",
    casadi.OP_INV: "1 / {}",
    casadi.OP_SQ: "{0} * {0}",
    casadi.OP_TWICE: "2 * {}",
    casadi.OP_FABS: "fabs({})",
    casadi.OP_SQRT: "sqrt({})",
    casadi.OP_EXP: "exp({})",
    casadi.OP_EXPM1: "expm1({})",
    casadi.OP_LOG: "log({})",
    casadi.OP_SIN: "sin({})",
    casadi.OP_COS: "cos({})",
    casadi.OP_ATAN2: "atan2({}, {})",
    casadi.OP_FLOOR: "floor({})",
    casadi.OP_FMIN: "{0} < {1} ? {0} : {1}",  # as the carrier `floats` has it
    casadi.OP_FMAX: "{0} > {1} ? {0} : {1}",
    casadi.OP_LT: "{} < {}",
    casadi.OP_LE: "{} <= {}",
    casadi.OP_EQ: "{} == {}",
    casadi.OP_NE: "{} != {}",
    casadi.OP_AND: "{} && {}",
    casadi.OP_OR: "{} || {}",
    casadi.OP_NOT: "!{}",
    casadi.OP_IF_ELSE_ZERO: "{} ? {} : {}",
}

TRUTHS = {casadi.OP_LT, casadi.OP_LE, casadi.OP_EQ, casadi.OP_NE, casadi.OP_AND, casadi.OP_OR, casadi.OP_NOT}

SELECT = casadi.OP_IF_ELSE_ZERO
"""condition ? then : otherwise. CasADi has (c ? x : 0) + (!c ? y : 0) for it."""

FUNCTIONS = {casadi.OP_EXP, casadi.OP_EXPM1, casadi.OP_LOG, casadi.OP_SIN, casadi.OP_COS, casadi.OP_ATAN2}
FUNCTION_WEIGHT, WORTH_A_BRANCH = 20, 20
"""Operations that one of the FUNCTIONS counts for, and operations that an `if` has to save."""

Context = Tuple[Tuple[int, bool], ...]
"""Where a node is needed: inside of these conditions, from the outermost, each of which does or does not hold."""


class Node(NamedTuple):
    operation: int
    arguments: Tuple[int, ...]  # as indices into the list of nodes
    text: str  # of an input or a constant; empty for an operation


class Statement(NamedTuple):
    context: Context
    node: int  # the one it sets
    text: str
    needs: Tuple[int, ...]  # nodes that are set before


class Line(NamedTuple):
    block: Tuple[int, ...]  # numbers of the `if`s around it, from the outermost
    text: str
    statement: Optional[Statement] = None


def c_function(name: str, f: casadi.Function) -> str:
    """A static function of the inputs of `f`, then its outputs: all are arrays, but `t` and `h`.

    Raises ValueError if a constant in it is NaN, as `math.sin` of a symbol is.
    """
    nodes, results = read(name, f)
    places, settled = contexts(nodes, list(results.values()))
    lines = schedule(statements(nodes, places, settled), nodes)
    arguments = [f"double {a}" if a in SCALARS else f"const double *{a}" for a in f.name_in()]
    arguments += [f"double *restrict {a}" for a in f.name_out()]
    body = written(lines, nodes, results.values()) + [
        f"    {result} = {operand(nodes, n)};" for result, n in results.items()
    ]
    unused = set(f.name_in()) - set(findall(r"\w+", "\n".join(body)))
    body[:0] = [f"    (void){a};" for a in f.name_in() if a in unused]  # else compilers warn
    return compact("\n".join([f"static void {name}({', '.join(arguments)}) {{", *body, "}", ""]))


def compact(code: str) -> str:
    """With tabs, and variables counted from 0 in the order in which they come: a tenth less in the FMU."""
    numbers: Dict[str, int] = {}
    code = sub(r"\ba(\d+)\b", lambda found: f"a{numbers.setdefault(found[1], len(numbers))}", code)
    return code.replace("    ", "\t")


SCALARS = ("t", "h")


def read(name: str, f: casadi.Function) -> Tuple[List[Node], Dict[str, int]]:
    """The nodes, equal ones once, each after its arguments; and the node of every result.

    Of a `cond` whose condition is a constant (at the start, no frame has come yet) one side is left.
    """
    nodes: List[Node] = []
    known: Dict[Node, int] = {}

    def add(operation, *arguments, text=""):
        node = Node(operation, arguments, text)
        if node not in known:
            known[node] = len(nodes)
            nodes.append(node)
        return known[node]

    zero, one = (add(casadi.OP_CONST, text=text) for text in ("0.0", "1.0"))

    def select(condition, then, otherwise):
        if nodes[condition].operation == casadi.OP_NOT:
            return select(nodes[condition].arguments[0], otherwise, then)
        if condition == zero:
            return select(one, otherwise, then)
        return add(SELECT, condition, then, otherwise)

    def plus(left, right):
        if nodes[left].operation == nodes[right].operation == SELECT:
            for (c, x, no_x), (d, no_y, y) in permutations((nodes[left].arguments, nodes[right].arguments)):
                if c == d and no_x == no_y == zero:
                    return x if c == one else add(SELECT, c, x, y)
        return add(casadi.OP_ADD, left, right)

    registers: Dict[int, int] = {}
    results: Dict[str, int] = {}
    for k in range(f.n_instructions()):
        operation, source, target = f.instruction_id(k), f.instruction_input(k), f.instruction_output(k)
        if operation == casadi.OP_OUTPUT:
            results[f"{f.name_out(target[0])}[{target[1]}]"] = registers[source[0]]
        elif operation == casadi.OP_INPUT:
            array = f.name_in(source[0])
            registers[target[0]] = add(operation, text=array if array in SCALARS else f"{array}[{source[1]}]")
        elif operation == casadi.OP_CONST:
            value = f.instruction_constant(k)
            if isnan(value):
                raise ValueError(f"{name} has a NaN in it: take every function from the carrier, and no `math.sin`")
            registers[target[0]] = add(operation, text=number(value))
        else:
            arguments = [registers[i] for i in source]
            if operation == casadi.OP_ADD:
                registers[target[0]] = plus(arguments[0], arguments[1])
            elif operation == casadi.OP_IF_ELSE_ZERO:
                registers[target[0]] = select(arguments[0], arguments[1], zero)
            else:
                registers[target[0]] = add(operation, *arguments)
    return nodes, results


def number(value: float) -> str:
    """A C constant that reads back as the same number."""
    return repr(float(value)).replace("inf", "INFINITY")


def operand(nodes: List[Node], n: int) -> str:
    return nodes[n].text or f"a{n}"


def contexts(nodes: List[Node], results: List[int]) -> Tuple[Dict[int, Context], Dict[int, int]]:
    """Where each node that is used is computed; and of each select inside of its own condition, the side that holds."""
    found: Dict[int, Context] = dict.fromkeys(results, ())
    settled: Dict[int, int] = {}
    for n in reversed(range(len(nodes))):
        if n not in found:
            continue
        here = found[n]
        uses = [(argument, here) for argument in nodes[n].arguments]
        if nodes[n].operation == SELECT:
            condition, *sides = nodes[n].arguments
            branches = [(condition, True), (condition, False)]
            holding = [side for side, branch in zip(sides, branches) if branch in here]
            uses[1:] = [(side, (*here, branch)) for side, branch in zip(sides, branches)]
            if holding:
                settled[n] = holding[0]
                uses = [(holding[0], here)]
        for argument, context in uses:
            found[argument] = common(found.get(argument, context), context)

    weights: Counter = Counter()
    for n, context in found.items():
        weight = 0 if nodes[n].text else FUNCTION_WEIGHT if nodes[n].operation in FUNCTIONS else 1
        for k in range(1, 1 + len(context)):
            weights[context[:k]] += weight
    for n, context in found.items():
        depth = 0
        while depth < len(context) and weights[context[: depth + 1]] >= WORTH_A_BRANCH:
            depth += 1
        found[n] = context[:depth]
    return found, settled


def common(one: Context, other: Context) -> Context:
    depth = 0
    while depth < min(len(one), len(other)) and one[depth] == other[depth]:
        depth += 1
    return one[:depth]


def statements(nodes: List[Node], places: Dict[int, Context], settled: Dict[int, int]) -> List[Statement]:
    """What computes the nodes: one statement each, or two for a select around whose sides there is an `if`."""
    inside = {context[:k] for context in places.values() for k in range(1, 1 + len(context))}
    made = []
    for n in sorted(places):
        operation, arguments, text = nodes[n]
        here = places[n]
        if text:
            continue
        if n in settled:
            made.append(Statement(here, n, operand(nodes, settled[n]), (settled[n],)))
            continue
        if operation == SELECT:
            branches = [((*here, (arguments[0], holds)), side) for holds, side in zip((True, False), arguments[1:])]
            if any(branch in inside for branch, _ in branches):
                made += [Statement(branch, n, operand(nodes, side), (side,)) for branch, side in branches]
                continue
        words = [operand(nodes, argument) for argument in arguments]
        made.append(Statement(here, n, OPERATIONS[operation].format(*words), arguments))
    operations = {statement.node for statement in made}
    return [s._replace(needs=tuple(n for n in (*s.needs, *(c for c, _ in s.context)) if n in operations)) for s in made]


def schedule(all_statements: List[Statement], nodes: List[Node]) -> List[Line]:
    """The statements in an order in which each follows what it needs: an `if` is begun when nothing is left outside."""
    users, unset = defaultdict(set), Counter(statement.node for statement in all_statements)
    waiting = [len(set(statement.needs)) for statement in all_statements]
    ready: Dict[Context, List[int]] = defaultdict(list)
    for k, statement in enumerate(all_statements):
        for n in statement.needs:
            users[n].add(k)
        if not statement.needs:
            heappush(ready[statement.context], k)
    lines: List[Line] = []
    numbers = count()

    def block(context: Context, around: Tuple[int, ...]) -> None:
        while True:
            while ready[context]:
                statement = all_statements[heappop(ready[context])]
                lines.append(Line(around, statement.text, statement))
                unset[statement.node] -= 1
                for user in users[statement.node] if unset[statement.node] == 0 else ():
                    waiting[user] -= 1
                    if waiting[user] == 0:
                        heappush(ready[all_statements[user].context], user)
            depth = len(context)
            inside = [(queue[0], c[depth][0]) for c, queue in ready.items() if queue and c[:depth] == context]
            if not inside:
                return
            branches(context, min(inside)[1], around)

    def branches(context: Context, condition: int, around: Tuple[int, ...]) -> None:
        lines.append(Line(around, f"if ({operand(nodes, condition)}) {{"))
        block((*context, (condition, True)), (*around, next(numbers)))
        lines.append(Line(around, "} else {"))
        block((*context, (condition, False)), (*around, next(numbers)))
        lines.append(Line(around, "}"))

    block((), ())
    return lines


def written(lines: List[Line], nodes: List[Node], results: Iterable[int]) -> List[str]:
    """The text of the lines; a node is declared where it is set, or at the top if it is seen outside of that block."""
    blocks = {line.statement.node: line.block for line in lines if line.statement}
    outside = {n for n in results if blocks.get(n)}
    for line in lines:
        if line.statement:
            seen = (line.statement.node, *line.statement.needs)
            outside.update(n for n in seen if line.block[: len(blocks[n])] != blocks[n])
    declared = f"double {', '.join(f'a{n}' for n in sorted(outside))};" if outside else ""
    text = wrap(declared, 120, initial_indent=" " * 4, subsequent_indent=" " * 8)
    for block, words, statement in lines:
        if statement:
            n = statement.node
            # not const: clang would try to evaluate each through all those before it, which takes a minute
            kind = "int " if nodes[n].operation in TRUTHS else "double "
            words = f"{'' if n in outside else kind}a{n} = {words};"
        text.append("    " * (1 + len(block)) + words)
    return text
