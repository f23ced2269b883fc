"""From the last frame that was taken to now: what the observer shows."""

from typing import Any, Dict, NamedTuple

from . import confidence, gaussian
from .angle import Covariance, direction_variance, unwrap
from .estimators import ESTIMATORS
from .gating import is_overdue
from .linear import Vector, propagate
from .machines.two_axis import Constants
from .matrix import place
from .observer_interface import (
    CAPTURING,
    HOLDING,
    MEASURED,
    TRACKING,
    Outputs,
    Parameters,
    system_base,
)
from .sampling import ahead
from .speed import SPEED_OBSERVERS
from .speed import rotor as swing
from .terminal import behind_impedance

NONE = {"e1d": 0.0, "e1q": 0.0, "e2d": 0.0, "e2q": 0.0}
"""The voltages of the outputs, by their names, as long as a model does not have them."""


class Windings(NamedTuple):
    """What the estimator says of the machine now."""

    x: Vector  # the rotor's view of F, pu
    covariance: Covariance
    voltages: Dict[str, Any]  # pu
    variances: Dict[str, Any]  # pu^2
    E_f: Any  # pu
    E_f_variance: Any  # pu^2


def windings(xp, c: Constants, m, coming, estimate, rotor, h) -> Windings:
    """The estimate, moved over an interval without a frame."""
    if not c.model:
        x = propagate(coming.flow, estimate.x)
        # behind x'd the estimator sees E'd + (x'q - x'd) Iq: exact in steady state
        frame = coming.before.measured
        angle = rotor.delta - frame.theta
        Iq = (frame.P * xp.cos(angle) - frame.Q * xp.sin(angle)) / frame.V
        voltages = {**NONE, "e1d": x.d - (m.xq1 - m.xd1) * Iq, "e1q": x.q}
        return Windings(x, Covariance(), voltages, NONE, frame.E_f, 0.0)
    now = gaussian.predict(xp, c, coming.flow, estimate.gaussian, estimate.E_f_walk * h)
    n = len(now.x)
    of_states = dict(zip(c.model.STATES, now.x))
    variances = {name: now.P[place(i, i, n)] for i, name in enumerate(c.model.STATES)}
    E_f = now.x[-1]
    if c.model.field_of_saturation:
        taken = c.model.field_of_saturation(xp, *coming.flow.iron, of_states["e1q"])
        E_f = E_f + xp.where(coming.flow.E_f_known > 0, 0.0, taken)
    return Windings(
        gaussian.flux(c, coming.flow.C, now.x),
        gaussian.flux_covariance(c, coming.flow.C, now),
        {**NONE, **of_states},
        {**NONE, **variances},
        E_f,
        now.P[-1],
    )


def predict(name: str, xp, p: Parameters, c: Constants, state) -> Outputs:
    """The outputs `elapsed` after the last frame was measured, with its measurement and its load angle held.

    omega' = -a0 omega + b0 (Pm - P) and delta' = omega go on. What changed between the last two frames may do so again
    unseen: that goes into the standard deviations; so does what the innovations say of them.
    """
    m = system_base(p)
    s, h, estimate, rotor = state.signals, xp.maximum(state.elapsed, 0.0), state.estimate, state.rotor
    frame = s.measured
    coming = ahead(xp, c, s, h, state.change)
    now = windings(xp, c, m, coming, estimate, rotor, h)
    for key, module in SPEED_OBSERVERS.items():
        c = module.constants(c, getattr(state.speed, key))
    rotor_now = swing.predict(xp, c, rotor, coming, rotor.P_m, p.mechanical_power == MEASURED)
    terminal = behind_impedance(xp, frame, -m.Ra, 0.0)

    R = rotor_now.covariance
    # a repeated frame that is believed for want of another says nothing of where the rotor is
    repeated = xp.where(state.gate.held > 0, xp.maximum(state.gate.unchanged - h, 0.0), 0.0)
    doubt = swing.OMEGA_WALK * swing.OMEGA_WALK * repeated
    radial = confidence.growth(xp, state.mean_squares.radial)
    across = confidence.growth(xp, state.mean_squares.angle)

    def deviation(known, variance):
        return xp.where(known > 0, xp.sqrt(xp.maximum(variance, 0.0)), 0.0)

    sure, rotor_sure = estimate.covariance.dd, rotor.covariance.dd
    waited = state.elapsed - state.latency
    held = xp.logical_or(state.gate.held > 0, is_overdue(xp, p, state.gate, waited))
    outputs = Outputs(
        delta=rotor_now.delta,
        load_angle=unwrap(xp, rotor.delta - terminal.theta, 0.0),
        omega=rotor_now.omega,
        e1d=now.voltages["e1d"],
        e1q=now.voltages["e1q"],
        e2d=now.voltages["e2d"],
        e2q=now.voltages["e2q"],
        E_f_hat=now.E_f,
        P_m_hat=rotor.P_m,
        delta_std=deviation(
            rotor_sure,
            across * R.dd + doubt * repeated * repeated / 3 + radial * direction_variance(now.x, now.covariance),
        ),
        omega_std=deviation(rotor_sure, across * R.oo + doubt),
        e1d_std=deviation(sure, radial * now.variances["e1d"]),
        e1q_std=deviation(sure, radial * now.variances["e1q"]),
        e2d_std=deviation(sure, radial * now.variances["e2d"]),
        e2q_std=deviation(sure, radial * now.variances["e2q"]),
        E_f_std=deviation(xp.where(frame.E_f_known > 0, 0.0, sure), radial * now.E_f_variance),
        P_m_std=deviation(rotor_sure, across * R.pp),
        innovation=estimate.innovation,
        angle_innovation=rotor.innovation,
        power_mismatch=state.power_mismatch,
        status=xp.where(held, HOLDING, xp.where(estimate.capturing > 0.5, CAPTURING, TRACKING)),
        speed=Outputs().speed._replace(
            **{key: module.outputs(xp, getattr(state.speed, key)) for key, module in SPEED_OBSERVERS.items()}
        ),
        estimators=Outputs().estimators._replace(**{name: ESTIMATORS[name].outputs(xp, state.estimator)}),
    )
    return xp.cond(state.started > 0, lambda: outputs, Outputs)
