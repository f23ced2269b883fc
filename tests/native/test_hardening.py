"""The slave in a hostile host, under the system compiler's sanitizers: see hardening.c."""

import shutil
import subprocess
from pathlib import Path

import pytest

import build_fmu
from fmu_src.runtime.native.generate import sources

pytestmark = pytest.mark.skipif(not shutil.which("gcc"), reason="there is no gcc")

HOST = Path(__file__).with_name("hardening.c")
WARNINGS = ["-Wall", "-Wextra", "-Werror", "-Wno-unused-parameter", "-Wno-unused-function"]
ADDRESS = ["-fsanitize=address,undefined,float-cast-overflow", "-fno-sanitize-recover=all"]
COUNTED = ["-DCOUNT_ALLOCATIONS", "-Wl,--wrap=malloc,--wrap=calloc,--wrap=realloc"]


def compiled(name: str, folder: Path, *flags: str) -> Path:
    """The host with the slave of a model in it."""
    model = build_fmu.all_models()[name][1]
    for file, content in sources(model, "{01234567-89ab-cdef-0123-456789abcdef}").items():
        (folder / file).write_bytes(content)
    program = folder / "hardening"
    command = ["gcc", "-std=gnu99", "-g1", *WARNINGS, *flags, "-I", str(folder), "-o", str(program), str(HOST)]
    result = subprocess.run([*command, "-lm", "-lpthread"], capture_output=True, text=True, check=False)
    if "cannot find -l" in result.stderr:  # libasan, libubsan or libtsan
        pytest.skip("gcc has no sanitizers here")
    assert result.returncode == 0, result.stderr
    return program


def run(program: Path, *arguments: object) -> str:
    command = [str(program), *map(str, arguments)]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr[-3000:]
    return result.stdout


@pytest.fixture(scope="module", params=build_fmu.native_names())
def sanitized(request, tmp_path_factory) -> Path:
    return compiled(request.param, tmp_path_factory.mktemp(request.param), *ADDRESS)


def test_a_million_random_calls(sanitized):
    """No crash, no report of a sanitizer, no Fatal, no value that is not finite."""
    said = run(sanitized, "fuzz", 1, 1_000_000)
    done = int(said.split("calls, ")[1].split(" ")[0])
    assert done > 50_000  # steps: the fuzz goes deep


def test_ten_thousand_instances_leave_no_byte(sanitized):
    run(sanitized, "instances", 10_000)


def test_threads_do_not_see_each_other(tmp_path):
    """As far as ThreadSanitizer can tell; each result is to the bit what one thread alone has."""
    run(compiled("SmibPlant", tmp_path, "-O1", "-fsanitize=thread"), "threads", 8)


def test_a_step_allocates_nothing(tmp_path):
    run(compiled("SmibPlant", tmp_path, *COUNTED), "allocations", 1000)
