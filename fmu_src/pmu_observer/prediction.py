"""From the last frame that was taken to now: what the observer shows."""

from . import confidence, gaussian
from .angle import direction_variance, unwrap
from .estimators import ESTIMATORS
from .gating import is_overdue
from .machines.two_axis import Constants
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


def predict(name: str, xp, p: Parameters, c: Constants, state) -> Outputs:
    """The outputs `elapsed` after the last frame was measured, with its measurement and its load angle held.

    omega' = -a0 omega + b0 (Pm - P) and delta' = omega go on. What changed between the last two frames may do so again
    unseen: that goes into the standard deviations; so does what the innovations say of them.
    """
    m = system_base(p)
    s, h, estimate, rotor = state.signals, xp.maximum(state.elapsed, 0.0), state.estimate, state.rotor
    frame = s.measured
    coming = ahead(xp, c, s, h, state.change)
    now = gaussian.predict(
        xp,
        gaussian.transition(xp, c, coming),
        gaussian.Gaussian(estimate.x, estimate.E_f, estimate.covariance),
        estimate.E_f_walk * h,
    )
    for key, module in SPEED_OBSERVERS.items():
        c = module.constants(c, getattr(state.speed, key))
    rotor_now = swing.predict(xp, c, rotor, coming, rotor.P_m, p.mechanical_power == MEASURED)
    terminal = behind_impedance(xp, frame, -m.Ra, 0.0)

    # behind x'd the estimator sees E'd + (x'q - x'd) Iq: exact in steady state
    angle = rotor.delta - frame.theta
    Iq = (frame.P * xp.cos(angle) - frame.Q * xp.sin(angle)) / frame.V
    P, R = now.P, rotor_now.covariance
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
        e1d=now.x.d - (m.xq1 - m.xd1) * Iq,
        e1q=now.x.q,
        E_f_hat=now.E_f,
        P_m_hat=rotor.P_m,
        delta_std=deviation(
            rotor_sure, across * R.dd + doubt * repeated * repeated / 3 + radial * direction_variance(now.x, P)
        ),
        omega_std=deviation(rotor_sure, across * R.oo + doubt),
        e1d_std=deviation(sure, radial * P.dd),
        e1q_std=deviation(sure, radial * P.qq),
        E_f_std=deviation(xp.where(frame.E_f_known > 0, 0.0, sure), radial * P.ff),
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
