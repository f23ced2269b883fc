"""Right records: ten machines of the IEEE 39-bus system as a PMU sees them.

In ambient operation, with a fault, a load step and a line trip; at 25 to 120 frames/s; total vector error (TVE) of 0 to
1 %.
"""

from collections.abc import Callable, Iterator
from math import ceil, pi

import numpy as np

from fmu_src.pmu_observer.carriers import floats
from fmu_src.pmu_observer.plants.ieee39 import plant, tables

from ..machines.table import Machine
from .standard import Facts, StandardRecord, assemble

OMEGA_S = 2 * pi * 60

EVENTS: dict[str, dict[str, float]] = {
    "ambient": {"load_sigma": 0.01},
    "fault": {"load_sigma": 0.003, "t_fault": 3.0, "t_clear": 3.1, "x_fault": 0.01},
    "load step": {"load_sigma": 0.003, "t_step": 3.0, "step_P": 2.0},
    "line trip": {"load_sigma": 0.003, "t_trip": 3.0},
}
"""Parameters of the plant."""

RATES = {120: (120, 60, 30), 50: (50, 25)}
"""Frames per second that are simulated, and those that are taken of them."""

TVES = (0.0, 0.001, 0.003, 0.005, 0.01)

SECONDS = 8.0


def machines() -> dict[str, Machine]:
    """The ten machines on a plausible rating of their own: they run at about 80 %. G1 stands for a whole network."""
    m = tables.machines(salient=False)
    _, shown = plant.start(floats, plant.Parameters(), plant.Inputs(), 0.0)
    found = {}
    for k, name in enumerate(plant.GENERATORS):
        frame = getattr(shown.generators, name).frame
        S_n = 10_000.0 if name == "G1" else 50.0 * ceil(frame.V_t * frame.I_t * 100 / 0.85 / 50)
        up = S_n / 100
        data: dict[str, float | str] = {n: float(getattr(m, n)[k]) * up for n in ("xd", "xd1", "xq", "xq1")}
        data |= {"H": float(m.H[k]) / up, "Td10": float(m.Td10[k]), "Tq10": float(m.Tq10[k]), "D": 0.0, "Ra": 0.0}
        found[name] = Machine(name, {"machine_model": "two_axis", "S_n": S_n, "omega_s": OMEGA_S, **data})
    return found


def right_records(
    progress: Callable[[float], None] = lambda done: None,
    events: dict[str, dict[str, float]] = EVENTS,
    rates: dict[int, tuple[int, ...]] = RATES,
    seconds: float = SECONDS,
) -> Iterator[tuple[StandardRecord, Machine]]:
    """Each event at each rate; the noise differs from machine to machine."""
    rng = np.random.default_rng(20260101)
    units = machines()
    runs = [(event, fine) for event in events for fine in rates]
    for i, (event, fine) in enumerate(runs):
        columns = simulated(plant.Parameters(**events[event]), fine, seconds)
        for rate in rates[fine]:
            for k, (name, machine) in enumerate(units.items()):
                tve = TVES[(k + i + rate) % len(TVES)]
                every = {n: c[k, :: fine // rate] for n, c in columns.items()}
                source = f"{name}, {event}, {rate}/s, TVE {tve:.1%}"
                yield recorded(every, rate, tve, source, rng), machine
        progress((i + 1) / len(runs))


def simulated(p: plant.Parameters, rate: int, seconds: float) -> dict[str, np.ndarray]:
    """The columns of a record, one row a generator."""
    names = ("V_t", "theta_t", "I_t", "phi_t", "P_m", "E_f")
    steps = round(seconds * rate)
    table = np.zeros((len(names), len(plant.GENERATORS), steps))
    state, shown = plant.start(floats, p, plant.Inputs(), 0.0)
    for n in range(steps):
        for k, g in enumerate(shown.generators):
            table[:, k, n] = (g.frame.V_t, g.frame.theta_t, g.frame.I_t, g.frame.phi_t, g.P_m, g.E_f)
        state, shown = plant.step(floats, p, state, plant.Inputs(), n / rate, 1 / rate)
    return dict(zip(names, table, strict=True))


def recorded(
    columns: dict[str, np.ndarray], rate: int, tve: float, source: str, rng: np.random.Generator
) -> StandardRecord:
    """With noise of E|n|^2 = (tve |.|)^2 on V and I, and a frequency from theta, as a PMU makes it."""
    V, I = (  # noqa: E741 - the paper's name
        columns[m] * np.exp(1j * columns[a]) for m, a in (("V_t", "theta_t"), ("I_t", "phi_t"))
    )
    f = 60 + np.gradient(np.unwrap(columns["theta_t"])) * rate / (2 * pi)
    noise = rng.standard_normal((4, len(V))) * tve / np.sqrt(2)
    V, I = V * (1 + noise[0] + 1j * noise[1]), I * (1 + noise[2] + 1j * noise[3])  # noqa: E741 - the paper's name
    time = np.arange(len(V)) / rate
    found = {"time": time, "V_t": np.abs(V), "theta_t": np.angle(V), "I_t": np.abs(I), "phi_t": np.angle(I), "f": f}
    facts = Facts(rate=float(rate), f0=60.0, source=source)
    return assemble({**found, "P_m": columns["P_m"], "E_f": columns["E_f"]}, facts)
