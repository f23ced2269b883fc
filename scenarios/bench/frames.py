"""What a study observes: the phasors that a machine makes, the noise on them, and the observer on the noisy frames."""

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from fmu_src.pmu_observer import observer, pmu_channel, tree
from fmu_src.pmu_observer.carriers import arrays
from fmu_src.pmu_observer.machines.data import Machine, ieee39_g6
from fmu_src.pmu_observer.phasors import Frame

from .streams import Streams, numbers

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

    V: np.ndarray  # pu, complex
    I: np.ndarray  # noqa: E741 - pu, complex
    valid: np.ndarray | float = 1.0


Channel = Callable[[int, Streams, np.ndarray, np.ndarray], Received]
"""(number of the frame, random numbers, V, I) -> what arrives."""


def noise(tve, **others) -> Channel:
    """PmuChannel's own: complex Gaussian noise with E|n|^2 = (tve |.|)^2 on each phasor.

    `others` are PmuChannel's parameters, but for what concerns time: every frame arrives at once.
    """
    p = pmu_channel.Parameters(tve=tve, **others)

    def channel(k, streams, V, I):  # noqa: E741 - the paper's name
        true = pmu_channel.Plant(np.abs(V), np.angle(V), np.abs(I), np.angle(I))
        streams.generator, sent = pmu_channel.measured(
            arrays, p, streams.generator, pmu_channel.Inputs(true), k * PERIOD
        )
        return Received(sent.V * np.exp(1j * sent.theta), sent.I * np.exp(1j * sent.phi), sent.valid)

    return channel


def arriving(truth: Truth, channel: Channel, seeds: int, seed: int = 1, first: int = 0) -> Iterator[Received]:
    """The frames of every machine, `seeds` times, as the last axis; machine-seeds are numbered from `first` on."""
    shape = (*np.shape(truth.V[0]), seeds)
    streams = Streams(numbers(seed, shape, first))
    for k in range(len(truth.V)):
        yield channel(k, streams, *[np.broadcast_to(per_seed(x[k]), shape) for x in (truth.V, truth.I)])


def observe(
    estimator: str, truth: Truth, received: Iterable[Received], *, alter=None, **parameters
) -> Iterator[observer.Outputs]:
    """The observer's outputs a period after each frame but the last: the k-th is a guess of truth[k + 1].

    The one place where a study meets the observer. The truth's P_m, E_f and machine, the frames and the observer's
    parameters broadcast with each other. `alter(k, state)` may change the state after frame k.
    """
    p = observer.Parameters(machine=truth.machine, **parameters)
    state = None
    for k, (V, I, valid) in zip(range(len(truth.V) - 1), received, strict=False):  # noqa: E741 - the paper's name
        inputs = observer.Inputs(frame(V, I), truth.P_m[k], truth.E_f[k], valid)
        if state is None:
            state, _ = observer.start(estimator, arrays, p, inputs, 0.0)
        state, outputs = observer.step(estimator, arrays, p, state, inputs, k * PERIOD, PERIOD)
        if alter:
            state = alter(k, state)
        yield outputs


def for_seeds(truth: Truth) -> Truth:
    """With one more axis at the end, for the noise seeds."""
    return Truth(tree.map(per_seed, truth.machine), *[per_seed(column) for column in truth[1:]])


def per_seed(value):
    """With one more axis at the end, for the seeds."""
    return np.asarray(value)[..., None]


def frame(V, I) -> Frame:  # noqa: E741 - the paper's name
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


def series(
    truth: Truth, channel: Channel, seeds: int, *, seed: int = 1, first: int = 0, alter=None, **parameters
) -> Series:
    """What `robust` makes of `seeds` noisy copies of every machine; see `arriving` and `observe`."""
    rows, whole = [], for_seeds(truth)
    true = [whole.delta, whole.omega, whole.e1d, whole.e1q, whole.E_f]
    received = arriving(truth, channel, seeds, seed, first)
    for k, o in enumerate(observe("robust", whole, received, alter=alter, **parameters)):
        estimates = o.delta, o.omega, o.e1d, o.e1q, o.E_f_hat
        errors = [a - b[k + 1] for a, b in zip(estimates, true, strict=True)]
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


def rms(values) -> float:
    return float(np.sqrt(np.mean(np.asarray(values) ** 2)))
