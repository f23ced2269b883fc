"""The models of a synchronous machine, one a file: its equations for a plant, and what an observer makes of them.

To add one, write a module that satisfies `MachineModel` and add it to `MACHINE_MODELS`. Its place there is its number
in the enumeration `machine_model`, so new ones go to the end. README.md says which model belongs to which data sheet.

Every model is written twice, and tests hold the two against each other: its nonlinear form as its data sheet's source
prints it, and its linear, time-varying form for the observer (see `axes`).
"""

from typing import Any, Callable, List, Optional, Protocol, Tuple, Type

from ..interface import Rule
from ..linear import Vector
from . import genrou, gensae, gensal, gentpj, two_axis
from .axes import Axes
from .data import Machine
from .saturation import Saturation
from .stator import Field, Stator


class MachineModel(Protocol):
    """Pairs are in the rotor's frame; `v` is the voltage behind Ra, `i` the generated current, pu."""

    Windings: Type[Any]  # states of the nonlinear form

    def stator(self, xp, m: Machine, x: Any, S) -> Stator:
        """The voltages behind reactances that the network sees; S matters to gentpj only."""
        ...

    def saturation(self, xp, m: Machine, v: Vector, i: Vector) -> Any:
        """S; gensal: at rest."""
        ...

    def rates(self, xp, m: Machine, x: Any, i: Vector, S, E_f) -> Any:
        """The derivative of the windings."""
        ...

    def at_rest(self, xp, m: Machine, S) -> Field:
        """The machine in steady state with this saturation."""
        ...

    def windings_at_rest(self, xp, m: Machine, v: Vector, i: Vector, S) -> Any:
        """The windings in steady state."""
        ...

    def voltages(self, xp, m: Machine, x: Any, i: Vector, S) -> Tuple[Vector, Vector]:
        """(E'd, E'q) and (E''d, E''q); 0 where the model has none."""
        ...

    STATES: Tuple[str, ...]  # of the linear form, by the names of the observer's outputs, those of the d axis first
    D_STATES: int  # how many are of the d axis
    SALIENT: bool  # f is not simply the first state of each axis

    field_of_saturation: Optional[Callable]
    """(xp, S10, S12, e1q) -> what a saturation that no PMU sees takes of the field voltage, pu; None: there is none."""

    def seen(self, xp, m: Machine, V, I, Q) -> Saturation:  # noqa: E741 - the paper's name
        """S from what a frame gives, with the terminal moved behind Ra."""
        ...

    def reactance(self, xp, m: Machine, S) -> Any:
        """x of the measured voltage F = V + (Ra + j x) I."""
        ...

    def axes(self, xp, m: Machine, S) -> Axes:
        """The linear form of each axis."""
        ...

    def rules(self, xp, m: Machine) -> List[Rule]:
        """What must hold of the data."""
        ...


MACHINE_MODELS = {"two_axis": two_axis, "genrou": genrou, "gentpj": gentpj, "gensal": gensal, "gensae": gensae}
