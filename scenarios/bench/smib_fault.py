"""The machine, the line and the fault of scenarios/smib_fault.toml: generator 6 of the IEEE 39-bus system."""

from functools import cache
from typing import Any, NamedTuple

import numpy as np

from fmu_src.pmu_observer.carriers import arrays
from fmu_src.pmu_observer.machines.data import Machine, ieee39_g6
from fmu_src.pmu_observer.plants import smib

from .. import loader
from .frames import PERIOD, Truth
from .machines import SUBSTEPS, Machines, simulate


class Fault(NamedTuple):
    """From t_fault to t_clear, s, through x_fault, pu."""

    t_fault: float
    t_clear: float
    x_fault: float


def machine() -> Machine:
    """With x'q := x'd, and the damping of the scenario."""
    return ieee39_g6()._replace(**scenario().parameters)


def fault(later: float = 0.0) -> Fault:
    """The scenario's, `later` seconds later: 7 ms more or less bring it from a frame to between two."""
    given = line()
    return Fault(given["t_fault"] + later, given["t_clear"] + later, given["x_fault"])


def plant(fault: Fault | None = None) -> Machines:
    """From the equilibrium for the scenario's P_m and V_t, with E_f constant."""
    events = fault._asdict() if fault else {}
    own = {name: value for name, value in line().items() if name not in Fault._fields}
    p = smib.Parameters(machine=machine(), **{**own, "start_mode": smib.P_M_V_T, **events})
    u = smib.Inputs(**scenario().inputs)
    _, outputs = smib.start(arrays, p, u, 0.0)
    return Machines(p, u._replace(E_f=outputs.E_f_start))


EXCITER_GAIN, EXCITER_LAG, CEILING = 100.0, 0.02, 5.0
"""1, s and pu: a fast static exciter, which a fault forces to its ceiling within two frames."""


def with_exciter(fault: Fault, seconds: float) -> Truth:
    """E_f by EXCITER_GAIN (V_ref - V_t) behind EXCITER_LAG, from 0 to CEILING."""
    machines = plant(fault)
    E_f, V_ref = machines.inputs.E_f, machines.parameters.V_t_start
    field = E_f
    h = PERIOD / SUBSTEPS

    def inputs(t, outputs: smib.Outputs) -> smib.Inputs:
        nonlocal field
        ordered = np.clip(E_f + EXCITER_GAIN * (V_ref - outputs.frame.V_t), 0.0, CEILING)
        field = field + h / EXCITER_LAG * (ordered - field)
        return machines.inputs._replace(E_f=field)

    return simulate(machines, seconds, inputs=inputs)


@cache
def scenario():
    return loader.load("smib_fault")


def line() -> dict[str, Any]:
    """The plant's own parameters."""
    return scenario().fmu["plant"].parameters
