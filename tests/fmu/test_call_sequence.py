"""The Python kind keeps to the table of the call sequence too, as far as its wrapper can signal it.

The wrapper returns the slave's status for doStep alone, as fmi2Discard: what else is refused returns fmi2OK, and is
logged as an error. It answers some functions without asking the slave, and logs with a NULL category.
"""

import pytest

from .call_sequence import TABLE, H, bring_to, call_with_good_arguments, cells
from .instance import DISCARD, OK, Instance

ANSWERED_BY_THE_WRAPPER = {
    *("fmi2CancelStep", "fmi2GetStatus", "fmi2GetRealStatus", "fmi2GetIntegerStatus"),
    *("fmi2GetBooleanStatus", "fmi2GetStringStatus"),
    *("fmi2GetDirectionalDerivative", "fmi2SetRealInputDerivatives", "fmi2GetRealOutputDerivatives"),
}

OF_THE_SLAVE = "\n".join(line for line in TABLE.strip().splitlines() if line.split()[0] not in ANSWERED_BY_THE_WRAPPER)


@pytest.mark.parametrize(("function", "phase", "refused"), cells(OF_THE_SLAVE, {"o": False, "E": True}))
def test_the_table(dist, function, phase, refused):
    """The instance survives whatever is refused, with the same outputs."""
    plant = Instance(dist / "python" / "SmibPlant.fmu", "plant")
    bring_to(plant, phase)
    before, said = plant.outputs(), len(plant.messages)
    status = call_with_good_arguments(plant, function)
    assert status == (DISCARD if refused and function == "fmi2DoStep" else OK)
    assert (len(plant.messages) > said) == refused
    if refused:
        assert plant.outputs() == before
        assert plant.call("fmi2Reset") == OK
        bring_to(plant, "step_complete")
        assert plant.step(H, H) == OK
    plant.free()
