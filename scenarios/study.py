"""One scenario from its file to its results folder."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import build_fmu

from . import figures, master, report
from .component import Component
from .errors import ScenarioError, alternatives
from .expectations import Verdict, judge
from .fmu import Fmu
from .master import Results
from .plan import Plan
from .record import Record
from .scenario import Scenario
from .wiring import wire


@contextmanager
def prepared(scenario: Scenario) -> Iterator[Plan]:
    """The plan of a scenario, with its FMUs built where they are missing or stale, and unpacked meanwhile."""
    with TemporaryDirectory() as folder:
        components: dict[str, Component] = {}
        unpacked: dict[str, Fmu] = {}
        for name, fmu in scenario.fmu.items():
            if fmu.model not in unpacked:
                unpacked[fmu.model] = Fmu(built(f"fmu.{name}", fmu.model), Path(folder) / fmu.model)
            components[name] = unpacked[fmu.model]
        for name, csv in scenario.csv.items():
            components[name] = Record(name, csv, scenario.folder)
        yield wire(scenario, components)


def built(where: str, model: str) -> Path:
    models = list(build_fmu.all_models())
    if model not in models:
        raise ScenarioError(f'{where}: there is no model "{model}"; {alternatives(model, models)}')
    return build_once(model)


@cache
def build_once(model: str) -> Path:
    return build_fmu.build(model).resolve()


def run(
    scenario: Scenario, folder: Path, progress: Callable[[float], None] = lambda done: None
) -> tuple[Results, list[Verdict]]:
    """Co-simulate a scenario and write CSV, figures and summary into `folder`. Raises ScenarioError."""
    with prepared(scenario) as plan:
        results = master.run(plan, progress)
        verdicts = judge(results)
    folder.mkdir(parents=True, exist_ok=True)
    report.write_csv(results, folder / f"{scenario.name}.csv")
    report.write_summary(results, verdicts, folder / "summary.json")
    for figure in scenario.figure:
        figures.draw(results, figure, folder / f"{figure.name}.png")
    return results, verdicts
