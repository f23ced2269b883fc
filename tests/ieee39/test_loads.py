"""The loads' variation: its statistics, and that it repeats, whatever the communication steps."""

import math

import numpy as np
import pytest

from fmu_src.pmu_observer import tree
from fmu_src.pmu_observer.plants.ieee39 import plant
from fmu_src.pmu_observer.plants.ieee39.plant import LOADS, TICK, Parameters
from tests.fmu.instance import OK, Instance

from .simulation import resume, simulate

SIGMA, TAU = 0.01, 2.0


def test_it_is_an_ornstein_uhlenbeck_process():
    p = Parameters(load_sigma=SIGMA, load_tau=0.1, seed=3)
    n = np.zeros((20_000, len(LOADS)))
    for tick in range(1, len(n)):
        n[tick] = plant.varied(p, n[tick - 1], tick)
    n = n[1000:]
    # 19 loads, 19 000 ticks of which one in 12 is independent: 0.4 % of a standard deviation, 0.006 of a correlation
    assert n.std() == pytest.approx(SIGMA, rel=0.02)
    assert np.mean(n[6:] * n[:-6]) / SIGMA**2 == pytest.approx(math.exp(-6 * TICK / 0.1), abs=0.03)
    between = np.corrcoef(n.T) - np.eye(len(LOADS))
    assert np.abs(between).max() < 0.15


def test_a_seed_repeats_to_the_bit_and_another_differs():
    first, again, other = (simulate(0.5, load_sigma=SIGMA, seed=seed).outputs for seed in (7, 7, 8))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


def test_a_rolled_back_run_repeats_to_the_bit():
    p = Parameters(load_sigma=SIGMA, seed=1, t_fault=0.55, t_clear=0.62)
    half = simulate(0.5, **p._asdict())
    saved = tree.leaves(half.state)
    once = resume(p, half.state, [], 30, 60)
    again = resume(p, tree.like(plant.AT_REST, saved), [], 30, 60)
    assert np.array_equal(once.outputs, again.outputs)
    assert once.state == again.state


def test_the_loads_do_not_depend_on_the_communication_step():
    frames, coarse = (simulate(1.2, h, load_sigma=SIGMA, t_trip=0.31) for h in (1 / 60, 0.1))
    assert frames.state.loads == coarse.state.loads
    # the changes of the loads divide the coarse steps as the frames do
    assert np.abs(frames.outputs[::6] - coarse.outputs).max() < 1e-9


@pytest.mark.parametrize("seed", [0, 1])
def test_ambient_frequency_stays_within_20_millihertz(seed):
    f = simulate(20.0, load_sigma=SIGMA, seed=seed)["frequency"]
    assert 2e-3 < np.abs(f - 60).max() < 0.020


def test_the_fmu_is_the_plant(dist):
    """Variables by name, and a state that is serialized and continued elsewhere."""
    event = {"load_sigma": SIGMA, "seed": 5, "t_fault": 0.2, "t_clear": 0.3, "fault_bus": 35}
    path = dist / "python" / "Ieee39Plant.fmu"
    one, other = Instance(path, "one", **event).initialise(), Instance(path, "other").initialise()
    for k in range(15):
        assert one.step(k / 60, 1 / 60) == OK
    blob = one.slave.serializeFMUState(one.slave.getFMUState())
    other.slave.setFMUState(other.slave.deserializeFMUState(blob))
    for k in range(15, 30):
        assert other.step(k / 60, 1 / 60) == OK
    run = simulate(0.5, **event)
    names = ["frequency", "G6.V_t", "G6.e1d", "G10.Q_t", "G1.delta", "bus39.theta"]
    assert other.get(*names) == [run[name][-1] for name in names]
    for instance in (one, other):
        instance.free()
