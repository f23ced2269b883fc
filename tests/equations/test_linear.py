"""The exact solutions of 2x2 linear systems, against the exponential in 60 digits, scipy, quadrature and solve_ivp."""

from decimal import Decimal, localcontext
from math import inf, isfinite

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from fmu_src.pmu_observer.carriers import floats
from fmu_src.pmu_observer.linear import Matrix, Vector, decay_mean, exponential, propagate, propagation, relax

entries = st.floats(-1.0, 1.0).map(lambda x: x if abs(x) > 1e-12 else 0.0)
# eigenvalues below 50, where the package caps the growth
matrices = st.builds(
    lambda scale, *a: Matrix(*(10**scale * x for x in a)), st.floats(-6, 1.39), entries, entries, entries, entries
)


def array(m: Matrix) -> np.ndarray:
    return np.array(m).reshape(2, 2)


def expm_60_digits(a: Matrix) -> np.ndarray:
    """By scaling and squaring of the Taylor series; scipy.linalg.expm is off by 1e-12 of its largest entry here."""
    with localcontext(prec=60):
        A = np.array([Decimal(x) / 2**20 for x in a]).reshape(2, 2)
        power = total = np.array([[Decimal(1), Decimal(0)], [Decimal(0), Decimal(1)]])
        for n in range(1, 20):
            power = power @ A / n
            total = total + power
        for _ in range(20):
            total = total @ total
        return total.astype(float)


@given(matrices)
@example(Matrix(-3.0, 0.0, 0.0, -3.0))  # equal eigenvalues, a multiple of I
@example(Matrix(-3.0, 1.0, 0.0, -3.0))  # equal eigenvalues, defective
@example(Matrix(-3.0, 1e-2, -1e-2, -3.0))  # complex, at the series' border
@example(Matrix(-3.0, 1e-2, 1e-2, -3.0))  # real, at the series' border
@example(Matrix(-1.0, 20.0, -20.0, -1.0))  # complex
@example(Matrix(-200.0, 0.0, 0.0, 40.0))  # far apart
@example(Matrix(-700.0, 1.0, 1.0, -0.1))  # a fast mode and a slow one
def test_exponential(a):
    # the rounding of A h, amplified by its exponent and by its eigenvectors
    size = np.linalg.norm(array(a))
    growth = np.exp(max(np.linalg.eigvals(array(a)).real)) * (1 + size)
    np.testing.assert_allclose(
        array(exponential(floats, a, 1.0)), expm_60_digits(a), rtol=0, atol=1e-15 * (1 + size) * growth
    )


@given(matrices, st.floats(1e-4, 1.0))
def test_exponential_takes_the_length_of_the_interval(a, h):
    scaled = Matrix(*(h * x for x in a))
    size = np.linalg.norm(array(scaled))
    growth = np.exp(max(np.linalg.eigvals(array(scaled)).real)) * (1 + size)
    np.testing.assert_allclose(
        exponential(floats, a, h), exponential(floats, scaled, 1.0), rtol=0, atol=1e-14 * (1 + size) * growth
    )


huge = st.floats(-1e12, 1e12)


@given(huge, huge, huge, huge, st.floats(1e-6, 1e3))
def test_no_matrix_overflows_or_raises(dd, dq, qd, qq, h):
    a = Matrix(dd, dq, qd, qq)
    assert all(isfinite(x) for x in exponential(floats, a, h))


@given(st.floats(0.0, 700.0))
@example(0.0)
@example(5e-324)
def test_decay_mean(z):
    """The mean of e^-zt over t in [0, 1], by Gauss-Legendre quadrature on the part where it is not negligible."""
    nodes, weights = np.polynomial.legendre.leggauss(40)
    end = min(1.0, 40.0 / z) if z > 0 else 1.0
    mean = end / 2 * np.dot(weights, np.exp(-z * end / 2 * (nodes + 1)))
    assert decay_mean(floats, z) == pytest.approx(mean, rel=1e-13)


def test_decay_mean_of_extreme_gains():
    assert decay_mean(floats, 1e300) == 1e-300
    assert decay_mean(floats, inf) == 0


@given(st.floats(-10, 10), st.floats(0, 50), st.floats(-100, 100), st.floats(1e-3, 2.0))
def test_relax(v, rate, drive, h):
    """The exponential of [[-rate, drive], [0, 0]] moves (v, 1)."""
    expected = (expm(h * np.array([[-rate, drive], [0, 0]])) @ [v, 1])[0]
    assert relax(floats, v, rate, drive, h) == pytest.approx(expected, abs=1e-12 * (1 + abs(v) + abs(drive)))


def test_propagation_is_of_second_order():
    """A(t) and the forcing are linear in t between their ends: the error of one interval is of third order."""
    A0, A1 = np.array([[-7.0, 3.0], [-0.1, -0.2]]), np.array([[-2.0, 4.0], [0.5, -0.6]])
    x0 = np.array([0.4, 0.3])
    errors = []
    for h in (0.04, 0.02, 0.01):
        A_end, b_end = A0 + h * (A1 - A0), 0.5 + 3 * h

        def rates(t, x, h=h, A_end=A_end, b_end=b_end):
            return (A0 + t / h * (A_end - A0)) @ x + [0, 0.5 + t / h * (b_end - 0.5)]

        exact = solve_ivp(rates, (0, h), x0, method="DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
        step = propagation(floats, Matrix(*A0.flat), Matrix(*A_end.flat), 0.5, b_end, h)
        errors.append(np.abs(np.array(propagate(step, Vector(*x0))) - exact).max())
    assert errors[0] / errors[1] == pytest.approx(8, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(8, rel=0.1)


def test_propagation_with_constant_coefficients():
    """Then only Simpson's rule for the forcing is left: h^5/2880 |A|^4 |b| per interval."""
    A, b, h = np.array([[-7.0, 3.0], [-0.1, -0.2]]), 0.5, 0.02
    extended = expm(h * np.block([[A, np.array([[0], [b]])], [np.zeros((1, 3))]]))
    a = Matrix(*A.flat)
    step = propagation(floats, a, a, b, b, h)
    np.testing.assert_allclose(array(step.F), extended[:2, :2], atol=1e-15)
    np.testing.assert_allclose(step.g, extended[:2, 2], atol=float(h**5 / 2880 * np.linalg.norm(A) ** 4 * b))
