"""Builds the FMUs: python build_fmu.py [--native | --ssp] [--only NAME] [--out DIR]"""

import argparse
import importlib
import pkgutil
import sys
from pathlib import Path
from typing import Callable

from fmu_src import models
from fmu_src.runtime import readme, ssp
from fmu_src.runtime.model import Model
from fmu_src.runtime.python import build as python_fmu
from fmu_src.systems.smib import SYSTEM

OUT = Path("dist")
ROOT = Path(__file__).parent
INTERFACES = ROOT / "fmu_src" / "models" / "README.md"


def all_models() -> dict[str, tuple[str, Model]]:
    """Every model by its name, with the module of `fmu_src/models` that declares it."""
    modules = [module.name for module in pkgutil.iter_modules(models.__path__)]
    declared = {module: importlib.import_module(f"fmu_src.models.{module}").MODEL for module in modules}
    return {model.name: (module, model) for module, model in declared.items()}


def native_names() -> list[str]:
    """The models that become native FMUs: those whose equations need nothing but the carriers."""
    return [name for name, (_, model) in all_models().items() if not model.requirements]


def build(name: str, out: Path = OUT) -> Path:
    """Build `out/python/<name>.fmu` if it is missing or stale; return its path. Raises KeyError for an unknown name."""
    module, model = all_models()[name]
    path = Path(out) / "python" / f"{name}.fmu"
    python_fmu.build(model, module, path)
    return path


def build_native(name: str, out: Path = OUT, say: Callable[[str], None] = lambda message: None) -> Path:
    """The same for `out/native/<name>.fmu`; `say` is told what is being done. Needs the extra `native`."""
    from fmu_src.runtime.native import build as native_fmu

    path = Path(out) / "native" / f"{name}.fmu"
    native_fmu.build(all_models()[name][1], path, say)
    return path


def build_ssp(out: Path = OUT, say: Callable[[str], None] = lambda message: None) -> Path:
    """Build `out/smib.ssp` and the native FMUs in it, where they are missing or stale; return its path."""
    fmus = {name: build_native(model.name, out, say) for name, model in SYSTEM.components.items()}
    path = Path(out) / f"{SYSTEM.name}.ssp"
    ssp.build(SYSTEM, fmus, path)
    return path


def report(path: Path) -> None:
    say(f"{path}  {path.stat().st_size / 1000:.0f} kB")


def say(message: str) -> None:
    print(message, flush=True)


def main() -> int:
    names = list(all_models())
    parser = argparse.ArgumentParser(
        description="Build the FMI 2.0 co-simulation FMUs of this project.",
        epilog="Example: python build_fmu.py --only PmuObserver --out dist. The same sources give the same bytes.",
    )
    parser.add_argument("--only", metavar="NAME", choices=names, help=f"build one FMU: {', '.join(names)}")
    parser.add_argument("--out", metavar="DIR", type=Path, default=OUT, help="where to write (default: %(default)s)")
    parser.add_argument("--native", action="store_true", help="build those without Python inside (extra: native)")
    parser.add_argument("--ssp", action="store_true", help=f"build {SYSTEM.name}.ssp of native FMUs: a system to run")
    parser.add_argument(
        "--readme", action="store_true", help="write the interface tables into fmu_src/models/README.md instead"
    )
    arguments = parser.parse_args()
    if arguments.readme:
        changed = readme.update(INTERFACES, [model for _, model in all_models().values()])
        print(f"{INTERFACES.relative_to(ROOT)}  {'updated' if changed else 'is up to date'}")
        return 0
    try:
        if arguments.ssp:
            report(build_ssp(arguments.out, say))
            return 0
        for name in [arguments.only] if arguments.only else names:
            if not arguments.native:
                report(build(name, arguments.out))
            elif name in native_names():
                report(build_native(name, arguments.out, say))
            else:
                say(f"{name}: no native FMU, because its equations need more than the standard library")
    except ModuleNotFoundError as missing:
        parser.error(f"{missing.name} is not installed, which native FMUs are built with: pip install '.[native]'")
    return 0


if __name__ == "__main__":
    sys.exit(main())
