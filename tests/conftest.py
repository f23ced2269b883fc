"""What all tests share: the FMUs, built once a session."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from filelock import FileLock
from hypothesis import settings

import build_fmu
from scenarios import study

settings.register_profile("patient", parent=settings(), deadline=None)  # no failure because a machine is busy
settings.load_profile("patient")


def pytest_addoption(parser):
    parser.addoption("--native-dist", type=Path, help="test the native FMUs in this folder, not freshly built ones")


@pytest.fixture(scope="session")
def dist(tmp_path_factory) -> Path:
    """A folder like `dist/` with the Python FMUs of this checkout."""
    out = tmp_path_factory.mktemp("dist")
    for name in build_fmu.all_models():
        build_fmu.build(name, out)
    return out


@pytest.fixture(scope="session")
def native_dist(tmp_path_factory, worker_id, pytestconfig) -> Iterator[Path]:
    """The same with the native FMUs, compiled once for all workers; scenarios run with these too."""
    base = tmp_path_factory.getbasetemp()
    out = pytestconfig.getoption("native_dist")
    if out is None:
        out = (base if worker_id == "master" else base.parent) / "dist"
        with FileLock(f"{out}.lock"):
            for name in build_fmu.native_names():
                build_fmu.build_native(name, out)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(study, "DIST", out)
        yield out
