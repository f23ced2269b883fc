"""EKF and UKF on FilterPy, as its users write them."""

import numpy as np
from filterpy.kalman import ExtendedKalmanFilter, MerweScaledSigmaPoints, UnscentedKalmanFilter

from fmu_src.pmu_observer.carriers import floats
from fmu_src.pmu_observer.machines.two_axis import Constants

from . import model
from .model import ALPHA, BETA, KAPPA, Inputs


class Ekf(ExtendedKalmanFilter):
    def __init__(self, c: Constants, x, P, Q):
        super().__init__(dim_x=4, dim_z=2)
        self.c, self.x, self.P, self.Q = c, np.array(x, float), np.array(P, float), Q

    def step(self, u: Inputs, h: float, z, R) -> None:
        """From one frame to the next with the inputs' mean u, then the update with the next frame."""
        self.F = model.f_jacobian(self.c, self.x, u, h)
        self.x_next = np.array(model.f(floats, self.c, self.x.tolist(), u, h))
        self.predict()
        self.update(z, model.h_jacobian, lambda x: np.array(model.h(floats, x)), R=R)

    def predict_x(self, u=0) -> None:
        self.x = self.x_next


class Ukf(UnscentedKalmanFilter):
    def __init__(self, c: Constants, x, P, Q):
        super().__init__(
            dim_x=4,
            dim_z=2,
            dt=0.0,
            fx=lambda x, dt, u: np.array(model.f(floats, c, x.tolist(), u, dt)),
            hx=lambda x: np.array(model.h(floats, x)),
            points=MerweScaledSigmaPoints(4, ALPHA, BETA, KAPPA),
        )
        self.x, self.P, self.Q = np.array(x, float), np.array(P, float), Q

    def step(self, u: Inputs, h: float, z, R) -> None:
        """As in Ekf."""
        self.predict(dt=h, u=u)
        self.update(z, R=R)
