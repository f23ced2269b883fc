"""What the Python kind can signal of the call sequence; the native kind's table is in tests/native.

Its wrapper returns the slave's status for doStep alone: what else is refused returns fmi2OK, and is logged as an error.
Functions that the wrapper does not support (fmi2CancelStep, fmi2GetStatus, derivatives) are not in the table: without
asking the slave it returns fmi2Error or fmi2Discard, and logs with a NULL category.
"""

import pytest

from .call_sequence import H, bring_to, call_with_good_arguments, cells
from .instance import DISCARD, OK, Instance

# function: in each of the PHASES; o = fmi2OK, r = fmi2OK, but refused and logged, d = fmi2Discard, refused and logged
TABLE = """
    fmi2SetDebugLogging               o o o o o
    fmi2SetupExperiment               o o o o o
    fmi2EnterInitializationMode       o r r r r
    fmi2ExitInitializationMode        r o r r r
    fmi2Terminate                     o o o o o
    fmi2Reset                         o o o o o
    fmi2GetReal                       o o o o o
    fmi2GetInteger                    o o o o o
    fmi2GetBoolean                    o o o o o
    fmi2GetString                     o o o o o
    set_input                         o o o o r
    set_fixed_parameter               o o r r r
    fmi2SetInteger                    o o r r r
    set_output                        r r r r r
    fmi2SetBoolean                    o o o o o
    fmi2SetString                     o o o o o
    fmi2GetFMUstate                   o o o o o
    fmi2SetFMUstate                   o o o o o
    fmi2FreeFMUstate                  o o o o o
    fmi2SerializedFMUstateSize        o o o o o
    fmi2SerializeFMUstate             o o o o o
    fmi2DeSerializeFMUstate           o o o o o
    fmi2DoStep                        d d o d d
    fmi2GetRealStatus                 o o o o o
    fmi2GetBooleanStatus              o o o o o
"""

MEANING = {"o": (OK, False), "r": (OK, True), "d": (DISCARD, True)}
"""Status, and whether there is a message."""


@pytest.mark.parametrize(("function", "phase", "expected"), cells(TABLE, MEANING))
def test_the_table(dist, function, phase, expected):
    """The instance survives whatever is refused, with the same outputs."""
    plant = Instance(dist / "python" / "SmibPlant.fmu", "plant")
    bring_to(plant, phase)
    before, said = plant.outputs(), len(plant.messages)
    status = call_with_good_arguments(plant, function)
    assert (status, len(plant.messages) > said) == expected
    if expected != MEANING["o"]:
        assert plant.outputs() == before
        assert plant.call("fmi2Reset") == OK
        bring_to(plant, "step_complete")
        assert plant.step(H, H) == OK
    plant.free()
