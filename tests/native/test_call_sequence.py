"""The call sequence of FMI 2.0.4, section 4.2.4, as one table: what is legal passes, what is not is refused.

After whatever was refused the instance is as it was, to the bit, and can be reset and run to the end.
"""

from ctypes import c_double, c_uint, pointer
from math import nan

import pytest

from ..fmu.call_sequence import LAST_SUCCESSFUL_TIME, H, bring_to, call_with_good_arguments, cells
from ..fmu.instance import DISCARD, ERROR, OK, Instance

# function: status in each of the PHASES; o = fmi2OK, d = fmi2Discard, E = fmi2Error
TABLE = """
    fmi2SetDebugLogging               o o o o o
    fmi2SetupExperiment               o E E E E
    fmi2EnterInitializationMode       o E E E E
    fmi2ExitInitializationMode        E o E E E
    fmi2Terminate                     E E o o E
    fmi2Reset                         o o o o o
    fmi2GetReal                       E o o o o
    fmi2GetInteger                    E o o o o
    fmi2GetBoolean                    E o o o o
    fmi2GetString                     E o o o o
    set_input                         o o o E E
    set_fixed_parameter               o o E E E
    fmi2SetInteger                    o o E E E
    set_output                        E E E E E
    fmi2SetBoolean                    o o o E E
    fmi2SetString                     o o o E E
    fmi2GetFMUstate                   o o o o o
    fmi2SetFMUstate                   o o o o o
    fmi2FreeFMUstate                  o o o o o
    fmi2SerializedFMUstateSize        o o o o o
    fmi2SerializeFMUstate             o o o o o
    fmi2DeSerializeFMUstate           o o o o o
    fmi2GetDirectionalDerivative      E E E E E
    fmi2SetRealInputDerivatives       E E E E E
    fmi2GetRealOutputDerivatives      E E E E E
    fmi2DoStep                        E E o E E
    fmi2CancelStep                    E E E E E
    fmi2GetStatus                     E E d d d
    fmi2GetRealStatus                 E E o o o
    fmi2GetIntegerStatus              E E d d d
    fmi2GetBooleanStatus              E E o o o
    fmi2GetStringStatus               E E d d d
"""

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
