"""Building the Python FMU of a model: pythonfmu's binary, the slave, and the sources that the slave imports.

pythonfmu FMUs share one interpreter and one sys.modules. Everything of an FMU is therefore one package whose name holds
a hash of its content, with relative imports only: two FMUs never see each other's code, nor an installed one.
"""

import json
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Dict

import pythonfmu

from ..companions import companions
from ..model import Model
from ..modeldescription import model_description
from ..package import content_hash, distributed_license, guid_of, license_text, write_fmu

SOURCES = Path(__file__).resolve().parents[2]
PYTHONFMU = Path(pythonfmu.__file__).parent

CAPABILITIES = {"needsExecutionTool": "false", "canNotUseMemoryManagementFunctions": "true"}
"""What it needs is a library, libpython, and no tool: PyFMI refuses an FMU that needs one."""

SLAVE = """\
from {package}.models.{module} import MODEL
from {package}.pythonfmu.fmi2slave import Fmi2Slave
from {package}.runtime.python import slave


class {name}(slave.ModelSlave, Fmi2Slave):
    model = MODEL
    digest = "{digest}"

    # pythonfmu's binary gives back a reference to this module's dict that it does not own, once an instance
    module_dicts = [globals()]

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.module_dicts.append(globals())
"""
# a single file beside its package: pythonfmu's binary imports it, and runs it once more to find the class

IMPORTED = """\
import json, sys
sys.dont_write_bytecode = True
sys.path.insert(0, sys.argv[1])
import slave
files = [module.__file__ for name, module in sys.modules.items() if name.split(".")[0] == "staged"]
print(json.dumps([file for file in files if file]))
"""


def build(model: Model, module: str, path: Path) -> bool:
    """Write the Python FMU of the model declared in `fmu_src/models/<module>.py`; returns whether the file changed.

    Raises RuntimeError if the slave does not import, for instance because it needs more than the standard library.
    """
    sources = imported_sources(model, module)
    description = model_description(model, "", CAPABILITIES)
    digest = content_hash({**sources, "modelDescription.xml": description})
    package, slave = f"{model.name}_{digest}", f"slave_{model.name}_{digest}"

    files = {f"resources/{package}/{name}": content for name, content in sources.items()}
    files[f"resources/{slave}.py"] = slave_source(model, module, package, digest)
    files["resources/slavemodule.txt"] = f"{slave}\n".encode()
    files["modelDescription.xml"] = model_description(model, guid_of(digest), CAPABILITIES)
    for binary in sorted((PYTHONFMU / "resources" / "binaries").glob("*/*")):
        files[f"binaries/{binary.parent.name}/{model.name}{binary.suffix}"] = binary.read_bytes()
    files.update(companions(model))
    files["documentation/licenses/license.txt"] = license_text()
    files["documentation/licenses/pythonfmu.txt"] = distributed_license("pythonfmu")
    return write_fmu(path, files)


def slave_source(model: Model, module: str, package: str, digest: str) -> bytes:
    return SLAVE.format(package=package, module=module, name=model.name, digest=digest).encode()


def imported_sources(model: Model, module: str) -> Dict[str, bytes]:
    """What the import of the slave loads, found by doing so in a fresh interpreter, and the data files beside it."""
    with TemporaryDirectory() as name:
        folder = Path(name).resolve()
        staged = folder / "staged"
        for part in ("models", "runtime", "pmu_observer"):
            copy_tree(SOURCES / part, staged / part)
        copy_tree(PYTHONFMU, staged / "pythonfmu")
        # pythonfmu's own __init__ imports its builder, which the slave does not need
        (staged / "pythonfmu" / "__init__.py").write_text("")
        (staged / "__init__.py").write_text("")
        (folder / "slave.py").write_bytes(slave_source(model, module, "staged", ""))
        isolated = ["-I"] if model.requirements else ["-I", "-S"]  # -S: the standard library only
        command = [sys.executable, *isolated, "-c", IMPORTED, str(folder)]
        result = subprocess.run(command, capture_output=True, text=True, check=False)
        if result.returncode != 0:
            raise RuntimeError(f"{model.name} cannot be imported as a slave:\n{result.stderr}")
        imported = [Path(file).resolve() for file in json.loads(result.stdout)]
        data = [file for place in {file.parent for file in imported} for file in place.glob("*.csv")]
        return {file.relative_to(staged).as_posix(): file.read_bytes() for file in imported + data}


def copy_tree(source: Path, target: Path) -> None:
    for file in source.rglob("*"):
        if file.suffix in (".py", ".csv"):
            copy = target / file.relative_to(source)
            copy.parent.mkdir(parents=True, exist_ok=True)
            copy.write_bytes(file.read_bytes())
