"""Integer, Boolean and Enumeration variables where an importer knows Reals only, or no enumerations."""

from ctypes import c_double, c_uint
from math import inf, nan
from typing import Any

import pytest

from .instance import DISCARD, OK, Instance
from .test_errors import GOOD

H = 1 / 60
CHOICES = {"estimator": 3, "power_source": 2, "frame_time": 2, "speed_observer": 2, "mechanical_power": 2}


@pytest.fixture(scope="module", params=["python", "native"])
def path(request):
    folder = request.getfixturevalue("dist" if request.param == "python" else "native_dist")
    return folder / request.param / "PmuObserver.fmu"


def run(path, start: dict[str, Any]):
    observer = Instance(path, **start).initialise(**GOOD)
    for k in range(30):
        observer.set(**{**GOOD, "theta_t": 0.1 + 0.01 * k, "phi_t": 0.01 * k, "t_frame": (k - 2) * H})
        assert observer.step(k * H, H) == OK
    outputs = observer.outputs()
    observer.free()
    return outputs


def as_real(observer, name, value):
    return observer.call("fmi2SetReal", (c_uint * 1)(observer.variables[name].valueReference), 1, (c_double * 1)(value))


@pytest.mark.parametrize("name", CHOICES)
def test_a_number_chooses_what_the_enumeration_does(path, name):
    """Before what the enumeration says, which here is the other one; and the choice changes the outputs."""
    number = CHOICES[name]
    chosen = run(path, {name: number})
    assert run(path, {f"{name}_number": number}) == chosen
    assert run(path, {name: 1, f"{name}_number": number}) == chosen
    assert run(path, {name: 1}) != chosen


def test_every_enumeration_has_a_number(path):
    variables = Instance(path).variables
    enumerations = {name: v for name, v in variables.items() if v.type == "Enumeration" and v.causality == "parameter"}
    assert set(CHOICES) <= set(enumerations)
    for name, v in enumerations.items():
        number = variables[f"{name}_number"]
        assert (number.type, number.start, number.min) == ("Integer", "0", "0")
        items = v.declaredType.items if v.declaredType else None
        assert items and number.max == str(len(items))


def test_reals_set_and_read_every_variable(path):
    observer = Instance(path)
    for name, value in (("estimator", 3.0), ("frame_time_number", 2.0), ("frame_valid", 0.0), ("H", 5.0)):
        assert as_real(observer, name, value) == OK
    observer.initialise()
    references = [observer.variables[name].valueReference for name in ("estimator", "frame_time_number", "frame_valid")]
    assert observer.slave.getReal(references) == [3.0, 2.0, 0.0]
    assert observer.get("estimator", "frame_valid", "H") == [3, False, 5.0]
    assert observer.slave.getReal([observer.variables["status"].valueReference]) == [0.0]
    observer.free()


@pytest.mark.parametrize("value", [1.5, nan, inf])
@pytest.mark.parametrize("name", ["estimator", "frame_valid", "frame_time_number"])
def test_a_real_that_is_not_whole_is_refused(path, name, value):
    observer = Instance(path)
    status = as_real(observer, name, value)
    assert status == (DISCARD if path.parent.name == "native" else OK)  # the Python kind can only log
    assert f"{name} = {value:.12g} is not allowed" in observer.messages[-1]
    assert observer.initialise(**GOOD).step(0.0, H) == OK
    observer.free()


def test_a_number_out_of_range_is_named(path):
    observer = Instance(path)
    assert as_real(observer, "estimator_number", 99.0) == (DISCARD if path.parent.name == "native" else OK)
    observer.initialise(**GOOD)
    highest = observer.variables["estimator_number"].max
    message = f"estimator_number = 99 is not allowed; it must be in whole numbers from 0 to {highest}"
    assert any(message in said for said in observer.messages)
    observer.free()
