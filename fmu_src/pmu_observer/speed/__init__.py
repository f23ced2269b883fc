"""The observers of the speed deviation x2 = omega from the rotor angle, one a file.

To add one, write a module that satisfies `SpeedObserver` and add it to `SPEED_OBSERVERS`. Its place there is its number
in the FMU's `speed_observer` enumeration, so new ones go to the end; its name prefixes its own parameters and outputs
(`adaptive.gamma`).
"""

from typing import Any, NamedTuple, Protocol, Tuple, Type

from ..angle import Estimate
from ..interface import Scalar
from ..machines.two_axis import Constants
from ..phasors import Signals
from ..sampling import Interval
from . import adaptive, immersion_invariance, kalman
from .rotor import Rotor


class Settings(NamedTuple):
    """What all speed observers are told."""

    P_m_known: Scalar  # 1 where P_m is measured
    k: Scalar  # 1/s, gain of those that have one


class SpeedObserver(Protocol):
    """What the observer asks of a speed observer; its own state, beside the rotor, is any tree of scalars."""

    Parameters: Type[NamedTuple]  # annotated, with defaults
    Outputs: Type[NamedTuple]  # annotated, with defaults

    def start(self, xp, c: Constants, s: Signals, estimate: Estimate, settings: Settings) -> Tuple[Rotor, Any]:
        """The rotor and the observer's own state at a first frame."""
        ...

    def step(
        self,
        xp,
        p: Any,
        c: Constants,
        rotor: Rotor,
        own: Any,
        interval: Interval,
        estimate: Estimate,
        settings: Settings,
    ) -> Tuple[Rotor, Any]:
        """Both at the end of an interval, with the estimator's estimate there, from those at its start."""
        ...

    def constants(self, c: Constants, own: Any) -> Constants:
        """The machine's constants, with those that the observer estimates in their place."""
        ...

    def outputs(self, xp, own: Any) -> Any:
        """The observer's own Outputs."""
        ...


SPEED_OBSERVERS = {
    "immersion_invariance": immersion_invariance,
    "adaptive": adaptive,
    "kalman": kalman,
}
