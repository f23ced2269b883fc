"""documentation/index.html, which tools show: what the FMU is, its interface, choices and limits, from its tables."""

from html import escape
from typing import List

from ..pmu_observer.interface import Enumeration
from . import choices
from .model import Model
from .ports import Port, ports
from .readme import alike, cells

STYLE = """
body { font-family: sans-serif; line-height: 1.4; max-width: 70em; margin: 2em auto; padding: 0 1em; color: #222 }
table { border-collapse: collapse }
th, td { border: 1px solid #bbb; padding: .2em .6em; text-align: left; vertical-align: top }
th { background: #eef3f8 } code { background: #f3f3f3; padding: 0 .2em }
"""

KINDS = (
    "There are two kinds of this FMU with the same variables and the same equations. The native kind needs nothing: "
    "take it wherever there is one, and always outside Python.",
    "The Python kind needs Python 3.9 or later in the process, and is for Python hosts. Its loader, pythonfmu's, "
    "decodes only blanks in the path to which the FMU is unpacked, and only the URI form file:///: brackets, +, #, % "
    "or accents in the path, and the forms file:/ and file://localhost/, end the host. C hosts may crash when they "
    "exit. What it refuses it can only log: without debug logging FMPy shows nothing of that.",
    "FMPy takes start values of enumerations by number: --start-values estimator 1.",
)


def index_html(model: Model) -> bytes:
    """The file's bytes, with the figure in it."""
    body = [
        f"<h1>{escape(model.name)}</h1>",
        f"<p><b>{escape(model.description)}.</b> {escape(model.about)}</p>",
        figure(model),
        "<h2>Interface</h2>",
        table(model),
        *choosing(model),
        "<h2>Limits</h2>",
        bullets([*model.limits, f"A communication step is divided into steps of at most {model.max_step:g} s."])
        if model.max_step < float("inf")
        else bullets(list(model.limits)),
        "<h2>Which kind of FMU</h2>",
        bullets(list(KINDS)),
    ]
    head = f'<meta charset="utf-8"><title>{escape(model.name)}</title><style>{STYLE}</style>'
    return (
        '<!DOCTYPE html>\n<html lang="en"><head>' + head + "</head><body>\n" + "\n".join(body) + "\n</body></html>\n"
    ).encode()


def bullets(texts: List[str]) -> str:
    return "<ul>" + "".join(f"<li>{escape(text)}</li>" for text in texts) + "</ul>"


def table(model: Model) -> str:
    head = "".join(f"<th>{title}</th>" for title in ("variable", "causality", "start", "unit, range", "meaning"))
    rows = ["<tr>" + "".join(f"<td>{cell}</td>" for cell in row(group)) + "</tr>" for group in alike(ports(model))]
    return f"<table><tr>{head}</tr>\n" + "\n".join(rows) + "</table>"


def row(group: List[Port]) -> List[str]:
    name, *others = cells(group)
    return [f"<code>{escape(name)}</code>", *map(escape, others)]


def choosing(model: Model) -> List[str]:
    """Every enumeration with its items, and how to choose where enumerations are ignored."""
    found = [p.variable for p in ports(model) if isinstance(p.variable.specification, Enumeration)]
    if not found:
        return []
    lines = [
        f"<li><code>{escape(v.name)}</code>: {escape(v.specification.description)}: "
        + ", ".join(f"{escape(item)} ({n})" for n, item in enumerate(v.specification.items, 1))
        + "</li>"
        for v in found
        if isinstance(v.specification, Enumeration)
    ]
    hint = (
        f"Importers that ignore enumerations (libcosim, ecos) set the Integer of the same name with {choices.SUFFIX}."
    )
    return ["<h2>Choosing</h2>", f"<p>{hint}</p>", "<ul>", *lines, "</ul>"]


def figure(model: Model) -> str:
    """Inputs, the model, outputs: names as they stand in the interface, the first of many that are alike."""
    columns = [names(model, causality) for causality in ("input", "output")]
    height = 40 + 16 * max(map(len, columns))
    lines = [f'<svg width="680" height="{height}" font-family="sans-serif" font-size="12" role="img">']
    lines.append(f"<title>{escape(model.name)}: inputs on the left, outputs on the right</title>")
    lines.append(f'<rect x="190" y="10" width="180" height="{height - 20}" fill="#eef3f8" stroke="#1f4e79"/>')
    lines.append(
        f'<text x="280" y="{height / 2:g}" text-anchor="middle" font-weight="bold">{escape(model.name)}</text>'
    )
    for x, anchor, line, found in ((150, "end", (154, 188), columns[0]), (410, "start", (372, 406), columns[1])):
        for k, name in enumerate(found):
            y = 30 + 16 * k
            lines.append(f'<line x1="{line[0]}" y1="{y - 4}" x2="{line[1]}" y2="{y - 4}" stroke="#1f4e79"/>')
            lines.append(f'<text x="{x}" y="{y}" text-anchor="{anchor}">{escape(name)}</text>')
    return "\n".join([*lines, "</svg>"])


def names(model: Model, causality: str) -> List[str]:
    return [cells(group)[0] for group in alike(ports(model)) if group[0].causality == causality]
