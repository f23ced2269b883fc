"""EKF and UKF for many noise seeds and tunings at once: x has the shape (..., 4), P (..., 4, 4).

FilterPy's equations, which a test holds them to; FilterPy itself takes half a minute for 100 seeds of one UKF.
"""

import numpy as np

from fmu_src.pmu_observer.machines.two_axis import Constants

from . import model
from .model import ALPHA, BETA, KAPPA, Inputs

LAMBDA = ALPHA**2 * (4 + KAPPA) - 4
WEIGHTS_MEAN = np.full(9, 0.5 / (4 + LAMBDA))
WEIGHTS_MEAN[0] = LAMBDA / (4 + LAMBDA)
WEIGHTS_COVARIANCE = WEIGHTS_MEAN.copy()
WEIGHTS_COVARIANCE[0] += 1 - ALPHA**2 + BETA


def ekf_step(c: Constants, x, P, Q, u: Inputs, h, z, R):
    """x and P at the next frame; `z` (..., 2), `R` is the variance of each part of z."""
    parts = np.moveaxis(x, -1, 0)
    F = model.f_jacobian(c, parts, u, h)
    x = stacked(model.f(np, c, parts, u, h))
    P = F @ P @ transposed(F) + Q
    parts = np.moveaxis(x, -1, 0)
    H = model.h_jacobian(parts)
    PHT = P @ transposed(H)
    noise = R[..., None, None] * np.eye(2)
    K = PHT @ np.linalg.inv(H @ PHT + noise)
    I_KH = np.eye(4) - K @ H
    x = x + (K @ (z - stacked(model.h(np, parts)))[..., None])[..., 0]
    return x, I_KH @ P @ transposed(I_KH) + K @ noise @ transposed(K)


def ukf_step(c: Constants, x, P, Q, u: Inputs, h, z, R):
    """As `ekf_step`."""
    moved = stacked(model.f(np, c, np.moveaxis(sigma_points(x, P), -1, 0), u_of_points(u), h))
    x, P = mean_and_covariance(moved)
    P = P + Q
    points = sigma_points(x, P)
    seen = stacked(model.h(np, np.moveaxis(points, -1, 0)))
    mean, S = mean_and_covariance(seen)
    S = S + R[..., None, None] * np.eye(2)
    cross = transposed(points - x[..., None, :]) * WEIGHTS_COVARIANCE @ (seen - mean[..., None, :])
    K = cross @ np.linalg.inv(S)
    x = x + (K @ (z - mean)[..., None])[..., 0]
    return x, P - K @ S @ transposed(K)


def sigma_points(x, P):
    """Merwe's, shape (..., 9, 4); the rows of the upper Cholesky factor, as in FilterPy."""
    U = transposed(np.linalg.cholesky((4 + LAMBDA) * (P + transposed(P)) / 2))
    x = x[..., None, :]
    return np.concatenate([x, x + U, x - U], axis=-2)


def mean_and_covariance(points):
    mean = WEIGHTS_MEAN @ points
    away = points - mean[..., None, :]
    return mean, transposed(away) * WEIGHTS_COVARIANCE @ away


def u_of_points(u: Inputs) -> Inputs:
    return Inputs(*[np.asarray(value)[..., None] for value in u])


def stacked(parts):
    return np.stack(np.broadcast_arrays(*parts), axis=-1)


def transposed(matrix):
    return np.swapaxes(matrix, -1, -2)
