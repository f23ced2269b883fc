"""The native kind keeps to the table of the call sequence: what is legal passes, what is not is refused.

After whatever was refused the instance is as it was, to the bit, and can be reset and run to the end.
"""

from ctypes import c_double, c_uint, pointer
from math import nan

import pytest

from ..fmu.call_sequence import LAST_SUCCESSFUL_TIME, TABLE, H, bring_to, call_with_good_arguments, cells
from ..fmu.instance import DISCARD, ERROR, OK, Instance

CELLS = cells(TABLE, {"o": OK, "d": DISCARD, "E": ERROR})


@pytest.fixture(scope="module")
def plant_path(native_dist):
    return native_dist / "native" / "SmibPlant.fmu"


@pytest.fixture(scope="module")
def loaded(plant_path):
    instance = Instance(plant_path, "plant")
    yield instance
    instance.free()


@pytest.fixture
def plant(loaded):
    assert loaded.call("fmi2Reset") == OK
    loaded.messages.clear()
    return loaded


def blob(plant: Instance) -> bytes:
    state = plant.slave.getFMUState()
    serialized = plant.slave.serializeFMUState(state)
    plant.slave.freeFMUState(state)
    return serialized


@pytest.mark.parametrize(("function", "phase", "status"), CELLS)
def test_the_table(plant, function, phase, status):
    bring_to(plant, phase)
    before, said = blob(plant), len(plant.messages)
    assert call_with_good_arguments(plant, function) == status
    if status == OK:
        assert plant.messages[said:] == []
        return
    assert len(plant.messages) == said + 1
    assert function in plant.messages[-1] or function.startswith("set_")
    assert blob(plant) == before
    assert plant.call("fmi2Reset") == OK
    bring_to(plant, "step_complete")
    assert plant.step(H, H) == OK


def test_a_tunable_parameter_may_be_set_between_steps(native_dist):
    observer = Instance(native_dist / "native" / "PmuObserver.fmu").initialise()
    reference, value = (c_uint * 1)(observer.variables["k_speed"].valueReference), (c_double * 1)(2.0)
    assert observer.step(0.0, H) == OK
    assert observer.call("fmi2SetReal", reference, 1, value) == OK
    assert observer.get("k_speed") == [2.0]
    observer.slave.terminate()
    assert observer.call("fmi2SetReal", reference, 1, value) == ERROR
    observer.free()


def test_after_a_step_that_failed_an_fmu_state_leads_on(plant):
    """FMI 2.0.4, fmi2DoStep: redoing a step needs the state from before it."""
    bring_to(plant, "step_complete")
    state = plant.slave.getFMUState()
    plant.set(V_inf=nan)
    assert plant.step(H, H) == DISCARD
    assert plant.step(H, H) == ERROR
    time = c_double()
    assert plant.call("fmi2GetRealStatus", LAST_SUCCESSFUL_TIME, pointer(time)) == OK
    assert time.value == H
    plant.slave.setFMUState(state)
    assert plant.step(H, H) == OK
    plant.slave.freeFMUState(state)
