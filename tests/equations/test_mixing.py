"""DREM's linear algebra against numpy, and its filters against scipy.signal."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.signal import lsim

from fmu_src.pmu_observer.carriers import floats
from fmu_src.pmu_observer.estimators.drem import Row, low_pass, mix

from .reference import mixed


@given(arrays(float, (5, 6), elements=st.floats(-10, 10)), st.floats(-6, 6))
def test_determinants(rows, scale):
    """Delta, calY1 and calY2, numpy's with their columns replaced."""
    rows = rows * 10**scale
    found = mix([Row(*row) for row in rows.tolist()])
    # numpy's LU factors a matrix that is off by rounding in the norm of the whole
    bound = float(np.linalg.norm(rows)) ** 5
    np.testing.assert_allclose(found, mixed(rows), rtol=0, atol=1e-14 * bound)


@pytest.mark.parametrize("d", [0.5, 8.0, 1000.0])
def test_low_pass_is_exact_for_a_polygon(d):
    """d/(s + d) on a signal that is linear between its samples: lsim does the same by a matrix exponential."""
    h, n = 0.02, 50
    w = np.random.default_rng(0).normal(size=n)
    _, expected, _ = lsim(([d], [1, d]), w, np.arange(n) * h, interp=True)
    v, found = Row(), [0.0]
    for before, after in zip(w, w[1:]):
        v = low_pass(floats, d * h, v, Row(*[before] * 6), Row(*[after] * 6))
        found.append(v.psi1)
    np.testing.assert_allclose(found, expected, atol=1e-12)
