"""The project's own standard record, as a file to convert: on another base, or at another machine's terminal."""

from pathlib import Path

from .. import standard
from . import delimited, wide
from .table import Hints


class ProjectTable(wide.WideTable):
    def __init__(self, path: Path, form: delimited.Form):
        super().__init__(path, form)
        self.units = {name: unit for name, unit in standard.COLUMNS.items() if name in self.names}
        facts = standard.read_facts(form.preamble, path)
        time = {"column": "t_frame" if "t_frame" in self.names else "time", "format": "seconds"}
        if facts.utc_start:
            time["start"] = facts.utc_start
        self.hints = Hints(time=time, frequency=facts.f0, S_base=facts.S_base)


def recognises(path: Path, form: delimited.Form | None) -> bool:
    return form is not None and set(standard.NEEDED) <= {cell.strip() for cell in form.header[-1]}


def open_table(path: Path, form: delimited.Form) -> ProjectTable:
    return ProjectTable(path, form)
