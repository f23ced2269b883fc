"""The slave under the system compiler's sanitizers: in a hostile host (hardening.c), and in the other suites.

    python -m pytest -n 0 -s tests/native/test_hardening.py

prints what was done: a million random calls a model, 10 000 instances, ...
"""

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

import build_fmu
from fmu_src.runtime.native.generate import sources

pytestmark = [
    pytest.mark.skipif(not shutil.which("gcc"), reason="there is no gcc"),
    pytest.mark.xdist_group("hardening"),  # one worker compiles with sanitizers, which takes long
]

HOST = Path(__file__).with_name("hardening.c")
WARNINGS = ["-Wall", "-Wextra", "-Werror", "-Wno-unused-parameter", "-Wno-unused-function"]
ADDRESS = ["-fsanitize=address,undefined,float-cast-overflow", "-fno-sanitize-recover=all"]
COUNTED = ["-DCOUNT_ALLOCATIONS", "-Wl,--wrap=malloc,--wrap=calloc,--wrap=realloc"]


def compiled(name: str, folder: Path, *flags: str) -> Path:
    """The host with the slave of a model in it."""
    model = build_fmu.all_models()[name][1]
    for file, content in sources(model, "{01234567-89ab-cdef-0123-456789abcdef}").items():
        (folder / file).write_bytes(content)
    program = folder / name
    gcc("-I", folder, "-o", program, HOST, *flags, "-lpthread")
    return program


def gcc(*arguments: object) -> None:
    command = ["gcc", "-std=gnu99", "-g1", *WARNINGS, *map(str, arguments), "-lm"]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    if "cannot find -l" in result.stderr:  # libasan, libubsan or libtsan
        pytest.skip("gcc has no sanitizers here")
    assert result.returncode == 0, result.stderr


def run(program: Path, *arguments: object) -> str:
    command = [str(program), *map(str, arguments)]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr[-3000:]
    print(f"\n{program.name}: {result.stdout}", end="")
    return result.stdout


@pytest.fixture(scope="module", params=build_fmu.native_names())
def sanitized(request, tmp_path_factory) -> Path:
    return compiled(request.param, tmp_path_factory.mktemp(request.param), *ADDRESS)


def test_a_million_random_calls(sanitized):
    """No crash, no report of a sanitizer, no Fatal, no value that is not finite."""
    said = run(sanitized, "fuzz", 1, 1_000_000)
    done = int(said.split("calls, ")[1].split(" ")[0])
    assert done > 200_000  # steps: the fuzz goes deep


def test_ten_thousand_instances_leave_no_byte(sanitized):
    run(sanitized, "instances", 10_000)


def test_threads_do_not_see_each_other(tmp_path):
    """As far as ThreadSanitizer can tell; each result is to the bit what one thread alone has."""
    run(compiled("SmibPlant", tmp_path, "-O1", "-fsanitize=thread"), "threads", 8)


def test_a_step_allocates_nothing(tmp_path):
    run(compiled("SmibPlant", tmp_path, *COUNTED), "allocations", 1000)


@pytest.mark.skipif(sys.platform != "linux", reason="the sanitizers have to be in the process before Python")
@pytest.mark.parametrize("suite", ["call_sequence", "arguments", "state"])
def test_another_suite_with_sanitizers(sanitized_dist, suite):
    """It passes once more, on FMUs whose binaries look after themselves."""
    found = [subprocess.check_output(["gcc", f"-print-file-name=lib{s}.so"], text=True) for s in ("asan", "ubsan")]
    environment = {**os.environ, "LD_PRELOAD": " ".join(map(str.strip, found)), "ASAN_OPTIONS": "detect_leaks=0"}
    command = [sys.executable, "-m", "pytest", "-q", "-n0", "-pno:cacheprovider", f"--native-dist={sanitized_dist}"]
    tests = str(HOST.with_name(f"test_{suite}.py"))
    result = subprocess.run([*command, tests], env=environment, capture_output=True, text=True, check=False)
    assert result.returncode == 0, (result.stdout + result.stderr)[-3000:]
    print(f"\n{suite}: {result.stdout.splitlines()[-1]}")


@pytest.fixture(scope="module")
def sanitized_dist(native_dist, tmp_path_factory) -> Path:
    out = tmp_path_factory.mktemp("sanitized")
    (out / "native").mkdir()
    for name in ("PmuObserver", "SmibPlant"):
        with_sanitizers(native_dist / "native" / f"{name}.fmu", out / "native" / f"{name}.fmu")
    return out


def with_sanitizers(path: Path, out: Path) -> None:
    """The FMU with the binary for Linux compiled anew from its sources."""
    folder, library = out.with_suffix(""), out.with_suffix(".so")
    with zipfile.ZipFile(path) as fmu:
        fmu.extractall(folder)
    gcc("-fPIC", "-shared", *ADDRESS, "-o", library, folder / "sources" / "fmi2_slave.c")
    with zipfile.ZipFile(out, "w") as fmu:
        fmu.write(library, f"binaries/linux64/{library.name}")
        fmu.write(folder / "modelDescription.xml", "modelDescription.xml")
