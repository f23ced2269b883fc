"""What all tests share: the FMUs, built once a session."""

from pathlib import Path

import pytest
from filelock import FileLock

import build_fmu


@pytest.fixture(scope="session")
def dist(tmp_path_factory) -> Path:
    """A folder like `dist/` with the Python FMUs of this checkout."""
    out = tmp_path_factory.mktemp("dist")
    for name in build_fmu.all_models():
        build_fmu.build(name, out)
    return out


@pytest.fixture(scope="session")
def native_dist(tmp_path_factory, worker_id) -> Path:
    """The same with the native FMUs, compiled once for all workers."""
    base = tmp_path_factory.getbasetemp()
    out = (base if worker_id == "master" else base.parent) / "dist"
    with FileLock(f"{out}.lock"):
        for name in build_fmu.native_names():
            build_fmu.build_native(name, out)
    return out
