"""Runs that begin at -1 s, at 0 s and in UTC seconds: the same events, the same estimates, in both kinds of FMU.

At 1.7e9 s doubles are 2.4e-7 s apart: a step is that much longer or shorter than at 0 s, and so is a frame's time.
"""

import numpy as np
import pytest

from fmu_src.systems.smib import SYSTEM

from .instance import OK, Instance

H = 1 / 64
"""s; exact in every clock but for where it begins."""

STATES = ("delta", "omega", "e1d", "e1q")
FRAME = ("V_t", "theta_t", "I_t", "phi_t", "P_t", "Q_t", "P_m", "E_f", "t_frame")
UTC = 1.7e9


@pytest.fixture(scope="module", params=["python", "native"])
def folder(request):
    return request.getfixturevalue("dist" if request.param == "python" else "native_dist") / request.param


def run(folder, begin: float, h: float, steps: int) -> np.ndarray:
    """States of plant and observer; a fault of 6/64 s begins 1 s after the start, at t = 0 for a start at -1 s."""
    starts = SYSTEM.sets["ieee39_g6_fault"]
    plant, channel, observer = (
        Instance(folder / f"{name}.fmu", name) for name in ("SmibPlant", "PmuChannel", "PmuObserver")
    )
    instances = {"plant": plant, "channel": channel, "observer": observer}
    for name, instance in instances.items():
        instance.set(**{key.split(".", 1)[1]: value for key, value in starts.items() if key.startswith(f"{name}.")})
    plant.set(t_fault=begin + 1.0, t_clear=begin + 1.0 + 6 / 64)
    channel.set(tve=0.0, rate=64.0)
    observer.set(tve=1e-3)

    def exchange():
        values = plant.get(*FRAME[:4], "P_m_out", "E_f_out", "t_frame")
        channel.set(**dict(zip(CHANNEL, values, strict=True)))
        observer.set(**dict(zip(FRAME, channel.get(*FRAME), strict=True)))

    for instance in instances.values():
        instance.slave.setupExperiment(startTime=begin, stopTime=begin + steps * h)
        instance.slave.enterInitializationMode()
    exchange()
    for instance in instances.values():
        instance.slave.exitInitializationMode()
    rows = []
    for k in range(steps):
        exchange()
        for instance in instances.values():
            assert instance.step(begin + k * h, h) == OK
            assert instance.step(begin + k * h, h) != OK  # a repeated step is no step
        rows.append(plant.get(*STATES) + observer.get(*STATES, "status"))
    for instance in instances.values():
        instance.free()
    return np.array(rows)


CHANNEL = [f"plant__{name}" for name in (*FRAME[:4], "P_m", "E_f", "t_frame")]


def test_where_a_run_begins_makes_no_difference(folder):
    """To the bit where the clock holds every time exactly, as it does with steps of 1/64 s from any whole second."""
    reference = run(folder, 0.0, H, 110)
    assert np.abs(np.diff(reference[:, 1])).max() > 0.01  # the fault is there
    assert np.array_equal(run(folder, -1.0, H, 110), reference)
    assert np.array_equal(run(folder, UTC, H, 110), reference)


def test_steps_that_the_clock_cannot_hold(native_dist):
    """1/60 s in UTC: a time is rounded by up to 1.2e-7 s, in which a rotor at 5 rad/s turns 6e-7 rad."""
    reference, found = (run(native_dist / "native", begin, 1 / 60, 120) for begin in (0.0, UTC))
    assert np.abs(found - reference).max() < 1e-4
    assert np.array_equal(found[:, -1], reference[:, -1])


@pytest.mark.parametrize("begin", [-1.0, UTC])
def test_the_39_bus_system_has_the_same_events(dist, begin):
    """Load variation, a load step, a fault and a trip, and nothing that has passed before it begins."""

    def outputs(at: float) -> np.ndarray:
        plant = Instance(dist / "python" / "Ieee39Plant.fmu", load_sigma=0.01)
        plant.set(t_step=at + 0.25, t_fault=at + 0.5, t_clear=at + 0.5625, t_trip=at + 0.75)
        plant.initialise(at)
        rows = []
        for k in range(64):
            assert plant.step(at + k * H, H) == OK
            rows.append(plant.get("G6.V_t", "G6.omega", "bus16.V", "G1.e1q"))
        plant.free()
        return np.array(rows)

    assert outputs(begin) == pytest.approx(outputs(0.0), abs=1e-5)
    plant = Instance(dist / "python" / "Ieee39Plant.fmu").initialise(begin)
    before = plant.get("G6.V_t")[0]
    assert plant.step(begin, H) == OK
    assert plant.get("G6.V_t")[0] == pytest.approx(before, abs=1e-9)  # no branch is open
    plant.free()
