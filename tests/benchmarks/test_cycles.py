"""The time of a cycle: set the inputs, doStep, get the outputs; in C and in FMPy, of both kinds of FMU.

    python -m tests.benchmarks                          a table of the fastest rounds
    python -m pytest tests/benchmarks --benchmark-only -n 0    everything pytest-benchmark has to say

A round is a run of 1000 cycles from a new instance. The steps are so short that the bank of `robust` runs in all of
them: it captures after 0.1 s.
"""

import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from ctypes import CDLL, c_double, c_int, c_size_t, c_uint, c_void_p, cast
from pathlib import Path
from typing import Any

import fmpy
import pytest
from pythonfmu import FmuBuilder

import build_fmu
from fmu_src.pmu_observer import observer
from fmu_src.runtime.model import Model, Program
from fmu_src.runtime.native import build as native_fmu

from ..fmu.instance import Instance
from . import CASES, CYCLES

pytest.importorskip("pytest_benchmark")

H = 5e-5
CAPTURING = 1
INPUTS = {"V_t": 1.0, "theta_t": 0.1, "I_t": 0.5, "phi_t": 0.0, "P_t": 0.4975, "Q_t": 0.0499, "P_m": 0.5, "E_f": 1.0}
OUTPUTS = ("delta", "load_angle", "omega", "e1d", "e1q")
ESTIMATORS = ["", *build_fmu.all_models()["PmuObserver"][1].programs]

PYTHON_NOTHING = f"""
from pythonfmu import Fmi2Causality, Fmi2Slave, Real

class Nothing(Fmi2Slave):
    module_dicts = [globals()]  # as in fmu_src/runtime/python/build.py

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.module_dicts.append(globals())
        for causality, names in ((Fmi2Causality.input, {list(INPUTS)}), (Fmi2Causality.output, {OUTPUTS})):
            for name in names:
                setattr(self, name, 0.0)
                self.register_variable(Real(name, causality=causality))

    def do_step(self, current_time, step_size):
        return True
"""


def native_nothing() -> Model:
    """The observer's inputs and outputs, and no equations."""
    program = Program(
        start=lambda xp, parameters, inputs, t: ((t,), observer.Outputs()),
        step=lambda xp, parameters, state, inputs, t, h: (state, observer.Outputs()),
    )
    return Model("Nothing", "nothing", observer.Inputs(), NoParameters(), observer.Outputs(), {"nothing": program})


class NoParameters(tuple):
    _fields = ()


@pytest.fixture(scope="session")
def fmus(native_dist, dist, tmp_path_factory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("benchmarks")
    native_fmu.build(native_nothing(), folder / "native" / "Nothing.fmu", lambda message: None)
    script = folder / "nothing.py"
    script.write_text(PYTHON_NOTHING)
    FmuBuilder.build_FMU(script, dest=folder)
    return {
        "native": native_dist / "native" / "PmuObserver.fmu",
        "python": dist / "python" / "PmuObserver.fmu",
        "native nothing": folder / "native" / "Nothing.fmu",
        "python nothing": folder / "Nothing.fmu",
    }


@pytest.fixture(scope="session")
def cycles_in_c(tmp_path_factory):
    """cycles.c, as a function that does not hold Python's lock: native FMUs run in it as in any host in C."""
    if not shutil.which("gcc"):
        pytest.skip("there is no gcc")
    library = tmp_path_factory.mktemp("host") / "cycles.so"
    source, headers = Path(__file__).with_name("cycles.c"), Path(fmpy.__file__).parent / "c-code"
    subprocess.run(["gcc", "-O2", "-shared", "-fPIC", f"-I{headers}", "-o", library, source], check=True)
    function = CDLL(str(library)).cycles
    function.argtypes = [*[c_void_p] * 5, c_size_t, *[c_void_p] * 2, c_size_t, c_void_p, c_double, c_int]
    return function


class Slave:
    """A new instance, at its start."""

    def __init__(self, path: Path, **parameters: Any):
        self.instance = Instance(path, **parameters).initialise(**INPUTS)
        self.inputs, self.outputs = (
            [self.instance.variables[name].valueReference for name in names] for names in (INPUTS, OUTPUTS)
        )

    def in_c(self, function, cycles: int = CYCLES) -> None:
        dll = self.instance.slave.dll
        calls = [cast(getattr(dll, name), c_void_p) for name in ("fmi2SetReal", "fmi2DoStep", "fmi2GetReal")]
        inputs, values = (c_uint * len(INPUTS))(*self.inputs), (c_double * len(INPUTS))(*INPUTS.values())
        outputs, results = (c_uint * len(OUTPUTS))(*self.outputs), (c_double * len(OUTPUTS))()
        sizes = len(INPUTS), len(OUTPUTS)
        component = self.instance.slave.component
        h = H * CYCLES / cycles
        done = function(component, *calls, inputs, sizes[0], values, outputs, sizes[1], results, h, cycles)
        assert done == cycles

    def free(self, *arguments) -> None:
        self.instance.free()

    def in_fmpy(self) -> None:
        fmu, inputs, outputs, values = self.instance.slave, self.inputs, self.outputs, list(INPUTS.values())
        for k in range(CYCLES):
            fmu.setReal(inputs, values)
            fmu.doStep(k * H, H)
            fmu.getReal(outputs)


def new(fmus: dict[str, Path], case: str) -> Slave:
    kind, what = case.split()
    return Slave(fmus[case]) if what == "nothing" else Slave(fmus[kind], estimator=ESTIMATORS.index(what))


@pytest.mark.benchmark(group="1000 cycles from C")
@pytest.mark.parametrize("case", CASES)
def test_from_c(benchmark, fmus, cycles_in_c, case):
    def setup():
        return (new(fmus, case), cycles_in_c), {}

    benchmark.pedantic(Slave.in_c, setup=setup, teardown=Slave.free, rounds=10)


@pytest.mark.benchmark(group="1000 cycles from FMPy")
@pytest.mark.parametrize("case", CASES)
def test_from_fmpy(benchmark, fmus, case):
    benchmark.pedantic(Slave.in_fmpy, setup=lambda: ((new(fmus, case),), {}), teardown=Slave.free, rounds=10)


@pytest.mark.benchmark(group="8 instances of native robust, 10 000 cycles each")
@pytest.mark.parametrize("threads", [1, 2, 8])
def test_threads(benchmark, fmus, cycles_in_c, threads):
    """From C, with nothing shared: as many times faster as there are cores for the threads."""

    def run(slaves):
        with ThreadPoolExecutor(threads) as pool:
            list(pool.map(lambda slave: slave.in_c(cycles_in_c, 10 * CYCLES), slaves))
        assert all(slave.instance.get("status") == [CAPTURING] for slave in slaves)  # the bank ran to the end

    def setup():
        return ([new(fmus, "native robust") for _ in range(8)],), {}

    def teardown(slaves):
        for slave in slaves:
            slave.free()

    benchmark.pedantic(run, setup=setup, teardown=teardown, rounds=5)


@pytest.mark.benchmark(group="building all FMUs, with a warm compiler cache")
@pytest.mark.parametrize("kind", ["native", "python"])
def test_build(benchmark, native_dist, tmp_path, kind):
    """`native_dist` has warmed the cache."""
    root, options = Path(build_fmu.__file__).parent, ["--native"] if kind == "native" else []
    command = [sys.executable, "build_fmu.py", *options, "--out", str(tmp_path)]
    benchmark.pedantic(subprocess.run, (command,), {"cwd": root, "check": True}, rounds=1)
    benchmark.extra_info["kB"] = (tmp_path / kind / "PmuObserver.fmu").stat().st_size / 1000
