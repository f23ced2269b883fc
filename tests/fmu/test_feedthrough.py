"""Outputs that depend on an input directly show it when they are read, in both kinds; reading changes nothing."""

from ctypes import c_double, c_uint
from math import inf, nan

import pytest

from .instance import DISCARD, OK, Instance

H = 1 / 60
PLANT = {"plant__V_t": 1.02, "plant__theta_t": 0.3, "plant__I_t": 0.8, "plant__phi_t": -0.2}


@pytest.fixture(scope="module", params=["python", "native"])
def folder(request):
    return request.getfixturevalue("dist" if request.param == "python" else "native_dist") / request.param


def state_of(instance):
    return instance.slave.serializeFMUState(instance.slave.getFMUState())


def test_the_terminal_at_an_infinite_bus_follows_it_at_once(folder):
    """x_line = 0: the terminal voltage is that of the bus, whatever the machine does."""
    plant = Instance(folder / "SmibPlant.fmu", "plant").initialise()
    for k, (V, theta) in enumerate([(1.0, 0.0), (0.9, 0.1), (1.1, -0.2)]):
        rotor = plant.get("delta", "omega", "e1d", "e1q")
        plant.set(V_inf=V, theta_inf=theta)
        assert plant.get("V_t", "theta_t") == pytest.approx([V, theta], abs=1e-12)
        assert plant.get("delta", "omega", "e1d", "e1q") == rotor
        assert plant.step(k * H, H) == OK
        assert plant.get("V_t", "theta_t") == pytest.approx([V, theta], abs=1e-12)
    plant.free()


def test_what_is_read_is_what_the_step_begins_with(folder):
    """The same run, with every output read twice between steps, or none."""
    channels = [Instance(folder / "PmuChannel.fmu", name, latency=0.02, seed=3) for name in ("read", "unread")]
    for channel in channels:
        channel.set(**PLANT)
        channel.initialise()
    once: list[float] = []
    for k in range(20):
        for channel in channels:
            assert channel.step(k * H, H) == OK
            channel.set(plant__V_t=1.0 + 0.01 * k, plant__theta_t=0.1 * k)
        once = channels[0].outputs()
        assert channels[0].outputs() == once
    assert channels[1].outputs() == once
    assert state_of(channels[1])[-4000:] == state_of(channels[0])[-4000:]
    for channel in channels:
        channel.free()


def test_a_channel_without_errors_shows_the_plant_at_the_same_instant(folder):
    plant = Instance(folder / "SmibPlant.fmu", "plant", x_line=0.2, start_mode=2, t_fault=0.1, t_clear=0.2)
    plant.initialise(P_m=0.5, E_f=1.5)
    channel = Instance(folder / "PmuChannel.fmu", "channel", tve=0.0)
    names = ("V_t", "theta_t", "I_t", "phi_t")

    def connect():
        channel.set(**{f"plant__{name}": value for name, value in zip(names, plant.get(*names), strict=True)})

    connect()
    channel.initialise()
    for k in range(30):
        connect()
        assert channel.get(*names) == pytest.approx(plant.get(*names), abs=1e-12)
        assert channel.get("t_frame", "frame_valid") == [pytest.approx(k * H, abs=1e-12), 1]
        for instance in (plant, channel):
            assert instance.step(k * H, H) == OK
    plant.free()
    channel.free()


def test_a_state_taken_between_setting_and_reading(folder):
    channel = Instance(folder / "PmuChannel.fmu", "channel")
    channel.set(**PLANT)
    channel.initialise()
    assert channel.step(0.0, H) == OK
    after_step, state = channel.outputs(), channel.slave.getFMUState()
    channel.set(plant__V_t=0.7)
    dirty = channel.slave.getFMUState()
    once = channel.outputs()
    assert once != after_step
    channel.slave.setFMUState(state)
    assert channel.outputs() == after_step
    channel.slave.setFMUState(dirty)
    assert channel.outputs() == once
    channel.free()


@pytest.mark.parametrize("value", [nan, inf])
def test_native_outputs_without_a_value_are_discarded(native_dist, value):
    plant = Instance(native_dist / "native" / "SmibPlant.fmu", "plant").initialise()
    plant.set(V_inf=value)
    reference = (c_uint * 1)(plant.variables["V_t"].valueReference)
    array = (c_double * 1)(5.0)
    assert plant.call("fmi2GetReal", reference, 1, array) == DISCARD
    assert array[0] == 5.0
    assert "the calculation of the outputs is not done" in plant.messages[-1]
    plant.set(V_inf=1.0)
    assert plant.step(0.0, H) == OK
    plant.free()
