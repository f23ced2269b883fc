"""The 39-bus system as a plant: PMU frames and true states of ten machines, varying loads, and three kinds of event.

Every load is an admittance times 1 + n, where n follows an Ornstein-Uhlenbeck process, n' = -n/tau + white noise, with
a standard deviation `load_sigma`; it changes every `TICK` and is held in between. The draws depend on `seed` and the
number of the tick only: a step that is repeated after a rollback repeats them. A load step is an admittance that draws
step_P + j step_Q at the voltage of the power flow; a fault is a reactance to ground; a trip opens a branch for good.

Runs on numpy: the carrier `xp` is not used.
"""

from collections import namedtuple
from functools import lru_cache
from math import ceil, pi
from typing import Annotated, Any, List, NamedTuple, Tuple

import numpy as np

from ... import tree
from ...carriers import floats
from ...clock import NEVER, resolution
from ...interface import INLINE, Boolean, Integer, Real, Rule, Scalar
from ...phasors import Frame
from .. import ornstein_uhlenbeck
from . import network
from .dynamics import OMEGA_S, States, System, advanced, equilibrium, load_admittances, terminals

GENERATORS = [f"G{k}" for k in range(1, 11)]
LOADS = np.flatnonzero(network.power_flow().S_load)

TICK = 1 / 60
"""s, between changes of the loads, from the start on."""

SUB_STEP, SUB_STEP_SALIENT = 1 / 240, 1 / 480
"""s; with x'q = 0.008 a fault at generator 10 makes a mode of 1.2 ms, which the longer one does not carry."""


class Inputs(NamedTuple):
    """None: set points and loads are the plant's own."""


class Parameters(NamedTuple):
    governors: Annotated[Scalar, Boolean("governors hold the frequency; else P_m is constant")] = 1
    pss: Annotated[Scalar, Boolean("power system stabilisers; without them three modes are unstable")] = 1
    salient: Annotated[Scalar, Boolean("x'q of the table; else x'q := x'd, as in the paper")] = 0
    load_sigma: Annotated[Scalar, Real("1", "standard deviation of every load, relative", min=0.0, max=0.2)] = 0.0
    load_tau: Annotated[Scalar, Real("s", "correlation time of the loads' variation", min=0.01, max=1e4)] = 2.0
    seed: Annotated[Scalar, Integer("of the loads' variation", min=0, max=2**31 - 1)] = 0
    step_bus: Annotated[Scalar, Integer("bus of the load step", min=1, max=39)] = 16
    step_P: Annotated[Scalar, Real("pu", "active power of the load step", min=-20.0, max=20.0)] = 0.5
    step_Q: Annotated[Scalar, Real("pu", "reactive power of the load step", min=-20.0, max=20.0)] = 0.1
    t_step: Annotated[Scalar, Real("s", "the load step begins")] = NEVER
    t_step_end: Annotated[Scalar, Real("s", "the load step ends")] = NEVER
    fault_bus: Annotated[Scalar, Integer("bus of the three-phase fault", min=1, max=39)] = 16
    x_fault: Annotated[Scalar, Real("pu", "reactance of the fault", min=1e-4, max=1e2)] = 1e-3
    t_fault: Annotated[Scalar, Real("s", "the fault begins")] = NEVER
    t_clear: Annotated[Scalar, Real("s", "the fault is cleared")] = NEVER
    trip_from: Annotated[Scalar, Integer("one end of the branch that trips, a bus", min=1, max=39)] = 16
    trip_to: Annotated[Scalar, Integer("its other end, a bus", min=1, max=39)] = 17
    t_trip: Annotated[Scalar, Real("s", "the branch trips")] = NEVER


class Generator(NamedTuple):
    frame: Annotated[Frame, INLINE] = Frame()
    P_m: Annotated[Scalar, Real("pu", "mechanical power")] = 0.0
    E_f: Annotated[Scalar, Real("pu", "field voltage (open circuit: E_f = 1 gives V = 1)")] = 0.0
    delta: Annotated[Scalar, Real("rad", "rotor angle, unwrapped")] = 0.0
    load_angle: Annotated[Scalar, Real("rad", "delta - theta_t, in (-pi, pi]")] = 0.0
    omega: Annotated[Scalar, Real("rad/s", "deviation from synchronous speed")] = 0.0
    e1d: Annotated[Scalar, Real("pu", "E'd, d-axis transient voltage")] = 0.0
    e1q: Annotated[Scalar, Real("pu", "E'q, q-axis transient voltage")] = 0.0
    t_frame: Annotated[Scalar, Real("s", "time of these values on the simulation's clock")] = 0.0


class Bus(NamedTuple):
    V: Annotated[Scalar, Real("pu", "voltage magnitude")] = 0.0
    theta: Annotated[Scalar, Real("rad", "voltage angle, unwrapped")] = 0.0


PerGenerator = namedtuple("PerGenerator", GENERATORS)
PerBus = namedtuple("PerBus", [f"bus{n}" for n in range(1, network.BUSES + 1)])
PerLoad = namedtuple("PerLoad", [f"bus{n + 1}" for n in LOADS])


class Outputs(NamedTuple):
    frequency: Annotated[Scalar, Real("Hz", "of the centre of inertia", nominal=60.0)] = 60.0
    generators: Annotated[Any, INLINE] = PerGenerator(*[Generator()] * len(GENERATORS))
    buses: Annotated[Any, INLINE] = PerBus(*[Bus()] * network.BUSES)


class State(NamedTuple):
    t_start: Scalar  # s
    tick: Scalar  # how many times the loads have changed
    loads: Any  # PerLoad of n, relative deviations
    machines: States  # of PerGenerator


AT_REST = State(0.0, 0.0, PerLoad(*[0.0] * len(LOADS)), States(*[PerGenerator(*[0.0] * 10)] * len(States._fields)))


def start(xp, p: Parameters, inputs: Inputs, t):
    """State and outputs at time t: the equilibrium of the power flow, the loads at their nominal values."""
    _, x = equilibrium(p.governors, p.pss, p.salient)
    state = packed(t, 0.0, np.zeros(len(LOADS)), x)
    return state, outputs(p, state, t)


def step(xp, p: Parameters, state: State, inputs: Inputs, t, h):
    """From t to t + h, from one change of the network to the next."""
    system, _ = equilibrium(p.governors, p.pss, p.salient)
    now, end = t, t + h
    close = resolution(floats, end)
    tick, n, x = state.tick, np.array(state.loads), np.array(state.machines)
    while now < end:
        next_tick = state.t_start + (tick + 1) * TICK
        changes = (next_tick, p.t_step, p.t_step_end, p.t_fault, p.t_clear, p.t_trip)
        stop = min([change for change in changes if now + close < change < end - close], default=end)
        x = integrate(system, grid_at(p, n, now), x, stop - now)
        now = stop
        if now > next_tick - close:
            tick += 1
            n = varied(p, n, tick)
    state = packed(state.t_start, tick, n, x)
    return state, outputs(p, state, end)


def packed(t_start, tick, n: np.ndarray, x: np.ndarray) -> Any:
    """The State, in floats."""
    return tree.like(AT_REST, [t_start, tick, *n.tolist(), *x.ravel().tolist()])


def integrate(system: System, grid: network.Reduction, x: np.ndarray, duration) -> np.ndarray:
    sub_steps = max(1, ceil(duration / (SUB_STEP_SALIENT if system.salient else SUB_STEP) - 1e-6))
    for _ in range(sub_steps):
        x = advanced(system, grid, x, duration / sub_steps)
    return x


def varied(p: Parameters, n: np.ndarray, tick) -> np.ndarray:
    """The loads' deviations one tick later."""
    w = np.random.default_rng((int(p.seed), int(tick))).standard_normal(len(n))
    return ornstein_uhlenbeck.step(n, TICK, p.load_tau, p.load_sigma, w)


def grid_at(p: Parameters, n: np.ndarray, now) -> network.Reduction:
    """The network with the loads' deviations n and the events of time `now`, as the machines see it."""
    now = now + resolution(floats, now)
    shunts = load_admittances().copy()
    shunts[LOADS] *= 1 + n
    if p.t_step <= now < p.t_step_end:
        at = int(p.step_bus) - 1
        shunts[at] += complex(p.step_P, -p.step_Q) / abs(network.power_flow().V[at]) ** 2
    if p.t_fault <= now < p.t_clear:
        shunts[int(p.fault_bus) - 1] += 1 / complex(0, p.x_fault)
    skipped = network.find_branch(p.trip_from, p.trip_to) if now >= p.t_trip else -1
    return reduced(skipped, tuple(shunts.tolist()))


@lru_cache(maxsize=16)
def reduced(skipped: int, shunts: Tuple[complex, ...]) -> network.Reduction:
    system, _ = equilibrium(True, True, False)  # x'd is the same in all
    return network.reduction(network.admittance(skipped) + np.diag(shunts), system.machines.bus, system.machines.xd1)


def outputs(p: Parameters, state: State, t):
    """The PMU frames and the true states at time t; at the time of an event it has happened."""
    system, _ = equilibrium(p.governors, p.pss, p.salient)
    x = States(*np.array(state.machines))
    grid = grid_at(p, np.array(state.loads), t)
    at = terminals(system.machines, p.salient, grid, x.delta, x.e1d, x.e1q)
    # angles from the rotor's, which is not wrapped
    load_angle, power_angle = (np.angle(np.exp(1j * x.delta) * phasor.conj()) for phasor in (at.V, at.I))
    columns = [np.abs(at.V), x.delta - load_angle, np.abs(at.I), x.delta - power_angle, at.S.real, at.S.imag]
    columns += [system.setpoints.P_m + x.turbine, x.E_f, x.delta, load_angle, x.omega, x.e1d, x.e1q]
    columns.append(np.full(len(GENERATORS), t))

    weight = system.machines.H / system.machines.H.sum()
    centre = weight @ x.delta
    V = grid.V_per_E @ at.E
    buses = np.array([np.abs(V), centre + np.angle(V * np.exp(-1j * centre))])
    frequency = (OMEGA_S + weight @ x.omega) / (2 * pi)
    return tree.like(Outputs(), [float(frequency), *np.array(columns).T.ravel().tolist(), *buses.T.ravel().tolist()])


def rules(xp, p: Parameters, inputs: Inputs) -> List[Rule]:
    """What must hold of parameters that are each in range."""
    branch = network.find_branch(p.trip_from, p.trip_to)
    islanded = ", ".join(map(str, network.separated(branch)))
    trip = "trip_from = {trip_from}, trip_to = {trip_to} is not allowed"
    return [
        Rule(p.t_clear >= p.t_fault, "t_clear = {t_clear} is not allowed; it must be in [t_fault = {t_fault}, inf] s"),
        Rule(
            p.t_step_end >= p.t_step,
            "t_step_end = {t_step_end} is not allowed; it must be in [t_step = {t_step}, inf] s",
        ),
        Rule(branch >= 0, f"{trip}: no branch joins the two; they must be a row of branch.csv"),
        Rule(not islanded, f"{trip}: it would separate the buses {islanded} from the others"),
    ]
