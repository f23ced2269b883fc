"""A CasADi function as C: one operation a line, and branches around what only one side of a condition needs.

CasADi's own generator computes both sides of every `where` and `cond`. Here what only one side needs is inside an `if`,
as it is for the Python FMU, where that saves enough work to be worth one.
"""

import re
from collections import Counter, defaultdict
from heapq import heappop, heappush
from itertools import count, permutations
from math import isnan
from re import findall, sub
from textwrap import wrap
from typing import Any, Callable, Dict, Iterable, List, NamedTuple, Optional, Set, Tuple

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
WEIGHTS = {**dict.fromkeys(FUNCTIONS, 20), casadi.OP_CALL: 1000}
WORTH_A_BRANCH = 20
"""Operations that a function or a loop counts for, and operations that an `if` has to save."""


class Loop(NamedTuple):
    """A call that `symbols.map` or `symbols.fold` has made: `body` of each of `items` in turn."""

    number: int  # the instruction that calls it
    body: casadi.Function
    items: int
    size: int  # numbers of an item
    carry: int  # numbers that go from one item to the next; 0: each for itself
    results: int

    def place(self, i: int) -> int:
        """Of result number i in the C array, where those of one item are `items` apart."""
        each = self.results // self.items
        return i if self.carry else i % each * self.items + i // each

    def __hash__(self):
        return hash(self.number)

    def __eq__(self, other):
        return isinstance(other, Loop) and self.number == other.number


def loop_of(f: casadi.Function, number: int) -> Loop:
    body = f.get_function("body")
    carry = body.numel_in(0) if f.name() == "fold" else 0
    size = body.numel_in(1 if carry else 0)
    return Loop(number, body, f.numel_in(1 if carry else 0) // size, size, carry, f.numel_out(0))


Context = Tuple[Tuple[int, bool], ...]
"""Where a node is needed: inside of these conditions, from the outermost, each of which does or does not hold."""


CALL, RESULT = casadi.OP_CALL, -1
"""A loop over the items of a bank (see `loops`), and one of the numbers it gives."""


class Node(NamedTuple):
    operation: int
    arguments: Tuple[int, ...]  # as indices into the list of nodes
    text: str  # of an input, a constant or a result; empty for an operation
    loop: Optional[Loop] = None  # of a call


class Statement(NamedTuple):
    context: Context
    node: int  # the one it sets
    text: str
    needs: Tuple[int, ...]  # nodes that are set before


class Line(NamedTuple):
    block: Tuple[int, ...]  # numbers of the `if`s around it, from the outermost
    text: str
    statement: Optional[Statement] = None


def c_function(name: str, f: casadi.Function, library: Dict[str, str]) -> str:
    """A static function of the inputs of `f`, then its outputs: all are arrays, but `t` and `h`.

    The loops it calls are added to `library`: their text, and their name by it. Raises ValueError if a constant in it
    is NaN, as `math.sin` of a symbol is.
    """
    nodes, results = read(name, f, lambda array, i: array if array in SCALARS else f"{array}[{i}]")
    for node in nodes:
        if node.loop:
            loop_function(node.loop, library)
    places, settled = contexts(nodes, list(results.values()))
    chosen = Choices(nodes, results, places, settled)
    made = [s for s in statements(nodes, places, settled, library) if s.node not in chosen.silent]
    lines = schedule(made, nodes)
    arguments = [f"double {a}" if a in SCALARS else f"const double *{a}" for a in f.name_in()]
    arguments += [f"double *restrict {a}" for a in f.name_out()]
    arrays = [f"    double r{n}[{nodes[n].loop.results}];" for n in sorted(places) if nodes[n].loop]  # type: ignore
    plain = [target for target in results if target not in chosen.targets]
    last = [*copies(plain, [operand(nodes, results[target]) for target in plain]), *chosen.lines()]
    body = [*arrays, *written(lines, nodes, [*results.values(), *chosen.conditions]), *["    " + line for line in last]]
    unused = set(f.name_in()) - set(findall(r"\w+", "\n".join(body)))
    body[:0] = [f"    (void){a};" for a in f.name_in() if a in unused]  # else compilers warn
    return compact("\n".join([f"static void {name}({', '.join(arguments)}) {{", *body, "}", ""]))


def compact(code: str) -> str:
    """With tabs, and variables counted from 0 in the order in which they come: a tenth less in the FMU."""
    numbers: Dict[str, int] = {}
    code = sub(r"\ba(\d+)\b", lambda found: f"a{numbers.setdefault(found[1], len(numbers))}", code)
    return code.replace("    ", "\t")


SCALARS = ("t", "h")


class Choices:
    """Results that are chosen by the same conditions, as many of a bank's are: `if`s around copies of arrays.

    `silent` are the selects that need no statements of their own then.
    """

    def __init__(self, nodes: List[Node], results: Dict[str, int], places: Iterable[int], settled: Dict[int, int]):
        self.nodes, self.settled = nodes, settled
        users: Dict[int, int] = Counter(argument for n in places for argument in nodes[n].arguments)
        users.update(results.values())
        self.single = {n for n, count in users.items() if count == 1}
        groups: Dict[Any, List[str]] = defaultdict(list)
        for target, n in results.items():
            if self.is_choice(n):
                groups[self.shape(n)].append(target)
        self.groups = {shape: targets for shape, targets in groups.items() if len(targets) >= LEAST_GROUP}
        self.results = results
        self.targets = {target for targets in self.groups.values() for target in targets}
        self.silent: Set[int] = set()
        self.conditions: Set[int] = set()
        for target in self.targets:
            self.silence(results[target])

    def is_choice(self, n: int) -> bool:
        return self.nodes[n].operation == SELECT and n in self.single

    def sides(self, n: int) -> List[int]:
        return [self.settled[n]] if n in self.settled else list(self.nodes[n].arguments[1:])

    def shape(self, n: int):
        """The conditions, nested as they are, down to what is chosen from: the elements of which array, or others."""
        if not self.is_choice(n):
            found = ELEMENT.fullmatch(operand(self.nodes, n))
            return found[1] if found else ""
        return (self.nodes[n].arguments[0], n in self.settled, *[self.shape(side) for side in self.sides(n)])

    def silence(self, n: int) -> None:
        if self.is_choice(n):
            self.silent.add(n)
            if n not in self.settled:
                self.conditions.add(self.nodes[n].arguments[0])
            for side in self.sides(n):
                self.silence(side)
        else:
            self.conditions.add(n)

    def lines(self) -> List[str]:
        found = []
        for targets in self.groups.values():
            found += self.copied(targets, [self.results[target] for target in targets])
        return found

    def copied(self, targets: List[str], chosen: List[int]) -> List[str]:
        if not self.is_choice(chosen[0]):
            return copies(targets, [operand(self.nodes, n) for n in chosen])
        sides = list(zip(*[self.sides(n) for n in chosen]))
        if len(sides) == 1:
            return self.copied(targets, list(sides[0]))
        then, otherwise = [["    " + line for line in self.copied(targets, list(side))] for side in sides]
        condition = operand(self.nodes, self.nodes[chosen[0]].arguments[0])
        return [f"if ({condition}) {{", *then, "} else {", *otherwise, "}"]


LEAST_GROUP = 16
"""Results that are worth a choice of their own."""


def loop_function(loop: Loop, library: Dict[str, str]) -> str:
    """The name of the C function that runs the loop; its text is added to the library, once."""
    N, inside = loop.items, {"i0": "x", "i1": "s"} if loop.carry == 0 else {"i0": "c", "i1": "x", "i2": "s"}

    def named(array: str, i: int) -> str:
        kind = inside[array]
        return f"c{i}" if kind == "c" else f"x[{N * i} + k]" if kind == "x" else f"s[{i}]"

    nodes, results = read("a loop", loop.body, named)
    everywhere = dict.fromkeys(reachable(nodes, list(results.values())), ())
    lines = schedule(statements(nodes, everywhere, {}, library), nodes)
    calculated = ["    " + line for line in written(lines, nodes, ())]
    values = [operand(nodes, n) for n in results.values()]
    if loop.carry:
        begin = [f"    double {', '.join(f'c{i} = c[{i}]' for i in range(loop.carry))};"]
        finish = [f"        const double n{i} = {value};" for i, value in enumerate(values)]
        finish += [f"        c{i} = n{i};" for i in range(loop.carry)]
        end = [f"    r[{i}] = c{i};" for i in range(loop.carry)]
        carried = "const double *restrict c, "
    else:
        begin, finish, end, carried = [], [f"        r[{N * i} + k] = {v};" for i, v in enumerate(values)], [], ""
    header = f"({carried}const double *restrict x, const double *restrict s, double *restrict r) {{"
    loop_line = f"    for (int k = 0; k < {N}; k++) {{"
    text = "\n".join([header, "    (void)s;", *begin, loop_line, *calculated, *finish, "    }", *end, "}", ""])
    return library.setdefault(compact(text), f"loop{len(library)}")


def reachable(nodes: List[Node], results: List[int]) -> List[int]:
    found = set(results)
    for n in reversed(range(len(nodes))):
        if n in found:
            found.update(nodes[n].arguments)
    return sorted(found)


def call(nodes: List[Node], n: int, library: Dict[str, str]) -> List[str]:
    """The lines that lay out the arguments of a loop as arrays, an item's numbers N apart, and run it."""
    loop: Loop = nodes[n].loop  # type: ignore
    values = [operand(nodes, argument) for argument in nodes[n].arguments]
    size, N = loop.size, loop.items
    carried, rest = values[: loop.carry], values[loop.carry :]
    items = [rest[k * size + j] for j in range(size) for k in range(N)]
    lines, given = [], []
    for name, texts in (("c", carried), ("x", items), ("s", rest[size * N :])):
        if name == "c" and not loop.carry:
            continue
        start = in_a_row(texts)
        given.append(start or name)
        if not start:
            lines += [
                f"double {name}[{max(len(texts), 1)}];",
                *copies([f"{name}[{i}]" for i in range(len(texts))], texts),
            ]
    return [
        "{",
        *["    " + line for line in lines],
        f"    {loop_function(loop, library)}({', '.join(given)}, r{n});",
        "}",
    ]


ELEMENT = re.compile(r"([a-z_]\w*)\[(\d+)\]")


def in_a_row(texts: List[str]) -> str:
    """The address of the first, if they are neighbours in one array; else nothing."""
    found = [ELEMENT.fullmatch(text) for text in texts]
    if not found or not all(found):
        return ""
    array, first = found[0][1], int(found[0][2])  # type: ignore
    row = [f"{array}[{first + i}]" for i in range(len(texts))]
    return f"{array} + {first}" if row == texts else ""


def copies(targets: List[str], values: List[str]) -> List[str]:
    """Assignments, as a loop where array elements at a constant distance are copied."""
    lines, i = [], 0
    while i < len(targets):
        length, step_to, step_from = run(targets, values, i)
        if length >= SHORTEST_LOOP:
            (to, a), (of, b) = [ELEMENT.fullmatch(text).groups() for text in (targets[i], values[i])]  # type: ignore
            head = f"for (int i = 0; i < {length}; i++)"
            lines.append(f"{head} {to}[{a} + {step_to} * i] = {of}[{b} + {step_from} * i];")
        else:
            length = 1
            lines.append(f"{targets[i]} = {values[i]};")
        i += length
    return lines


SHORTEST_LOOP = 4


def run(targets: List[str], values: List[str], i: int) -> Tuple[int, int, int]:
    """How many copies from number i on are between elements at constant distances, and these."""
    length, steps, last = 1, None, None
    for target, value in zip(targets[i:], values[i:]):
        to, of = ELEMENT.fullmatch(target), ELEMENT.fullmatch(value)
        if not to or not of:
            break
        now = to[1], int(to[2]), of[1], int(of[2])
        if last:
            step = now[1] - last[1], now[3] - last[3]
            if (now[0], now[2]) != (last[0], last[2]) or step != (steps or step):
                break
            steps, length = step, length + 1
        last = now
    return (length, *steps) if steps else (1, 1, 1)


def read(name: str, f: casadi.Function, named: Callable[[str, int], str]) -> Tuple[List[Node], Dict[str, int]]:
    """The nodes, equal ones once, each after its arguments; and the node of every result.

    Of a `cond` whose condition is a constant (at the start, no frame has come yet) one side is left.
    """
    nodes: List[Node] = []
    known: Dict[Node, int] = {}

    def add(operation, *arguments, text="", loop=None):
        node = Node(operation, arguments, text, loop)
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
    written_out = f.instructions_sx() if name_of_calls(f) else None
    for k in range(f.n_instructions()):
        operation, source, target = f.instruction_id(k), f.instruction_input(k), f.instruction_output(k)
        if operation == casadi.OP_OUTPUT:
            results[f"{f.name_out(target[0])}[{target[1]}]"] = registers[source[0]]
        elif operation == casadi.OP_INPUT:
            registers[target[0]] = add(operation, text=named(f.name_in(source[0]), source[1]))
        elif operation == casadi.OP_CONST:
            value = f.instruction_constant(k)
            if isnan(value):
                raise ValueError(f"{name} has a NaN in it: take every function from the carrier, and no `math.sin`")
            registers[target[0]] = add(operation, text=number(value))
        elif operation == CALL:
            loop = loop_of(written_out[k].which_function(), k)  # type: ignore
            n = add(CALL, *[registers[i] for i in source], loop=loop)
            for i, register in enumerate(target):
                if register >= 0:
                    registers[register] = add(RESULT, n, text=f"r{n}[{loop.place(i)}]")
        else:
            arguments = [registers[i] for i in source]
            if operation == casadi.OP_ADD:
                registers[target[0]] = plus(arguments[0], arguments[1])
            elif operation == casadi.OP_IF_ELSE_ZERO:
                registers[target[0]] = select(arguments[0], arguments[1], zero)
            else:
                registers[target[0]] = add(operation, *arguments)
    return nodes, results


def name_of_calls(f: casadi.Function) -> List[str]:
    return list(f.get_function())


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
        weight = 0 if nodes[n].text else WEIGHTS.get(nodes[n].operation, 1)
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


def statements(
    nodes: List[Node], places: Dict[int, Context], settled: Dict[int, int], library: Dict[str, str]
) -> List[Statement]:
    """What computes the nodes: one statement each, or two for a select around whose sides there is an `if`."""

    def source(n: int) -> int:
        return nodes[n].arguments[0] if nodes[n].operation == RESULT else n

    inside = {context[:k] for context in places.values() for k in range(1, 1 + len(context))}
    made = []
    for n in sorted(places):
        operation, arguments, text, loop = nodes[n]
        here = places[n]
        if text:
            continue
        if loop:
            made.append(Statement(here, n, "\n".join(call(nodes, n, library)), arguments))
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
    needs = [[source(n) for n in (*s.needs, *(c for c, _ in s.context))] for s in made]
    return [s._replace(needs=tuple(n for n in of if n in operations)) for s, of in zip(made, needs)]


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
    numbers = [f"a{n}" for n in sorted(outside) if n in blocks and not nodes[n].loop]
    declared = f"double {', '.join(numbers)};" if numbers else ""
    text = wrap(declared, 120, initial_indent=" " * 4, subsequent_indent=" " * 8)
    for block, words, statement in lines:
        if statement and nodes[statement.node].loop:
            text += ["    " * (1 + len(block)) + line for line in words.split("\n")]
            continue
        if statement:
            n = statement.node
            # not const: clang would try to evaluate each through all those before it, which takes a minute
            kind = "int " if nodes[n].operation in TRUTHS else "double "
            words = f"{'' if n in outside else kind}a{n} = {words};"
        text.append("    " * (1 + len(block)) + words)
    return text
