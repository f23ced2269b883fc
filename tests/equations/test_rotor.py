"""The rotor over a gap: its acceleration lasts for SEEN, then it coasts."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

from fmu_src.pmu_observer.carriers import floats
from fmu_src.pmu_observer.speed import rotor


@given(st.floats(1e-3, 5.0), st.floats(1.01, 50.0))
def test_motion_with_a_gap_is_two_matrix_exponentials(a0, times):
    """Of delta' = omega, omega' = -a0 omega + f with f constant for SEEN, then 0; the series costs below 2e-7."""
    h = times * rotor.SEEN
    A = np.array([[0, 1, 0], [0, -a0, 1], [0, 0, 0]])
    F = expm(A * (h - rotor.SEEN)) @ np.diag([1, 1, 0]) @ expm(A * rotor.SEEN)
    m = rotor.motion_with_gap(floats, a0, h)
    np.testing.assert_allclose([m.t, m.w, m.E, m.v], [F[0, 1], F[0, 2], F[1, 1], F[1, 2]], rtol=2e-6, atol=1e-12)


@pytest.mark.parametrize("part", [0.1, 1.0])
def test_without_a_gap_it_is_the_motion(part):
    h = part * rotor.SEEN
    assert rotor.motion_with_gap(floats, 0.7, h) == rotor.motion(floats, 0.7, h)
