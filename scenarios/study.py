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

DIST = build_fmu.OUT
RESULTS = Path("results")

KINDS = ("python", "native")


def quiet(message: str) -> None:
    pass


@contextmanager
def prepared(scenario: Scenario, kind: str = "python", say: Callable[[str], None] = quiet) -> Iterator[Plan]:
    """The plan of a scenario, with its FMUs built where they are missing or stale, and unpacked meanwhile.

    `kind` is one of KINDS; `say` is told what native FMUs take time for, and which model has none.
    """
    with TemporaryDirectory() as folder:
        components: dict[str, Component] = {}
        unpacked: dict[str, Fmu] = {}
        for name, fmu in scenario.fmu.items():
            if fmu.model not in unpacked:
                unpacked[fmu.model] = Fmu(built(f"fmu.{name}", fmu.model, kind, say), Path(folder) / fmu.model)
            components[name] = unpacked[fmu.model]
        for name, csv in scenario.csv.items():
            components[name] = Record(name, csv, scenario.folder)
        yield wire(scenario, components)


def built(where: str, model: str, kind: str = "python", say: Callable[[str], None] = quiet) -> Path:
    models = list(build_fmu.all_models())
    if model not in models:
        raise ScenarioError(f'{where}: there is no model "{model}"; {alternatives(model, models)}')
    return build_once(model, kind, say)


@cache
def build_once(model: str, kind: str, say: Callable[[str], None]) -> Path:
    """The FMU of that kind; a model that has no native FMU runs as the Python FMU."""
    if kind == "native" and model in build_fmu.native_names():
        try:
            return build_fmu.build_native(model, DIST, say).resolve()
        except ModuleNotFoundError as missing:
            raise ScenarioError(f"--fmu native needs {missing.name}: pip install '.[native]'") from missing
    if kind == "native":
        say(f"{model}: no native FMU, because its equations need more than the standard library; its Python FMU runs")
    return build_fmu.build(model, DIST).resolve()


def run(
    scenario: Scenario,
    folder: Path,
    progress: Callable[[float], None] = lambda done: None,
    kind: str = "python",
    say: Callable[[str], None] = quiet,
) -> tuple[Results, list[Verdict]]:
    """Co-simulate a scenario and write CSV, figures and summary into `folder`. Raises ScenarioError."""
    with prepared(scenario, kind, say) as plan:
        results = master.run(plan, progress)
    verdicts = judge(results)
    write(results, verdicts, folder)
    return results, verdicts


def write(results: Results, verdicts: list[Verdict], folder: Path) -> None:
    """CSV, figures and summary of a run."""
    scenario = results.plan.scenario
    folder.mkdir(parents=True, exist_ok=True)
    report.write_csv(results, folder / f"{scenario.name}.csv")
    report.write_summary(results, verdicts, folder / "summary.json")
    for figure in scenario.figure:
        figures.draw(results, figure, folder / f"{figure.name}.png")
