"""Random machines behind a line, and what their PMUs see."""

from math import pi
from typing import NamedTuple

import numpy as np

from fmu_src.pmu_observer.carriers import arrays
from fmu_src.pmu_observer.machines.data import Machine
from fmu_src.pmu_observer.plants import smib

from .frames import PERIOD, Truth
from .streams import MACHINES, Streams, numbers

SUBSTEPS = 8
"""Steps of the plant between two frames, at most 2.1 ms."""

FARTHEST = np.radians(100)
"""Of a rotor from the infinite bus: beyond 90 degrees, where the field's slow answer alone still holds it."""


class Range(NamedTuple):
    low: float
    high: float
    logarithmic: bool = False


RANGES = {
    "H [s]": Range(2.0, 10.0),
    "D [pu/pu]": Range(0.0, 2.0),
    "x' [pu]": Range(0.1, 0.57),
    "xd - x' [pu]": Range(0.4, 1.8),
    "xq/xd": Range(0.6, 1.0),
    "T'd0 [s]": Range(3.0, 10.0),
    "T'q0 [s]": Range(0.03, 2.0, logarithmic=True),
    "x_line [pu]": Range(0.1, 0.4),
    "P [pu]": Range(0.0, 0.95),
    "Q [pu]": Range(-0.35, 0.6),
    "V_t [pu]": Range(0.95, 1.05),
    "initial error of delta [rad]": Range(-0.2, 0.2),
    "initial error of omega [rad/s]": Range(-1.0, 1.0),
    "initial error of E'd [pu]": Range(-0.1, 0.1),
    "initial error of E'q [pu]": Range(-0.1, 0.1),
}
"""Random machines, pu on their own base: uniform, or uniform in the logarithm. x'd = x'q = x'."""


class Machines(NamedTuple):
    parameters: smib.Parameters
    inputs: smib.Inputs


def random_machines(count: int, seed: int, first: int = 0) -> Machines:
    """From RANGES: each at an equilibrium for its P, Q and V_t, moved away from it by the initial errors.

    Machine `first` + i is the same however many there are. Nearly unstable points (x_line such that the rotor is beyond
    FARTHEST from the infinite bus) are drawn again.
    """
    streams = Streams(MACHINES + numbers(seed, count, first))
    draw = drawn(streams)
    while np.any(far := rotor_angle_from_bus(draw) > FARTHEST):
        again = drawn(streams)
        draw = {name: np.where(far, again[name], values) for name, values in draw.items()}
    V, I, x = draw["V_t [pu]"] + 0j, current(draw), draw["x' [pu]"]  # noqa: E741 - the paper's name
    xd = x + draw["xd - x' [pu]"]
    xq = np.maximum(draw["xq/xd"] * xd, x)
    m = Machine(
        H=draw["H [s]"],
        D=draw["D [pu/pu]"] / (2 * pi * 60),
        xd=xd,
        xd1=x,
        xq=xq,
        xq1=x,
        Td10=draw["T'd0 [s]"],
        Tq10=draw["T'q0 [s]"],
        Ra=0.0,
        omega_s=2 * pi * 60,
    )
    bus = V - 1j * draw["x_line [pu]"] * I
    delta = np.angle(V + 1j * xq * I)
    axes = 1j * I * np.exp(-1j * delta)  # Id + j Iq
    E = 1j * (V + 1j * x * I) * np.exp(-1j * delta)  # E'd + j E'q
    parameters = smib.Parameters(
        machine=m,
        x_line=draw["x_line [pu]"],
        start_mode=smib.STATES,
        delta_start=delta + draw["initial error of delta [rad]"],
        omega_start=draw["initial error of omega [rad/s]"],
        e1d_start=E.real + draw["initial error of E'd [pu]"],
        e1q_start=E.imag + draw["initial error of E'q [pu]"],
    )
    inputs = smib.Inputs(
        P_m=draw["P [pu]"],
        E_f=E.imag + (xd - x) * axes.real,
        V_inf=np.abs(bus),
        theta_inf=np.angle(bus),
    )
    return Machines(parameters, inputs)


def drawn(streams: Streams) -> dict[str, np.ndarray]:
    found = {}
    for name, r in RANGES.items():
        low, high = (np.log(r.low), np.log(r.high)) if r.logarithmic else (r.low, r.high)
        value = streams.uniform(low, high)
        found[name] = np.exp(value) if r.logarithmic else value
    return found


def current(draw):
    return np.conj((draw["P [pu]"] + 1j * draw["Q [pu]"]) / draw["V_t [pu]"])


def rotor_angle_from_bus(draw):
    x = draw["x' [pu]"]
    xq = np.maximum(draw["xq/xd"] * (x + draw["xd - x' [pu]"]), x)
    I = current(draw)  # noqa: E741 - the paper's name
    V = draw["V_t [pu]"]
    return np.angle((V + 1j * xq * I) / (V - 1j * draw["x_line [pu]"] * I))


def simulate(machines: Machines, seconds: float, *, inputs=None, substeps: int = SUBSTEPS) -> Truth:
    """Frames of a plant. `inputs(t, outputs)` gives its inputs for the substep about t, if they are not constant."""
    p, u = machines
    state, outputs = smib.start(arrays, p, u, 0.0)
    h = PERIOD / substeps
    rows = [row(outputs, u)]
    for k in range(round(seconds / PERIOD)):
        for i in range(substeps):
            t = k * PERIOD + i * h
            if inputs:
                u = inputs(t + h / 2, outputs)
            state, outputs = smib.step(arrays, p, state, u, t, h)
        rows.append(row(outputs, u))
    V, I, *rest = [np.array(column) for column in zip(*rows, strict=True)]  # noqa: E741 - the paper's name
    return Truth(p.machine, V, I, *rest)


def row(o: smib.Outputs, u: smib.Inputs):
    f = o.frame
    shape = np.shape(o.delta)
    P_m, E_f = np.broadcast_to(u.P_m, shape), np.broadcast_to(u.E_f, shape)
    return f.V_t * np.exp(1j * f.theta_t), f.I_t * np.exp(1j * f.phi_t), P_m, E_f, o.delta, o.omega, o.e1d, o.e1q
