"""What a run tells: the result table, and the CSV and the JSON summary in its folder."""

import json
from pathlib import Path
from typing import Any

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Column, Table

from .expectations import Verdict
from .master import Results
from .plan import Signal, sweep_text

PLAIN: dict[str, Any] = {"box": SIMPLE_HEAD, "show_edge": False, "pad_edge": False}
"""The style of the tables: five columns of numbers fit into 100 characters."""


def errors_at(results: Results) -> list[tuple[Signal, dict[str, float]]]:
    """Every error, by the times that the scenario's table shows."""
    scenario = results.plan.scenario
    times = scenario.at or [scenario.stop]
    signals = [signal for name in scenario.error for signal in results.plan.signals[name]]
    return [(s, {f"{float(t):g}": float(results.of(s)[scenario.index(t)]) for t in times}) for s in signals]


def print_tables(console: Console, results: Results, verdicts: list[Verdict]) -> None:
    rows = errors_at(results)
    if rows:
        table = Table(Column("error", no_wrap=True), Column("of", overflow="fold"), **PLAIN)
        for time in rows[0][1]:
            table.add_column(f"at {time} s", justify="right", no_wrap=True)
        for signal, values in rows:
            table.add_row(
                signal.name + in_unit(", ", signal.unit),
                sweep_text(signal.sweep),
                *[f"{value:.2g}" for value in values.values()],
            )
        console.print(table, "", highlight=False)
    if verdicts:
        table = Table(Column("expected of", overflow="fold"), Column(overflow="fold"), **PLAIN)
        table.add_column("when", no_wrap=True)
        table.add_column("value", no_wrap=True)
        table.add_column("measured", justify="right", no_wrap=True)
        table.add_column("")
        for v in verdicts:
            mark = "[green]holds[/]" if v.holds else "[bold red]FAILS[/]"
            measured = f"{v.measured:.4g}{in_unit(' ', v.unit)}"
            table.add_row(v.name, sweep_text(v.each), v.when, v.wanted, measured, mark)
        console.print(table, "", highlight=False)


def in_unit(separator: str, unit: str) -> str:
    return "" if unit == "1" else separator + unit


def write_csv(results: Results, path: Path) -> None:
    """All that was watched: the time, the variables of every instance, and the errors; units in the first line."""
    columns = {("time", "s"): results.time}
    for instance, values in results.values.items():
        variables = results.plan.components[instance.component].variables
        columns.update({(f"{instance.label}.{name}", variables[name].unit): v for name, v in values.items()})
    for name in results.plan.scenario.error:
        columns.update({(signal.label, signal.unit): results.of(signal) for signal in results.plan.signals[name]})
    with path.open("w", encoding="utf-8") as file:
        file.write("# units: " + ",".join(unit for _, unit in columns) + "\n")
        file.write(",".join(f'"{label}"' for label, _ in columns) + "\n")
        np.savetxt(file, np.column_stack(list(columns.values())), fmt="%.9g", delimiter=",")


def write_summary(results: Results, verdicts: list[Verdict], path: Path) -> None:
    scenario = results.plan.scenario
    summary = {
        "scenario": scenario.name,
        "title": scenario.title,
        "step_s": float(scenario.step),
        "stop_s": float(scenario.stop),
        "wall_time_s": round(results.wall_time, 3),
        "instances": [instance.label for instance in results.plan.instances],
        "errors": [
            {"name": s.name, "each": s.sweep, "unit": s.unit, "at_s": values} for s, values in errors_at(results)
        ],
        "expectations": [verdict._asdict() for verdict in verdicts],
        "holds": all(verdict.holds for verdict in verdicts),
    }
    path.write_text(json.dumps(summary, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
