"""Reading a scenario file, and saying what is wrong with it in its own words."""

import tomllib
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from .errors import ScenarioError, alternatives
from .scenario import Change, Csv, Expect, Figure, Fmu, Panel, Scenario

FOLDER = Path(__file__).parent


def names() -> list[str]:
    """The scenarios of this folder."""
    return sorted(path.stem for path in FOLDER.glob("*.toml"))


def load(name: str) -> Scenario:
    """The scenario of that name in this folder, or in the TOML file at that path. Raises ScenarioError."""
    path = Path(name) if name.endswith(".toml") else FOLDER / f"{name}.toml"
    if not path.is_file():
        raise ScenarioError(f'there is no scenario "{name}"; {alternatives(name, names())}')
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8"))
        return Scenario(**{**content, "name": path.stem, "folder": path.parent})
    except tomllib.TOMLDecodeError as error:
        raise ScenarioError(f"{path.name} is not TOML: {error}") from error
    except ValidationError as error:
        raise ScenarioError("\n".join(f"{path.name}: {explain(detail)}" for detail in error.errors())) from error


def explain(detail: Any) -> str:
    """One finding of pydantic in the words of a scenario file."""
    place, given = detail["loc"], detail["input"]
    where = ".".join(map(str, place))
    match detail["type"]:
        case "missing":
            return f"{where} is missing; add it"
        case "extra_forbidden":
            return f"{where} is not known; {alternatives(str(place[-1]), known_keys(place[:-1]))}"
        case "value_error" if not place:
            return str(detail["ctx"]["error"])
        case "value_error" if isinstance(given, dict):
            return f"{where}: {detail['ctx']['error']}"
        case "value_error":
            return f"{where} = {given!r}: {detail['ctx']['error']}"
    return f"{where} = {given!r}: {detail['msg'].lower()}"


def known_keys(place: tuple) -> list[str]:
    """The keys of the table at a place in a scenario file."""
    tables = {"fmu": Fmu, "csv": Csv, "change": Change, "figure": Figure, "panel": Panel, "expect": Expect}
    inside = [tables[part] for part in place if part in tables]
    if inside:
        return list(inside[-1].model_fields)
    return [key for key in Scenario.model_fields if key not in ("name", "folder")]
