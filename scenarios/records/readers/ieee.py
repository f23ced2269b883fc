"""CSV of the IEEE/ISO-NE test case library: rows of labels, of types and of units before the data.

    Time,Sub:1:Ln:2:VM,...      labels
    T,VM,VA,IM,IA,F             types
    sec,KV,DEG,AMP,DEG,HZ       units; kV is phase to ground

Zeros are dropouts. Some files state the base time in a line before.
S. Maslennikov et al., "A test cases library for methods locating the sources of sustained oscillations", 2016.
"""

import re
from pathlib import Path

from . import delimited, wide
from .table import Hints

TYPES = {"T", "F", "VM", "VA", "IM", "IA", "P", "Q", "DF", "FREQ", "ROCOF", "S", "D"}
BASE_TIME = re.compile(r"\d{4}[-/]\d{1,2}[-/]\d{1,2}[T ]\d{1,2}:\d{2}:\d{2}([.,]\d+)?")


class IeeeTable(wide.WideTable):
    def __init__(self, path: Path, form: delimited.Form):
        super().__init__(path, form)
        types, units = form.header[1:3]
        self.units = {name: wide.bare(unit) for name, unit in zip(self.names, units, strict=True) if unit}
        kinds = dict(zip(self.names, (kind.upper() for kind in types), strict=True))
        time: dict[str, object] = {"column": next((n for n, k in kinds.items() if k == "T"), self.names[0])}
        time["format"] = "seconds"
        base = BASE_TIME.search(" ".join(form.preamble))
        if base:
            time["start"] = base[0].replace("/", "-").replace(" ", "T") + "Z"
        self.hints = Hints(time=time, types=kinds)


def recognises(path: Path, form: delimited.Form | None) -> bool:
    return form is not None and len(form.header) >= 3 and {cell.upper() for cell in form.header[1] if cell} <= TYPES


def open_table(path: Path, form: delimited.Form) -> IeeeTable:
    return IeeeTable(path, form)
