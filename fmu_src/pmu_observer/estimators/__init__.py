"""The estimators of (E'd, E'q), one a file.

To add one, write a module that satisfies `Estimator` and add it to `ESTIMATORS`. Its place there is its number in the
FMU's `estimator` enumeration, so new ones go to the end; its name prefixes its parameters and outputs (`drem.gamma`).
"""

from typing import Any, NamedTuple, Protocol, Type

from ..angle import Estimate
from ..machines.two_axis import Constants
from ..phasors import Signals
from ..sampling import Interval
from . import drem, gradient, joint_gradient, open_loop, overparameterised, robust, third_order


class Estimator(Protocol):
    """What the observer asks of an estimator; its own state is any tree of scalars."""

    Parameters: Type[NamedTuple]  # annotated, with defaults
    Outputs: Type[NamedTuple]  # annotated, with defaults

    def start(self, xp, p: Any, c: Constants, s: Signals) -> Any:
        """The state at the first frame."""
        ...

    def step(self, xp, p: Any, c: Constants, state: Any, interval: Interval) -> Any:
        """The state at the end of an interval, from the one at its start."""
        ...

    def estimate(self, xp, state: Any, s: Signals, near) -> Estimate:
        """delta (of all delta + 2 k pi the one nearest to `near`) and (E'd, E'q) at the frame `s`."""
        ...

    def outputs(self, xp, state: Any) -> Any:
        """The estimator's own Outputs."""
        ...


ESTIMATORS = {
    "drem": drem,
    "overparameterised": overparameterised,
    "gradient": gradient,
    "joint_gradient": joint_gradient,
    "open_loop": open_loop,
    "robust": robust,
    "third_order": third_order,
}
