"""Native plant and observer in every importer: the same run, the same results."""

import pytest

from . import runs
from .runs import IMPORTERS


@pytest.mark.parametrize("importer", IMPORTERS, ids=lambda importer: importer.module)
def test_co_simulation(native_dist, importer):
    if runs.missing(importer):
        pytest.skip(runs.missing(importer))
    found = runs.results(importer, native_dist / "native")
    assert runs.difference(importer, native_dist / "native") <= importer.tolerance
    # the default estimator, which importers that ignore enumerations get as well, is near the truth after 2 s
    assert found["observer.delta"] == pytest.approx(found["plant.delta"], abs=1e-2)
    assert found["observer.e1q"] == pytest.approx(found["plant.e1q"], abs=1e-2)
