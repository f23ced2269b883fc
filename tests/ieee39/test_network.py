"""The network against the published load flow, and against the flow through every single branch."""

import cmath

import numpy as np
import pytest

from fmu_src.pmu_observer.plants.ieee39 import network, plant, tables
from fmu_src.pmu_observer.plants.ieee39.plant import LOADS

from .simulation import simulate


def test_power_flow_is_the_published_one():
    V = network.power_flow().V
    bus = tables.numbers({name: tables.BUS[name] for name in ("V_report", "ang_report_deg")})
    # half a unit of the table's last digit: 1e-4 pu, 0.01 degrees
    assert np.abs(np.abs(V) - bus["V_report"]).max() < 0.5e-4
    assert np.abs(np.degrees(np.angle(V)) - bus["ang_report_deg"]).max() < 0.5e-2
    assert network.power_flow().S_generated[30] == pytest.approx(5.2081 + 1.9825j, abs=1e-4)


def branch_flows(V: np.ndarray, skipped: tuple = ()) -> np.ndarray:
    """P + jQ that leaves every bus through its branches, one pi section after the other."""
    S = np.zeros(39, dtype=complex)
    for fbus, tbus, r, x, b, tap in zip(*tables.branches(), strict=True):
        if {fbus, tbus} == set(skipped):
            continue
        behind_tap = V[fbus - 1] / tap
        series = (behind_tap - V[tbus - 1]) / complex(r, x)
        S[fbus - 1] += behind_tap * (series + behind_tap * 0.5j * b).conjugate()
        S[tbus - 1] += V[tbus - 1] * (V[tbus - 1] * 0.5j * b - series).conjugate()
    return S


@pytest.mark.parametrize(
    ("event", "skipped", "bus", "y"),
    [
        ({}, (), 1, 0),
        ({"load_sigma": 0.05}, (), 1, 0),
        ({"t_step": 0.2, "step_bus": 20, "step_P": 1.0, "step_Q": 0.4}, (), 20, (1 - 0.4j) / 0.9912**2),
        ({"t_fault": 0.2, "t_clear": 0.3, "fault_bus": 26, "x_fault": 0.02}, (), 26, 1 / 0.02j),
        ({"t_fault": 0.1, "t_clear": 0.2, "fault_bus": 26}, (), 1, 0),
        ({"t_trip": 0.2, "trip_from": 3, "trip_to": 2}, (2, 3), 1, 0),
        ({"t_step": 0.2, "salient": 1}, (), 16, (0.5 - 0.1j) / 1.0318**2),
    ],
    ids=["rest", "ambient", "load step", "fault", "cleared", "line trip", "salient"],
)
def test_every_bus_balances_at_an_event(event, skipped, bus, y):
    """The outputs at 0.2 s: what is generated leaves through branches, load (constant impedance) and fault."""
    run = simulate(0.2, **event)
    V = np.array([cmath.rect(run[f"bus{n}.V"][-1], run[f"bus{n}.theta"][-1]) for n in range(1, 40)])
    generated = np.zeros(39, dtype=complex)
    for k, at in enumerate(tables.machines(False).bus, 1):
        generated[at - 1] = complex(run[f"G{k}.P_t"][-1], run[f"G{k}.Q_t"][-1])
    load = network.power_flow().S_load * np.abs(V / network.power_flow().V) ** 2
    load[LOADS] *= 1 + np.array(run.state.loads)
    load[bus - 1] += np.abs(V[bus - 1]) ** 2 * np.conj(y)
    # 1e-3 where the table's rounded voltage enters, else rounding
    tolerance = 1e-3 if "t_step" in event else 1e-10
    assert np.abs(generated - load - branch_flows(V, skipped)).max() < tolerance


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"trip_from": 1, "trip_to": 20}, "no branch joins the two"),
        ({"trip_from": 35, "trip_to": 22}, "it would separate the buses 35 from the others"),
        ({"trip_from": 16, "trip_to": 19}, "it would separate the buses 19, 20, 33, 34 from the others"),
        ({"t_fault": 2.0, "t_clear": 1.0}, "t_clear"),
        ({"t_step": 2.0, "t_step_end": 1.0}, "t_step_end"),
    ],
)
def test_what_does_not_go_together_is_refused(parameters, message):
    broken = [rule for rule in plant.rules(None, plant.Parameters(**parameters), plant.Inputs()) if not rule.holds]
    assert any(message in rule.message for rule in broken)


def test_the_defaults_are_allowed():
    assert all(rule.holds for rule in plant.rules(None, plant.Parameters(), plant.Inputs()))
