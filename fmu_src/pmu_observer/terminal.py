"""From where the PMU is to behind the stator resistance: the step-up transformer, where there is one, and Ra.

A PMU on the high side of a step-up transformer sees (V_h, I_h). With the high side ahead by `shift` (Yd11: +30 deg) and
the ratio `tap`, the machine's terminal has, generator convention,

    I_t = I_h e^{-j shift}/tap        V_t = tap V_h e^{-j shift} + (r_T + j x_T) I_t

The default transformer is none: it changes nothing, to the last bit.
"""

from math import pi
from typing import Annotated, NamedTuple

from .interface import Real, Scalar
from .phasors import LOWEST_VOLTAGE, Measurement


class Transformer(NamedTuple):
    """The step-up transformer between the machine and the PMU; reactance and resistance on the machine's base."""

    x_T: Annotated[
        Scalar, Real("pu", "leakage reactance of the step-up transformer below the PMU; 0: none", min=0.0, max=10.0)
    ] = 0.0
    r_T: Annotated[Scalar, Real("pu", "its resistance", min=0.0, max=1.0)] = 0.0
    tap: Annotated[
        Scalar,
        Real(
            "1",
            "its off-nominal ratio: voltage at the machine per voltage at the PMU, no load, in pu",
            min=0.5,
            max=2.0,
        ),
    ] = 1.0
    shift: Annotated[
        Scalar, Real("rad", "angle by which the PMU's side leads the machine's (Yd11: pi/6)", min=-pi, max=pi)
    ] = 0.0


def transformer_on_system_base(t: Transformer, S_n, S_base) -> Transformer:
    """From pu of the machine's S_n, MVA, to pu of S_base."""
    up = S_base / S_n
    return t._replace(x_T=t.x_T * up, r_T=t.r_T * up)


def at_machine(xp, m: Measurement, t: Transformer) -> Measurement:
    """What a PMU at the machine's terminal would have measured."""
    turned = m._replace(theta=m.theta - t.shift, V=m.V * t.tap, I=m.I / t.tap)
    return behind_impedance(xp, turned, t.r_T, t.x_T)


def behind_impedance(xp, m: Measurement, r, x) -> Measurement:
    """The terminal moved behind r + jx: V + (r + jx) I, P + r I^2, Q + x I^2. -r and -x move it back."""
    along = m.V + (r * m.P + x * m.Q) / m.V  # in the frame of V, where I = (P - jQ)/V
    across = (x * m.P - r * m.Q) / m.V
    return m._replace(
        theta=m.theta + xp.atan2(across, along),
        V=xp.maximum(xp.sqrt(along * along + across * across), LOWEST_VOLTAGE),  # a wild frame: see is_consistent
        P=m.P + r * m.I * m.I,
        Q=m.Q + x * m.I * m.I,
    )
