"""FMU states: complete, repeatable to the bit, transferable, and a damaged one is refused."""

import pytest

from .instance import FRAME, OK, Instance

H = 1 / 60


@pytest.fixture
def pair(dist):
    """Plant and observer at 1 s, with what the observer holds by then."""
    plant = Instance(dist / "python" / "SmibPlant.fmu", "plant").initialise(P_m=0.1, E_f=0.1)
    observer = Instance(dist / "python" / "PmuObserver.fmu", "observer", estimator=1)
    observer.initialise(P_m=0.1, E_f=0.1, **dict(zip(FRAME, plant.get(*FRAME), strict=True)))
    run(plant, observer, 0, 60)
    yield plant, observer
    plant.free()
    observer.free()


def run(plant, observer, first, last):
    """Steps number `first` to `last`; every output of both at the end."""
    for k in range(first, last):
        observer.set(**dict(zip(FRAME, plant.get(*FRAME), strict=True)))
        assert plant.step(k * H, H) == OK
        assert observer.step(k * H, H) == OK
    return plant.outputs() + observer.outputs()


def test_rolling_back_repeats_to_the_bit(pair):
    plant, observer = pair
    states = [instance.slave.getFMUState() for instance in pair]
    once = run(plant, observer, 60, 90)
    for instance, state in zip(pair, states, strict=True):
        instance.slave.setFMUState(state)
    assert run(plant, observer, 60, 90) == once


def test_a_serialized_state_continues_in_another_instance(dist, pair):
    plant, observer = pair
    blob = observer.slave.serializeFMUState(observer.slave.getFMUState())
    other = Instance(dist / "python" / "PmuObserver.fmu", "other").initialise()
    other.slave.setFMUState(other.slave.deserializeFMUState(blob))
    plant_state = plant.slave.getFMUState()
    once = run(plant, observer, 60, 90)
    plant.slave.setFMUState(plant_state)
    assert run(plant, other, 60, 90) == once
    other.free()


@pytest.mark.parametrize(
    ("damage", "reason"),
    [
        (lambda blob: blob[:-9], "damaged"),
        (lambda blob: blob[:20], "damaged"),
        (lambda blob: blob[:100] + bytes([blob[100] ^ 1]) + blob[101:], "damaged"),
        (lambda blob: b"x" * len(blob), "damaged"),
    ],
    ids=["truncated", "headless", "one bit", "noise"],
)
def test_a_damaged_state_is_refused(pair, damage, reason):
    _, observer = pair
    before = observer.outputs()
    blob = observer.slave.serializeFMUState(observer.slave.getFMUState())
    observer.slave.setFMUState(observer.slave.deserializeFMUState(damage(blob)))
    assert reason in observer.messages[-1]
    assert observer.outputs() == before
    assert observer.step(1.0, H) == OK


def test_the_state_of_another_fmu_is_refused(pair):
    plant, observer = pair
    blob = plant.slave.serializeFMUState(plant.slave.getFMUState())
    observer.slave.setFMUState(observer.slave.deserializeFMUState(blob))
    assert "another FMU" in observer.messages[-1]


def test_reset_is_a_new_instance(dist, pair):
    _, observer = pair
    observer.slave.reset()
    fresh = Instance(dist / "python" / "PmuObserver.fmu", "fresh")
    assert observer.outputs() == fresh.outputs()
    observer.initialise(time=0.0)
    assert observer.step(0.0, H) == OK
    fresh.free()
