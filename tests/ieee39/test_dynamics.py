"""Machines and controllers against an independent simulator, published modes, scipy, and rest."""

import csv
from itertools import product
from math import pi
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fmu_src.pmu_observer import tree
from fmu_src.pmu_observer.plants.ieee39.dynamics import States, derivative, equilibrium
from fmu_src.pmu_observer.plants.ieee39.modes import electromechanical_modes
from fmu_src.pmu_observer.plants.ieee39.plant import LOADS, Outputs, Parameters, grid_at

from .simulation import simulate

DATA = Path(__file__).parents[2] / "scenarios" / "data"
ROTOR = [States._fields.index(name) for name in ("delta", "e1d", "e1q")]


@pytest.mark.parametrize(("governors", "pss", "salient"), list(product((0, 1), repeat=3)))
def test_it_starts_at_rest(governors, pss, salient):
    system, x = equilibrium(governors, pss, salient)
    slopes = derivative(system, grid_at(Parameters(), np.zeros(len(LOADS)), 0.0), x)
    assert np.abs(slopes).max() < 1e-10


@pytest.mark.parametrize("governors", [1, 0])
def test_it_stays_at_rest_for_a_minute(governors):
    outputs = simulate(60.0, governors=governors).outputs
    outputs = outputs[:, [not name.endswith("t_frame") for name in tree.names(Outputs())]]
    assert np.abs(outputs - outputs[0]).max() < 1e-9


# Hz, %: an independent program's eigenvalues of the same data
MODES = {
    True: ".591/14.3 1.021/23.3 1.127/29.5 1.158/7.4 1.170/18.0 1.431/15.8 1.481/30.0 1.684/16.7 1.693/21.6",
    False: ".627/-2.6 .950/-3.2 1.010/-.3 1.123/2.1 1.127/.8 1.259/2.5 1.408/4.3 1.455/4.4 1.491/5.4",
}


@pytest.mark.parametrize("pss", [True, False])
def test_modes(pss):
    expected = np.array([mode.split("/") for mode in MODES[pss].split()], dtype=float)
    found = electromechanical_modes(governors=False, pss=pss, salient=False)
    assert [mode.frequency for mode in found] == pytest.approx(expected[:, 0], abs=0.002)
    assert [mode.damping for mode in found] == pytest.approx(expected[:, 1], abs=0.1)


def test_an_independent_record_of_a_load_step():
    """Generator 6 while bus 16 draws 50 MW + 10 Mvar more from 1 s to 11 s, simulated with ANDES 2.0.0."""
    with open(DATA / "record_g6.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    record = {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}
    run = simulate(20.0, t_step=1.0, t_step_end=11.0)
    # what both print alike, and the trapezoidal rule of 2 ms in the record leaves; E_f is a fast state of gain 200
    for names, tolerance in (
        (("V_t", "e1d", "e1q", "P_m"), 1e-5),
        (("theta_t", "phi_t", "delta"), 2e-5),
        (("I_t", "P_t", "Q_t"), 1e-4),
        (("E_f",), 1e-3),
    ):
        for name in names:
            assert np.abs(run[f"G6.{name}"] - record[name]).max() < tolerance, name
    assert np.abs(run["G6.omega"] / (2 * pi * 60) + 1 - record["speed"]).max() < 1e-7


@pytest.mark.parametrize(
    ("event", "times", "tolerance"),
    [
        # E_f meets its limits within a sub-step: 3e-4 rad
        ({"t_fault": 0.11, "t_clear": 0.213, "fault_bus": 16, "x_fault": 1e-4}, (0.11, 0.213), 5e-4),
        ({"t_trip": 0.11, "trip_from": 16, "trip_to": 17}, (0.11,), 1e-7),
    ],
    ids=["fault", "line trip"],
)
def test_events_between_frames_against_scipy(event, times, tolerance):
    p = Parameters(**event)
    system, start = equilibrium(p.governors, p.pss, p.salient)
    x, ends = start.ravel(), (*times, 1.0)
    for begin, end in zip((0.0, *times), ends, strict=True):
        grid = grid_at(p, np.zeros(len(LOADS)), begin)
        segment = solve_ivp(
            lambda t, x, grid=grid: derivative(system, grid, x.reshape(start.shape)).ravel(),
            (begin, end), x, method="RK45", rtol=1e-8, atol=1e-10,
        )  # fmt: skip
        x = segment.y[:, -1]
    found = np.array(simulate(1.0, **event).state.machines)
    assert np.abs(found - x.reshape(start.shape))[ROTOR].max() < tolerance


def test_a_fault_swings_and_comes_back():
    """Three-phase fault at bus 16, 0.1 s: E_f at its limits, the rotors within 180 degrees, then 60 Hz again."""
    run = simulate(20.0, t_fault=1.0, t_clear=1.1)
    E_f = np.array([run[f"G{k}.E_f"] for k in range(1, 11)])
    angles = np.array([run[f"G{k}.delta"] for k in range(1, 11)])
    assert E_f.max() == 5.0
    assert E_f.min() >= -5.0
    assert run["bus16.V"][60] < 0.1 < 0.9 < run["bus16.V"][66]
    assert 1.5 < np.ptp(angles, axis=0).max() < pi
    assert abs(run["frequency"][-1] - 60) < 2e-3
    assert np.ptp(angles, axis=0)[-1] == pytest.approx(np.ptp(angles, axis=0)[0], abs=2e-3)
