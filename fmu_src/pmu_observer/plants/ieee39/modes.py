"""Modal analysis at the operating point: python -m fmu_src.pmu_observer.plants.ieee39.modes [--help]"""

import argparse
from math import pi
from typing import List, NamedTuple

import numpy as np

from .dynamics import States, derivative, equilibrium
from .plant import AT_REST, GENERATORS, Parameters, grid_at

LOWEST_FREQUENCY = 0.1
"""Hz; what is slower is no swing of rotors against each other: all rotors together, regulators."""


class Mode(NamedTuple):
    """A pair of complex eigenvalues."""

    frequency: float  # Hz
    damping: float  # %, -100 Re/|eigenvalue|
    participation: np.ndarray  # (10,) of the generators' speeds; all states' participations have the sum 1


def jacobian(governors: bool, pss: bool, salient: bool, difference=1e-6) -> np.ndarray:
    """d(dx/dt)/dx at the equilibrium, (120, 120), by central differences: right to about 1e-8."""
    system, x = equilibrium(governors, pss, salient)
    grid = grid_at(Parameters(), np.array(AT_REST.loads), 0.0)
    moves = difference * np.eye(x.size).reshape(-1, *x.shape)
    slopes = [derivative(system, grid, x + move) - derivative(system, grid, x - move) for move in moves]
    return np.array(slopes).reshape(x.size, x.size).T / (2 * difference)


def electromechanical_modes(governors: bool, pss: bool, salient: bool) -> List[Mode]:
    """The nine oscillations of the ten rotors: those that the speeds participate in most; by frequency."""
    eigenvalues, right = np.linalg.eig(jacobian(governors, pss, salient))
    # Kundur (1994), 12.2.4: right times left eigenvector, element by element
    participations = np.abs(right * np.linalg.inv(right).T)
    participations /= participations.sum(axis=0)
    of_speeds = participations.reshape(len(States._fields), len(GENERATORS), -1)[States._fields.index("omega")]
    found = [
        Mode(value.imag / (2 * pi), -100 * value.real / abs(value), share)
        for value, share in zip(eigenvalues, of_speeds.T)
        if value.imag > 2 * pi * LOWEST_FREQUENCY
    ]
    found.sort(key=lambda mode: -mode.participation.sum())
    return sorted(found[: len(GENERATORS) - 1], key=lambda mode: mode.frequency)


def main() -> None:
    parser = argparse.ArgumentParser(description="Electromechanical modes of the IEEE 39-bus system.")
    parser.add_argument("--no-pss", action="store_true", help="without power system stabilisers")
    parser.add_argument("--governors", action="store_true", help="with the plant's governors")
    parser.add_argument("--salient", action="store_true", help="with x'q of the table instead of x'q := x'd")
    arguments = parser.parse_args()
    print("   Hz   damping %   participation of the speeds")
    for frequency, damping, share in electromechanical_modes(
        arguments.governors, not arguments.no_pss, arguments.salient
    ):
        leading = sorted(zip(share, GENERATORS), reverse=True)[:4]
        print(f"{frequency:6.3f} {damping:8.1f}      " + "  ".join(f"{name} {value:.2f}" for value, name in leading))


if __name__ == "__main__":
    main()
