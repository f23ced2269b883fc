"""smib.ssp: plant, PMU and observer in one file, run by two importers."""

import zipfile

import numpy as np
import pytest
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import Parameter, ParameterSet, find_components, read_ssd

import build_fmu

from . import runs

H = 1 / 60
WAITING, TRACKING = 0, 2
ECOS = next(importer for importer in runs.IMPORTERS if importer.module == "with_ecos")


@pytest.fixture(scope="module")
def ssp(native_dist):
    return build_fmu.build_ssp(native_dist)


def start_values(path) -> ParameterSet:
    """Those in the SSP, which FMPy's master does not apply by itself."""
    components = find_components(read_ssd(str(path)).system)
    bound = [
        Parameter(name=f"{component.name}.{parameter.name}", type=parameter.type, value=parameter.value)
        for component in components
        for binding in component.parameterBindings
        for values in binding.parameterValues
        for parameter in values.parameters
    ]
    return ParameterSet(name="start", parameters=bound)


def test_the_same_fmus_give_the_same_bytes(ssp, tmp_path, native_dist):
    before = ssp.read_bytes()
    ssp.unlink()
    assert build_fmu.build_ssp(native_dist).read_bytes() == before
    with zipfile.ZipFile(ssp) as content:
        assert content.read("resources/PmuObserver.fmu") == (native_dist / "native" / "PmuObserver.fmu").read_bytes()


def test_fmpy(ssp):
    """Its first frame is zero, which the observer holds over; then the estimate comes near what the machine shows.

    The schema of SSP 1.0 is checked by `read_ssd`.
    """
    rows = simulate_ssp(str(ssp), stop_time=10.0, step_size=H, parameter_set=start_values(ssp))
    assert rows["observer.status"][0] == WAITING
    late = rows[rows["time"] > 5.0]
    assert np.all(late["observer.status"] == TRACKING)
    for name in ("delta", "e1d", "e1q"):
        rms = np.sqrt(np.mean((late[f"observer.{name}"] - late[f"plant.{name}"]) ** 2))
        assert rms < 0.01, name  # of the order of the phasors' noise, which is 1 %


def test_ecos(ssp):
    if runs.missing(ECOS):
        pytest.skip(runs.missing(ECOS))
    from .with_ecos import simulate

    row = simulate(ssp, 10.0, H)
    for name in ("delta", "e1d", "e1q"):
        assert row[f"observer::{name}[REAL]"] == pytest.approx(row[f"plant::{name}[REAL]"], abs=0.02), name
