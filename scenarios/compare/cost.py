"""What a step takes: the observer bare and as an FMU, and the peers on FilterPy, on the same frames in one run."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time

import numpy as np

from fmu_src.pmu_observer import observer
from fmu_src.pmu_observer.carriers import floats
from fmu_src.pmu_observer.estimators import ESTIMATORS
from fmu_src.pmu_observer.machines.data import Machine
from fmu_src.pmu_observer.machines.two_axis import constants
from fmu_src.pmu_observer.phasors import Frame

from .. import study
from ..bench import frames, machines
from ..bench.frames import PERIOD
from ..fmu import Fmu
from . import filterpy_filters, model, runs, tuning

FRAMES, REPEATS = 600, 5

MACHINES, BANK_FRAMES = 10_000, 12
"""All at once on the numpy carrier, while their banks run."""

NATIVE_FMU = Path("dist/native/PmuObserver.fmu")
"""Timed where it has been built."""

TVE = 0.001


def measure() -> dict[str, float]:
    """CPU time of a step, s, on the first FRAMES frames of record_g6; the fastest of REPEATS rounds."""
    truth = frames.record(frames.RECORD_G6)
    noisy = runs.noisy(truth, (TVE,), 1, 1)
    V, I = noisy.V[:FRAMES, 0, 0], noisy.I[:FRAMES, 0, 0]  # noqa: E741 - the paper's name
    inputs = [
        observer.Inputs(Frame(*map(float, frames.frame(v, i))), float(P_m), float(E_f))
        for v, i, P_m, E_f in zip(V, I, truth.P_m, truth.E_f, strict=False)
    ]
    fmus = {"Python FMU": study.built("cost", "PmuObserver")}
    if NATIVE_FMU.is_file():
        fmus["native FMU"] = NATIVE_FMU
    peers = {"EKF": filterpy_filters.Ekf, "UKF": filterpy_filters.Ukf}
    one_step: dict[str, Callable[[], float]] = {
        **{name: partial(bare, name, truth.machine, inputs) for name in ("robust", "gradient", "drem", "open_loop")},
        "robust, its bank at rest": partial(bare, "robust", truth.machine, inputs, rests),
        **{f"robust, {kind}": partial(through_fmu, path, truth.machine, inputs) for kind, path in fmus.items()},
        **{name: partial(on_filterpy, peer, noisy) for name, peer in peers.items()},
    }
    rounds = [{name: seconds() for name, seconds in one_step.items()} for _ in range(REPEATS)]
    fastest = {name: min(found[name] for found in rounds) for name in one_step}
    return {**fastest, f"robust, numpy, a machine of {MACHINES}": on_arrays()}


def bare(name: str, m: Machine, inputs: list[observer.Inputs], counts: Callable = lambda state: True) -> float:
    """The mean over the steps whose state `counts`."""
    p = observer.Parameters(machine=m, tve=TVE)
    state, _ = observer.start(name, floats, p, inputs[0], 0.0)
    spans = []
    for k, frame in enumerate(inputs):
        counted, begin = counts(state), process_time()
        state, _ = observer.step(name, floats, p, state, frame, k * PERIOD, PERIOD)
        if counted:
            spans.append(process_time() - begin)
    return float(np.mean(spans))


def rests(state: observer.State) -> bool:
    return state.estimator.supervision.awake <= 0


def through_fmu(path: Path, m: Machine, inputs: list[observer.Inputs]) -> float:
    """With FMPy as the host: set the frame, step, get the estimate."""
    rows: list[dict[str, float]] = [{**frame.frame._asdict(), "P_m": frame.P_m, "E_f": frame.E_f} for frame in inputs]
    with TemporaryDirectory() as folder:
        slave = Fmu(path, Path(folder)).instantiate("observer")
        slave.set({**m._asdict(), "tve": TVE, "estimator": 1 + list(ESTIMATORS).index("robust")})
        slave.enter_initialization(FRAMES * PERIOD)
        slave.set(rows[0])
        slave.exit_initialization()
        begin = process_time()
        for k, row in enumerate(rows):
            slave.set(row)
            slave.step(k * PERIOD, PERIOD)
            slave.get(("delta", "omega", "e1d", "e1q"))
        span = process_time() - begin
        slave.close()
    return span / len(rows)


def on_filterpy(peer, noisy: runs.Frames) -> float:
    truth, c = noisy.truth, constants(noisy.truth.machine)
    V, I = noisy.V[:FRAMES, 0, 0], noisy.I[:FRAMES, 0, 0]  # noqa: E741 - the paper's name
    z, size2 = model.measured(c, V, I)
    Q = runs.process_noise(tuning.GRID[0], TVE)
    one = peer(c, runs.good_start(noisy)[0, 0], tuning.P_of(tuning.P_GOOD), Q)
    u = [
        model.Inputs(*map(float, each))
        for each in zip(truth.P_m[:FRAMES], truth.E_f, np.abs(V), np.angle(V), strict=False)
    ]
    begin = process_time()
    for k in range(len(V) - 1):
        R = np.eye(2) * TVE**2 * size2[k + 1] / 2
        one.step(model.mean(u[k], u[k + 1]), PERIOD, np.array([z[k + 1].real, z[k + 1].imag]), R)
    return (process_time() - begin) / (len(V) - 1)


def on_arrays() -> float:
    """The fastest step of all machines, over their number."""
    truth = machines.simulate(machines.random_machines(MACHINES, 1), BANK_FRAMES * PERIOD)
    received = list(frames.arriving(truth, frames.noise(TVE), 1))
    times, begin = [], process_time()
    for _ in frames.observe("robust", frames.for_seeds(truth), received, tve=TVE):
        times.append(process_time() - begin)
        begin = process_time()
    return min(times[1:]) / MACHINES  # the first one starts them too
