"""Builds the FMUs: python build_fmu.py [--only NAME] [--out DIR]"""

import argparse
import importlib
import pkgutil
import sys
from pathlib import Path

from fmu_src import models
from fmu_src.runtime import readme
from fmu_src.runtime.model import Model
from fmu_src.runtime.python import build as python_fmu

OUT = Path("dist")
README = Path(__file__).parent / "README.md"


def all_models() -> dict[str, tuple[str, Model]]:
    """Every model by its name, with the module of `fmu_src/models` that declares it."""
    modules = [module.name for module in pkgutil.iter_modules(models.__path__)]
    declared = {module: importlib.import_module(f"fmu_src.models.{module}").MODEL for module in modules}
    return {model.name: (module, model) for module, model in declared.items()}


def build(name: str, out: Path = OUT) -> Path:
    """Build `out/python/<name>.fmu` if it is missing or stale; return its path. Raises KeyError for an unknown name."""
    module, model = all_models()[name]
    path = Path(out) / "python" / f"{name}.fmu"
    python_fmu.build(model, module, path)
    return path


def main() -> int:
    names = list(all_models())
    parser = argparse.ArgumentParser(
        description="Build the FMI 2.0 co-simulation FMUs of this project.",
        epilog="Example: python build_fmu.py --only PmuObserver --out dist. The same sources give the same bytes.",
    )
    parser.add_argument("--only", metavar="NAME", choices=names, help=f"build one FMU: {', '.join(names)}")
    parser.add_argument("--out", metavar="DIR", type=Path, default=OUT, help="where to write (default: %(default)s)")
    parser.add_argument("--readme", action="store_true", help="write the interface tables into README.md instead")
    arguments = parser.parse_args()
    if arguments.readme:
        changed = readme.update(README, [model for _, model in all_models().values()])
        print(f"{README}  {'updated' if changed else 'is up to date'}")
        return 0
    for name in [arguments.only] if arguments.only else names:
        path = build(name, arguments.out)
        print(f"{path}  {path.stat().st_size / 1000:.0f} kB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
