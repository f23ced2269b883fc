"""What a study observes: the phasors that a machine makes, the noise on them, and the observer on the noisy frames."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from fmu_src.pmu_observer import observer, tree
from fmu_src.pmu_observer.carriers import arrays
from fmu_src.pmu_observer.machines.data import Machine, ieee39_g6
from fmu_src.pmu_observer.phasors import Frame

DATA = Path(__file__).parent.parent / "data"

PERIOD = 1 / 60
"""s, between frames."""


class Truth(NamedTuple):
    """A machine's frames without noise and its states, one row a frame; further axes are machines."""

    machine: Machine
    V: np.ndarray  # pu, complex
    I: np.ndarray  # noqa: E741 - pu, complex
    P_m: np.ndarray  # pu
    E_f: np.ndarray  # pu
    delta: np.ndarray  # rad
    omega: np.ndarray  # rad/s
    e1d: np.ndarray  # pu
    e1q: np.ndarray  # pu


class Received(NamedTuple):
    """A frame as it arrives."""

    V: np.ndarray
    I: np.ndarray  # noqa: E741
    valid: np.ndarray | float = 1.0


Channel = Callable[[int, np.random.Generator, np.ndarray, np.ndarray], Received]
"""(number of the frame, generator, V, I) -> what arrives."""


def noise(tve: float) -> Channel:
    """Complex Gaussian noise with E|n|^2 = (tve |.|)^2 on each phasor."""

    def channel(k, rng, V, I):  # noqa: E741
        return Received(V * (1 + tve * unit_noise(rng, V.shape)), I * (1 + tve * unit_noise(rng, I.shape)))

    return channel


def unit_noise(rng, shape):
    return (rng.standard_normal(shape) + 1j * rng.standard_normal(shape)) / np.sqrt(2)


def observe(
    truth: Truth, channel: Channel, seeds: int, *, seed: int = 1, alter=None, **parameters
) -> Iterator[tuple[int, observer.Outputs]]:
    """The observer's outputs at each frame's time plus a period: (k, outputs) are to be compared with truth[k + 1].

    `seeds` noisy copies of every machine run at once, as the last axis. `alter(k, state)` may change the state.
    """
    rng = np.random.default_rng(seed)
    p = observer.Parameters(machine=tree.map(per_seed, truth.machine), **parameters)
    state = None
    for k in range(len(truth.V) - 1):
        V, I, _ = np.broadcast_arrays(per_seed(truth.V[k]), per_seed(truth.I[k]), np.empty(seeds))  # noqa: E741
        received = channel(k, rng, V, I)
        P_m, E_f = per_seed(truth.P_m[k]), per_seed(truth.E_f[k])
        inputs = observer.Inputs(frame(received.V, received.I), P_m, E_f, received.valid)
        if state is None:
            state, _ = observer.start("robust", arrays, p, inputs, 0.0)
        state, outputs = observer.step("robust", arrays, p, state, inputs, k * PERIOD, PERIOD)
        if alter:
            state = alter(k, state)
        yield k, outputs


def per_seed(value):
    """With one more axis at the end, for the seeds."""
    return np.asarray(value)[..., None]


def frame(V, I) -> Frame:  # noqa: E741
    S = V * np.conj(I)
    return Frame(np.abs(V), np.angle(V), np.abs(I), np.angle(I), S.real, S.imag)


class Series(NamedTuple):
    """Errors, standard deviations and status: one row a frame, then machines and seeds."""

    t: np.ndarray  # s
    delta: np.ndarray
    omega: np.ndarray
    e1d: np.ndarray
    e1q: np.ndarray
    E_f: np.ndarray
    status: np.ndarray
    delta_std: np.ndarray
    omega_std: np.ndarray
    e1d_std: np.ndarray
    e1q_std: np.ndarray

    @property
    def e1(self):
        """|error of (E'd, E'q)|, pu."""
        return np.hypot(self.e1d, self.e1q)


def series(truth: Truth, channel: Channel, seeds: int, **options) -> Series:
    rows = []
    for k, o in observe(truth, channel, seeds, **options):
        after = [per_seed(v[k + 1]) for v in (truth.delta, truth.omega, truth.e1d, truth.e1q, truth.E_f)]
        errors = [a - b for a, b in zip((o.delta, o.omega, o.e1d, o.e1q, o.E_f_hat), after, strict=True)]
        row = [(k + 1) * PERIOD, *errors, o.status, o.delta_std, o.omega_std, o.e1d_std, o.e1q_std]
        shape = np.broadcast_shapes(*[np.shape(v) for v in row])
        rows.append([row[0], *[np.broadcast_to(v, shape) for v in row[1:]]])
    return Series(*[np.array(column) for column in zip(*rows, strict=True)])


def record(name: str) -> Truth:
    """A record of generator 6 in `scenarios/data`."""
    lines = [line for line in (DATA / name).read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    columns = dict(zip(lines[0].split(","), np.loadtxt(lines[1:], delimiter=",").T, strict=True))
    g6 = ieee39_g6()
    return Truth(
        machine=g6,
        V=columns["V_t"] * np.exp(1j * columns["theta_t"]),
        I=columns["I_t"] * np.exp(1j * columns["phi_t"]),
        P_m=columns["P_m"],
        E_f=columns["E_f"],
        delta=columns["delta"],
        omega=(columns["speed"] - 1) * g6.omega_s,
        e1d=columns["e1d"],
        e1q=columns["e1q"],
    )


RECORD_G6 = "record_g6.csv"
RECORD_G6_6TH_ORDER = "record_g6_6th_order.csv"
