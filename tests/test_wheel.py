"""The wheel, installed into a clean environment: it builds FMUs and runs scenarios with nothing of this checkout."""

import shutil
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

import pytest

import build_fmu

ELSEWHERE = shutil.ignore_patterns(".*", "build", "dist", "results", "tests", "*.egg-info")


@pytest.fixture(scope="module")
def python(tmp_path_factory) -> Path:
    """The interpreter of the environment; it is lent what the project depends on from the one that runs the tests."""
    folder = tmp_path_factory.mktemp("wheel")
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check"]
    shutil.copytree(build_fmu.ROOT, folder / "source", ignore=ELSEWHERE)  # setuptools would leave a build/ behind
    build = [*pip, "wheel", "-q", "--no-deps", "-w", str(folder), str(folder / "source")]
    subprocess.run(build, check=True, capture_output=True)
    wheel = next(folder.glob("pmu_observer-*.whl"))
    venv.create(folder / "env")
    scripts = folder / "env" / ("Scripts" if sys.platform == "win32" else "bin")
    interpreter = scripts / Path(sys.executable).name
    subprocess.run([*pip, "--python", str(interpreter), "install", "-q", "--no-deps", str(wheel)], check=True)
    where = subprocess.run(
        [str(interpreter), "-c", "import sysconfig; print(sysconfig.get_path('purelib'))"],
        check=True, capture_output=True, text=True,
    )  # fmt: skip
    (Path(where.stdout.strip()) / "lent.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return interpreter


def run(python: Path, folder: Path, *arguments: str) -> str:
    result = subprocess.run([str(python), *arguments], cwd=folder, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    return result.stdout


def test_it_is_the_wheel_that_runs(python, tmp_path):
    found = run(python, tmp_path, "-c", "import build_fmu, scenarios; print(build_fmu.__file__, scenarios.__file__)")
    assert all(str(python.parents[1]) in path for path in found.split())


def test_it_builds_the_same_fmus(python, tmp_path, dist):
    """With their data files: Ieee39Plant has tables."""
    for name in ("PmuObserver", "Ieee39Plant"):
        run(python, tmp_path, "-m", "build_fmu", "--only", name)
        built = tmp_path / "dist" / "python" / f"{name}.fmu"
        assert built.read_bytes() == (dist / "python" / f"{name}.fmu").read_bytes()


def test_it_builds_a_native_fmu(python, tmp_path, native_dist):
    run(python, tmp_path, "-m", "build_fmu", "--native", "--only", "SmibPlant")
    built = tmp_path / "dist" / "native" / "SmibPlant.fmu"
    assert built.read_bytes() == (native_dist / "native" / "SmibPlant.fmu").read_bytes()


def test_it_runs_a_scenario(python, tmp_path):
    assert "paper_gradient" in run(python, tmp_path, "-m", "scenarios", "list")
    run(python, tmp_path, "-m", "scenarios", "run", "paper_drem_20ms")
    assert list((tmp_path / "results" / "paper_drem_20ms").glob("*.csv"))


def test_the_command_is_installed(python, tmp_path):
    result = subprocess.run([str(python.with_name("build_fmu")), "--help"], capture_output=True, text=True, check=True)
    assert "Build the FMI 2.0 co-simulation FMUs" in result.stdout
