"""The native and the Python FMU are the same equations: on Linux, where both use one libm, their outputs agree."""

import sys

import pytest

import build_fmu
from fmu_src.pmu_observer.estimators import ESTIMATORS
from fmu_src.pmu_observer.machines import MACHINE_MODELS
from fmu_src.pmu_observer.observer_interface import number

from ..fmu.instance import FRAME, OK, Instance

H = 1 / 60
STEPS = 180
PROGRAMS = list(build_fmu.all_models()["PmuObserver"][1].programs)

LINE = {"x_line": 0.2, "P_m": 0.8, "E_f": 1.2, "t_fault": 1.0, "t_clear": 1.1}
CASES = {
    "paper": ({}, {}),
    "fault, from E_f, adaptive": ({**LINE, "start_mode": 2}, {"speed_observer": 2, "power_source": 2}),
    "fault, from V_t, Pm unknown": ({**LINE, "start_mode": 3, "Ra": 0.01}, {"mechanical_power": 2, "Ra": 0.01}),
}


def choice(program: str):
    """Estimator and machine model of a program, by their numbers."""
    estimator = next(name for name in ESTIMATORS if program.startswith(name))
    machine_model = program[len(estimator) + 1 :] or "two_axis"
    return {"estimator": number(estimator, ESTIMATORS), "machine_model": number(machine_model, MACHINE_MODELS)}


def trajectory(folder, program, plant_start, observer_start):
    """Every output of plant and observer at every step; one frame in ten is lost."""
    plant = Instance(folder / "SmibPlant.fmu", "plant", **plant_start).initialise()
    observer = Instance(folder / "PmuObserver.fmu", "observer", **choice(program), **observer_start)
    machine = dict(zip(("P_m", "E_f"), plant.get("P_m", "E_f"), strict=True))
    observer.initialise(**machine, **frame(plant))
    rows = []
    for k in range(STEPS):
        observer.set(**frame(plant))
        if k % 10 == 9:
            observer.set(V_t=float("nan"))
        assert plant.step(k * H, H) == OK
        assert observer.step(k * H, H) == OK
        rows.append(plant.outputs() + observer.outputs())
    variables = [v for instance in (plant, observer) for v in instance.variables.values() if v.causality == "output"]
    plant.free()
    observer.free()
    return rows, variables


def frame(plant):
    return dict(zip(FRAME, plant.get(*FRAME), strict=True))


@pytest.mark.skipif(sys.platform != "linux", reason="the binary for Windows has another libm than Python there")
@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("program", PROGRAMS)
def test_agreement(dist, native_dist, program, case):
    python, variables = trajectory(dist / "python", program, *CASES[case])
    native, _ = trajectory(native_dist / "native", program, *CASES[case])
    for k, rows in enumerate(zip(python, native, strict=True)):
        for variable, expected, got in zip(variables, *rows, strict=True):
            tolerance = 1e-10 * float(variable.nominal or 1.0)
            assert abs(got - expected) <= tolerance, f"{variable.name} at step {k}: {got!r}, Python {expected!r}"
