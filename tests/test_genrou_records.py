"""The robust estimator with the model genrou on noisy records of ANDES; and what shows where the data are wrong."""

from typing import NamedTuple

import numpy as np
import pytest

from fmu_src.pmu_observer import observer, tree
from fmu_src.pmu_observer.carriers import arrays
from fmu_src.pmu_observer.machines import MACHINE_MODELS
from fmu_src.pmu_observer.observer_interface import number
from scenarios.bench import frames
from scenarios.bench.streams import Streams

from .records import genrou_record

SEEDS = 10


class Run(NamedTuple):
    """One row a frame, then seeds."""

    t: np.ndarray
    delta: np.ndarray  # rad, error
    e1q: np.ndarray  # pu, error
    nees: np.ndarray  # of delta
    tracking: np.ndarray
    innovation: np.ndarray
    E_f: np.ndarray  # pu, error


def observe(name, seconds, tve, field_voltage, machine_model="genrou", **data) -> Run:
    r, rng = genrou_record(name), Streams(np.arange(SEEDS))
    machine = tree.map(lambda v: np.array([v]), r.machine._replace(**data))
    p = observer.Parameters(
        machine=machine,
        tve=tve,
        field_voltage=field_voltage,
        machine_model=number(machine_model, MACHINE_MODELS),
    )
    V, I = r["V_t"] * np.exp(1j * r["theta_t"]), r["I_t"] * np.exp(1j * r["phi_t"])  # noqa: E741 - the paper's name
    channel, state, rows = frames.noise(tve), None, []
    for k in range(round(seconds * 60)):
        noisy = channel(k, rng, np.full(SEEDS, V[k]), np.full(SEEDS, I[k]))
        inputs = observer.Inputs(frames.frame(noisy.V, noisy.I), r["P_m"][k], r["E_f"][k])
        if state is None:
            state, _ = observer.start("robust", arrays, p, inputs, 0.0, machine_model)
        state, o = observer.step("robust", arrays, p, state, inputs, k / 60, 1 / 60, machine_model)
        delta = o.delta - r["delta"][k + 1]
        rows.append(
            [
                delta,
                o.e1q - r["e1q"][k + 1],
                (delta / o.delta_std) ** 2,
                o.status == 2,
                o.innovation,
                o.E_f_hat - r["E_f"][k + 1],
            ]
        )
    columns = [np.array([np.broadcast_to(v, (SEEDS,)) for v in column]) for column in zip(*rows, strict=True)]
    return Run(np.arange(1, len(rows) + 1) / 60, *columns)


def rms(values):
    return np.sqrt(np.mean(values**2))


@pytest.mark.parametrize(
    ("field_voltage", "capture", "late", "fault", "e1q"),
    [(1, 0.25, 0.35e-3, 1.5e-3, 5e-5), (2, 0.6, 0.6e-3, 2.5e-3, 6e-4)],
)
def test_fault(field_voltage, capture, late, fault, e1q):
    """TVE 0.1 %: the aims of the model, for the capture, from 5 s on, and in the 0.5 s from the fault at 2.005 s."""
    s = observe("k3_fault", 8.0, 0.001, field_voltage)
    assert np.median(s.t[s.tracking.argmax(0)]) < capture
    quiet, faulted = s.t >= 5, (s.t > 2.005) & (s.t < 2.505)
    assert rms(s.delta[quiet]) < late and rms(s.e1q[quiet]) < e1q
    assert rms(s.delta[faulted]) < fault
    assert 0.5 < np.mean(s.nees[quiet]) < 2


def test_a_saturation_that_is_ignored_shows():
    """E_f measured: the innovations grow. E_f estimated: it is far off the measured one."""
    right, wrong = [observe("k3_loadstep", 2.0, 0.001, 1, "genrou", **data) for data in ({}, {"S10": 0.0, "S12": 0.0})]
    late = right.t > 1
    assert rms(right.innovation[late]) < 1.3
    assert rms(wrong.innovation[late]) > 5
    estimated = observe("k3_loadstep", 2.0, 0.001, 2, S10=0.0, S12=0.0)
    assert np.all(np.abs(estimated.E_f[late]) > 0.1)
