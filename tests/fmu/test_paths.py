"""Where an FMU is unpacked, and how its resources are named (FMI 2.0.4: a URI, which the FMU decodes).

The native kind needs no resources. The Python kind's loader is pythonfmu's, which decodes blanks only and ends the host
where it does not find its files; what it can do is tested, and its documentation says what it cannot.
"""

import subprocess
import sys
from pathlib import Path

import pytest
from fmpy import extract

NAMES = ("plain", "with blank", "José", "copy (2)", "C++", "50%", "#1")
FORMS = ("file://{}", "file:{}", "file://localhost{}", "{}")

STEP = """
import sys
from pathlib import Path
from fmpy import fmi2, read_model_description
folder, form = sys.argv[1:]
if form:
    class Named(type(Path())):
        as_uri = lambda self: form.format(Path(str(self)).as_posix())
    fmi2.Path = Named
    fmi2.pathlib = type("pathlib", (), {"Path": Named})
slave = fmi2.FMU2Slave(
    guid=read_model_description(folder).guid, unzipDirectory=folder, modelIdentifier="SmibPlant", instanceName="x"
)
slave.instantiate()
slave.setupExperiment(startTime=0.0)
slave.enterInitializationMode()
slave.exitInitializationMode()
slave.doStep(0.0, 0.01)
"""


def run(path: Path, folder: Path, form: str = "") -> int:
    folder.mkdir(parents=True)
    extract(str(path), str(folder))
    return subprocess.run([sys.executable, "-c", STEP, str(folder), form], capture_output=True, check=False).returncode


@pytest.mark.parametrize("name", NAMES)
def test_the_native_kind_runs_in_any_folder(native_dist, tmp_path, name):
    assert run(native_dist / "native" / "SmibPlant.fmu", tmp_path / name) == 0


@pytest.mark.parametrize("form", FORMS)
def test_the_native_kind_takes_any_form_of_the_uri(native_dist, tmp_path, form):
    assert run(native_dist / "native" / "SmibPlant.fmu", tmp_path / "plain", form) == 0


@pytest.mark.parametrize("name", NAMES[:2])
def test_the_python_kind_runs_where_the_path_is_plain_but_for_blanks(dist, tmp_path, name):
    assert run(dist / "python" / "SmibPlant.fmu", tmp_path / name) == 0


def test_the_documentation_says_what_the_python_kind_cannot(dist, tmp_path):
    folder = Path(extract(str(dist / "python" / "SmibPlant.fmu"), str(tmp_path)))
    text = (folder / "documentation" / "index.html").read_text(encoding="utf-8")
    assert "brackets, +, #, % or accents" in text and "file://localhost/" in text
