"""The ten machines of the IEEE 39-bus system while the loads vary."""

from math import pi

import numpy as np

from fmu_src.pmu_observer import tree
from fmu_src.pmu_observer.machines.data import Machine
from fmu_src.pmu_observer.plants.ieee39 import plant, tables

from .frames import PERIOD, Truth


def simulate(seconds: float, **parameters) -> Truth:
    """Frames of the ten machines, the second axis; `parameters` are Ieee39Plant's."""
    p = plant.Parameters(**parameters)
    state, outputs = plant.start(None, p, plant.Inputs(), 0.0)
    rows = [tree.leaves(outputs.generators)]
    for k in range(round(seconds / PERIOD)):
        state, outputs = plant.step(None, p, state, plant.Inputs(), k * PERIOD, PERIOD)
        rows.append(tree.leaves(outputs.generators))
    names = tree.names(plant.Generator())
    columns = np.array(rows).reshape(len(rows), len(plant.GENERATORS), len(names)).transpose(2, 0, 1)
    g = dict(zip(names, columns, strict=True))
    m = tables.machines(p.salient)
    return Truth(
        machine=Machine(m.H, 0.0, m.xd, m.xd1, m.xq, m.xq1, m.Td10, m.Tq10, 0.0, 2 * pi * 60),
        V=g["frame.V_t"] * np.exp(1j * g["frame.theta_t"]),
        I=g["frame.I_t"] * np.exp(1j * g["frame.phi_t"]),
        **{name: g[name] for name in ("P_m", "E_f", "delta", "omega", "e1d", "e1q")},
    )
