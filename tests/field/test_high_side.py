"""A PMU above the step-up transformer: as good as at the terminal, and what it costs if its data are wrong."""

import numpy as np
import pytest

from scenarios.studies import high_side


@pytest.fixture(scope="module")
def errors() -> dict[str, np.ndarray]:
    """(delta, E'd, E'q) x frames x seeds, by case."""
    found, _ = high_side.study(tve=0.002, seeds=3, estimated=False)
    return {name: found[:, :, i] for i, name in enumerate(high_side.CASES)}


def rms(e: np.ndarray) -> np.ndarray:
    return np.sqrt(np.mean(e**2, axis=(1, 2)))


def test_as_good_as_at_the_terminal(errors):
    assert (rms(errors["high side, transformer right"]) < 1.2 * rms(errors["at the terminal"])).all()


@pytest.mark.parametrize(
    ("case", "delta", "e1q"),
    [("x_T + 10 %", 0.19, 0.0031), ("x_T - 10 %", -0.19, 0.0031), ("tap + 2.5 %", -1.08, 0.028)],
)
def test_what_a_wrong_transformer_costs(case, delta, e1q, errors):
    """deg and pu: by the steady state's phasors, E' = V + j x' I on a terminal that is off; +-15 %: the swing."""
    assert np.degrees(errors[case][0].mean()) == pytest.approx(delta, rel=0.15)
    assert rms(errors[case])[2] == pytest.approx(e1q, rel=0.15)
