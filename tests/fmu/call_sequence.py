"""The call sequence of FMI 2.0.4, section 4.2.4: a SmibPlant in each of its phases, and every function called there.

One table for both kinds of FMU; test_call_sequence says what of it the Python kind can signal.
"""

from ctypes import c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p, create_string_buffer, pointer
from math import nan
from typing import Any

import pytest

from .instance import DISCARD, OK, Instance

PHASES = ("instantiated", "initialization", "step_complete", "step_failed", "terminated")

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

H = 0.01

DO_STEP_STATUS, PENDING_STATUS, LAST_SUCCESSFUL_TIME, TERMINATED_STATUS = range(4)


def cells(table: str, meaning: dict[str, Any]) -> list:
    """(function, phase, meaning of the letter) of every cell of a table with a line a function, a column a phase."""
    rows = [(line.split()[0], line.split()[1:]) for line in table.strip().splitlines()]
    return [
        pytest.param(function, phase, meaning[letter], id=f"{function}-{phase}")
        for function, letters in rows
        for phase, letter in zip(PHASES, letters, strict=True)
    ]


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
