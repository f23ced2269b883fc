"""What all tests share: the FMUs, built once a session."""

from pathlib import Path

import pytest

import build_fmu


@pytest.fixture(scope="session")
def dist(tmp_path_factory) -> Path:
    """A folder like `dist/` with the Python FMUs of this checkout."""
    out = tmp_path_factory.mktemp("dist")
    for name in build_fmu.all_models():
        build_fmu.build(name, out)
    return out
