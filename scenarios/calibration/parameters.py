"""What is fitted: logarithms of the machine's data and of E_f's scale, D, and what belongs to one record only."""

from typing import NamedTuple

import numpy as np

from .model import Machine

NAMES = {
    "two_axis": ("xd", "xd1", "xq", "xq1", "Td10", "Tq10", "H", "D", "k_f"),
    "genrou": ("xd", "xd1", "xq", "xq1", "xd2", "Td10", "Tq10", "Td20", "Tq20", "S", "H", "D", "k_f"),
}
"""k_f: scale of the recorded E_f; S: of both saturation factors."""

UNITS = dict.fromkeys(("Td10", "Tq10", "Td20", "Tq20", "H"), "s") | {"D": "s/rad", "k_f": "1", "S": "1"}
"""pu where it is not named."""

PRIOR_K_F = 0.5
"""Standard deviation of ln k_f: the base of E_f is the commonest mistake in the field."""

PRIOR_SUBTRANSIENT = 0.3
"""Of ln S: two readings of a curve; and of x'', T''d0, T''q0 where the data sheet does not have them."""

PRIOR_D = 1.0
"""pu torque per pu speed on the machine's own base, taken as that on which H is 4 s."""


class Free(NamedTuple):
    """The parameters that a fit moves; a value u is a logarithm relative to the data sheet, D's a difference."""

    names: tuple[str, ...]
    sheet: Machine
    spread: np.ndarray  # standard deviation of the prior of u, about 0


def free(order: str, sheet: Machine, names: tuple[str, ...], prior: float) -> Free:
    """The prior: the data sheet, log-normal with the standard deviation `prior`."""
    own = {"k_f": PRIOR_K_F, "S": PRIOR_SUBTRANSIENT, "D": float(PRIOR_D * sheet.H / 4 / sheet.omega_s)}
    return Free(names, sheet, np.array([own.get(name, prior) for name in names]))


def machine(f: Free, u: np.ndarray) -> tuple[Machine, np.ndarray]:
    """The candidates' data and k_f, (C,), of u (C, parameters)."""
    values = {name: np.broadcast_to(value, len(u)) for name, value in f.sheet._asdict().items()}
    k_f = np.ones(len(u))
    for name, column in zip(f.names, u.T, strict=True):
        if name == "k_f":
            k_f = np.exp(column)
        elif name == "S":
            values |= {key: values[key] * np.exp(column) for key in ("S10", "S12")}
        elif name == "D":
            values["D"] = values["D"] + column
        else:
            values[name] = values[name] * np.exp(column)
    return Machine(**values), k_f


def value(f: Free, name: str, u):
    """In its own unit, of u."""
    if name == "D":
        return f.sheet.D + u
    return np.exp(u) * (1.0 if name in ("k_f", "S") else getattr(f.sheet, name))
