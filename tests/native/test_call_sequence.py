"""The call sequence of FMI 2.0.4, section 4.2.4, as one table: what is legal passes, what is not is refused.

After whatever was refused the instance is as it was, to the bit, and can be reset and run to the end.
"""

from ctypes import c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p, create_string_buffer, pointer
from math import nan

import pytest

from ..fmu.instance import DISCARD, ERROR, OK, Instance

PHASES = ("instantiated", "initialization", "step_complete", "step_failed", "terminated")

H = 0.01

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

ROWS = [(line.split()[0], line.split()[1:]) for line in TABLE.strip().splitlines()]
CELLS = [
    pytest.param(function, phase, {"o": OK, "d": DISCARD, "E": ERROR}[letter], id=f"{function}-{phase}")
    for function, letters in ROWS
    for phase, letter in zip(PHASES, letters, strict=True)
]

DO_STEP_STATUS, PENDING_STATUS, LAST_SUCCESSFUL_TIME, TERMINATED_STATUS = range(4)


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


def bring_to(plant: Instance, phase: str) -> None:
    """Instantiated, to one of the PHASES."""
    if phase == "instantiated":
        return
    plant.slave.setupExperiment(startTime=0.0)
    plant.slave.enterInitializationMode()
    if phase == "initialization":
        return
    plant.slave.exitInitializationMode()
    assert plant.step(0.0, H) == OK
    if phase == "step_failed":
        plant.set(V_inf=nan)
        assert plant.step(H, H) == DISCARD
    if phase == "terminated":
        plant.slave.terminate()


def blob(plant: Instance) -> bytes:
    state = plant.slave.getFMUState()
    serialized = plant.slave.serializeFMUState(state)
    plant.slave.freeFMUState(state)
    return serialized


def call_with_good_arguments(plant: Instance, function: str) -> int:
    reference = {name: (c_uint * 1)(variable.valueReference) for name, variable in plant.variables.items()}
    real, integer, size = (c_double * 1)(1.0), (c_int * 1)(1), c_size_t()
    state = c_void_p()
    assert plant.call("fmi2GetFMUstate", pointer(state)) == OK
    assert plant.call("fmi2SerializedFMUstateSize", state, pointer(size)) == OK
    content = create_string_buffer(size.value)
    assert plant.call("fmi2SerializeFMUstate", state, content, size.value) == OK
    arguments = {
        "fmi2SetDebugLogging": (1, 0, None),
        "fmi2SetupExperiment": (0, 0.0, 0.0, 1, 1.0),
        "fmi2GetReal": (reference["delta"], 1, real),
        "fmi2GetInteger": (reference["start_mode"], 1, integer),
        "fmi2GetBoolean": (None, 0, None),
        "fmi2GetString": (None, 0, None),
        "set_input": (reference["V_inf"], 1, real),
        "set_fixed_parameter": (reference["H"], 1, real),
        "fmi2SetInteger": (reference["start_mode"], 1, integer),
        "set_output": (reference["delta"], 1, real),
        "fmi2SetBoolean": (None, 0, None),
        "fmi2SetString": (None, 0, None),
        "fmi2GetFMUstate": (pointer(c_void_p()),),
        "fmi2SetFMUstate": (state,),
        "fmi2FreeFMUstate": (pointer(state),),
        "fmi2SerializedFMUstateSize": (state, pointer(size)),
        "fmi2SerializeFMUstate": (state, content, size.value),
        "fmi2DeSerializeFMUstate": (content, size.value, pointer(c_void_p())),
        "fmi2GetDirectionalDerivative": (reference["delta"], 1, reference["V_inf"], 1, real, real),
        "fmi2SetRealInputDerivatives": (reference["V_inf"], 1, integer, real),
        "fmi2GetRealOutputDerivatives": (reference["delta"], 1, integer, real),
        "fmi2DoStep": (H, H, 1),
        "fmi2GetStatus": (DO_STEP_STATUS, integer),
        "fmi2GetRealStatus": (LAST_SUCCESSFUL_TIME, real),
        "fmi2GetIntegerStatus": (DO_STEP_STATUS, integer),
        "fmi2GetBooleanStatus": (TERMINATED_STATUS, integer),
        "fmi2GetStringStatus": (PENDING_STATUS, pointer(c_char_p())),
    }.get(function, ())
    return plant.call("fmi2SetReal" if function.startswith("set_") else function, *arguments)


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
