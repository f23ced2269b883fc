"""The 3rd-order flux-decay model and its algebraic observer (Proposition 1 of the paper, corrected).

    x1' = x2,   x2' = -a0 x2 + b0 (u1 - y5),   x3' = -a1 x3 + b1 V cos(x1 - theta) + c1 u2,   x = (delta, omega, E'q)

The rotor has no q-axis winding: this is the two-axis machine with xq = x'q = x'd, whose E'd decays to 0. Then E' lies
on the q axis and one frame is enough for (x1, x3); the frame of Proposition 1 is (V, P, Q, I), with Y = 1/x'.
"""

from typing import Annotated, NamedTuple

from .interface import Real, Scalar
from .machines.data import Machine


class AlgebraicEstimate(NamedTuple):
    load_angle: Annotated[Scalar, Real("rad", "delta - theta")]
    e1q: Annotated[Scalar, Real("pu", "E'q")]


def flux_decay(machine: Machine) -> Machine:
    """The machine without its q-axis winding: the 3rd-order model with the same d axis."""
    return machine._replace(xq=machine.xd1, xq1=machine.xd1)


def observe(xp, V, P, Q, I, x) -> AlgebraicEstimate:  # noqa: E741 - the paper's name
    """x1 - theta = atan2(P, Q + Y V^2),  x3 = sqrt((I^2 + 2 Y Q)/Y^2 + V^2),  Y = 1/x', all pu and rad.

    The preprint prints Y_i for Y and arcsin for atan2: arcsin is wrong beyond 90 degrees.
    """
    Y = 1 / x
    e1q = xp.sqrt(xp.maximum((I * I + 2 * Y * Q) / (Y * Y) + V * V, 0.0))
    return AlgebraicEstimate(xp.atan2(P, Q + Y * V * V), e1q)
