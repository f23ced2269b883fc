"""build_fmu.py: the same sources give the same bytes, and the slave needs the standard library only."""

import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

import build_fmu


@pytest.mark.parametrize("name", ["PmuObserver", "PmuChannel", "SmibPlant"])
def test_the_same_sources_give_the_same_bytes(dist, tmp_path, name):
    again = build_fmu.build(name, tmp_path)
    assert again.read_bytes() == (dist / "python" / f"{name}.fmu").read_bytes()


def test_an_fmu_that_is_up_to_date_is_left_alone(tmp_path):
    path = build_fmu.build("SmibPlant", tmp_path)
    before = path.stat().st_mtime_ns
    build_fmu.build("SmibPlant", tmp_path)
    assert path.stat().st_mtime_ns == before


@pytest.mark.parametrize("name", ["PmuObserver", "PmuChannel", "SmibPlant"])
def test_the_slave_imports_without_site_packages(dist, tmp_path, name):
    """In an interpreter that sees nothing but the standard library (-S) and the FMU's resources."""
    with zipfile.ZipFile(dist / "python" / f"{name}.fmu") as fmu:
        fmu.extractall(tmp_path)
    resources = tmp_path / "resources"
    module = (resources / "slavemodule.txt").read_text().strip()
    script = f"import sys; sys.path.insert(0, {str(resources)!r}); import {module} as m; m.{name}(instance_name='x')"
    result = subprocess.run([sys.executable, "-I", "-S", "-c", script], capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr


def test_only_what_is_imported_is_packed(dist):
    with zipfile.ZipFile(dist / "python" / "SmibPlant.fmu") as fmu:
        names = {Path(name).name for name in fmu.namelist()}
    assert "smib.py" in names
    assert not {"drem.py", "arrays.py", "symbols.py", "modeldescription.py", "builder.py"} & names


def test_the_command_builds_one_and_refuses_an_unknown_name(tmp_path):
    root = Path(build_fmu.__file__).parent
    command = [sys.executable, "build_fmu.py", "--out", str(tmp_path), "--only"]
    built = subprocess.run([*command, "SmibPlant"], cwd=root, capture_output=True, text=True, check=True)
    assert "SmibPlant.fmu" in built.stdout
    assert (tmp_path / "python" / "SmibPlant.fmu").exists()
    refused = subprocess.run([*command, "Nothing"], cwd=root, capture_output=True, text=True, check=False)
    assert refused.returncode == 2
    assert "PmuObserver" in refused.stderr
