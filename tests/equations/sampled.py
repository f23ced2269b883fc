"""The package's observer, fed with frames taken from a reference trajectory."""

from typing import Any, NamedTuple

import numpy as np

from fmu_src.pmu_observer import observer
from fmu_src.pmu_observer.carriers import floats
from fmu_src.pmu_observer.estimators import ESTIMATORS
from fmu_src.pmu_observer.machines.data import Machine
from fmu_src.pmu_observer.phasors import Frame

from . import reference
from .reference import Case, Seen


def machine_of(m: reference.Machine) -> Machine:
    return Machine(m.H, m.D, m.xd, m.x1, m.xq, m.x1, m.Td, m.Tq, 0.0, m.w0)


def parameters_of(m: reference.Machine, estimator: str = "drem", **gains) -> observer.Parameters:
    """The paper's observer: the estimator with some of its own parameters replaced, and I&I."""
    p = observer.Parameters(machine=machine_of(m), estimator=1 + list(ESTIMATORS).index(estimator), speed_observer=1)
    own = getattr(p.estimators, estimator)._replace(**gains)
    return p._replace(estimators=p.estimators._replace(**{estimator: own}))


def frame_of(s: Seen) -> Frame:
    return Frame(abs(s.V), np.angle(s.V), abs(s.I), np.angle(s.I), s.P, s.Q)


def inputs_of(s: Seen) -> observer.Inputs:
    return observer.Inputs(Frame(*map(float, frame_of(s))), float(s.P_m), float(s.E_f))


def inputs_along(case: Case, solution: reference.Solution):
    """The observer's inputs at every time of a solution."""
    return [inputs_of(reference.seen(case, t, x)) for t, x in zip(solution.t, solution.machine.T)]


class Run(NamedTuple):
    states: list  # states[k] is the state at frame k, not yet moved to the next one
    outputs: list  # outputs[k] is what the observer shows at frame k's time, predicted from the frame before


def run(name: str, p: observer.Parameters, inputs: list, h: float, xp: Any = floats) -> Run:
    state, outputs = observer.start(name, xp, p, inputs[0], 0.0)
    states, shown = [], [outputs]
    for k, frame in enumerate(inputs):
        state, outputs = observer.step(name, xp, p, state, frame, k * h, h)
        states.append(state)
        shown.append(outputs)
    return Run(states, shown[:-1])
