"""What is generated in the README: blocks between markers, and the interface tables among them."""

import re
from pathlib import Path
from typing import Dict, List

from ..pmu_observer.interface import Boolean, Enumeration, Integer, Real, describe
from .model import Model
from .ports import Port, ports


def interface_table(model: Model) -> str:
    """A Markdown table of the model's variables: name, kind, start, unit or range, meaning."""
    rows = ["| variable | causality | start | unit, range | meaning |", "|---|---|---|---|---|"]
    rows += [row(group) for group in alike(ports(model))]
    return "\n".join(rows)


def alike(found: List[Port]) -> List[List[Port]]:
    """Variables that differ in a number in their name only, `G1.V_t` to `G10.V_t`, together."""
    groups: Dict[tuple, List[Port]] = {}
    for port in found:
        name, *rest = port.variable
        groups.setdefault((re.sub(r"\d+", "", name), *rest, *port[1:]), []).append(port)
    return list(groups.values())


def row(group: List[Port]) -> str:
    names, *others = cells(group)
    code = "`" + names.replace(" ... ", "` ... `") + "`"
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in (code, *others)) + " |"


def cells(group: List[Port]) -> List[str]:
    """What a table says of variables that are alike: names, causality, start, unit or range, meaning."""
    (name, specification, start), causality, variability = group[0]
    names = name if len(group) == 1 else f"{name} ... {group[-1].variable.name}"
    tunable = " (tunable)" if variability == "tunable" else ""
    shown = "" if causality == "output" else start_value(specification, start)
    return [names, causality + tunable, shown, allowed(specification), specification.description]


def start_value(specification, start) -> str:
    if isinstance(specification, Enumeration):
        return specification.items[int(start) - 1]
    if isinstance(specification, Boolean):
        return "true" if start else "false"
    return f"{start:.6g}"


def allowed(specification) -> str:
    if isinstance(specification, Real) and specification.min is None and specification.max is None:
        return specification.unit
    if isinstance(specification, (Integer, Boolean)):
        return type(specification).__name__
    return describe(specification)


def update(path: Path, models: List[Model]) -> bool:
    """Write the interface tables; returns whether the file changed. ValueError without their markers."""
    changed = [write(path, f"interface of {model.name}", interface_table(model)) for model in models]
    return any(changed)


def write(path: Path, block: str, text: str) -> bool:
    """Put a text between the file's markers of that name; returns whether it changed. ValueError without markers."""
    begin, end = f"<!-- {block}: begin -->\n", f"<!-- {block}: end -->"
    before = path.read_text(encoding="utf-8")
    head, _, rest = before.partition(begin)
    if end not in rest:
        raise ValueError(f"{path} has no markers {begin}{end}")
    after = f"{head}{begin}{text}\n{rest[rest.index(end) :]}"
    if after != before:
        path.write_text(after, encoding="utf-8")
    return after != before
