"""The binary for Windows runs, where there is Wine to run it on, and has the results of the one for Linux."""

import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import pytest

from ..fmu.instance import OK, Instance

WINE = next((found for name in ("wine", "wine64", "/usr/lib/wine/wine64") if (found := shutil.which(name))), None)
INPUTS = {
    "SmibPlant": [0.1, 0.1, 1.0, 0.0, 0.0],
    "PmuObserver": [1.0, 0.1, 0.5, 0.0, 0.4975, 0.0499, 0.5, 1.0],
}


@pytest.mark.skipif(WINE is None, reason="there is no Wine")
@pytest.mark.parametrize("name", INPUTS)
def test_under_wine(native_dist, tmp_path, name):
    linux = Instance(native_dist / "native" / f"{name}.fmu")
    real = [variable for variable in linux.variables.values() if variable.type == "Real"]
    linux.initialise(**{variable.name: value for variable, value in zip(real, INPUTS[name], strict=False)})
    for k in range(100):
        assert linux.step(k / 64, 1 / 64) == OK

    headers, source = Path(fmpy.__file__).parent / "c-code", Path(__file__).with_name("windows_host.c")
    program = tmp_path / "host.exe"
    command = [sys.executable, "-m", "ziglang", "cc", "-target", "x86_64-windows-gnu", f"-I{headers}", "-o", program]
    subprocess.run([*command, source], check=True)
    with zipfile.ZipFile(linux.path) as fmu:
        (tmp_path / "slave.dll").write_bytes(fmu.read(f"binaries/win64/{name}.dll"))
    arguments = ["slave.dll", linux.description.guid, len(linux.variables), *INPUTS[name]]
    environment = {
        "WINEPREFIX": str(tmp_path / "wine"),
        "WINEDEBUG": "-all",
        "PATH": "/usr/bin:/bin",
        "HOME": str(tmp_path),
    }
    result = subprocess.run(
        [str(WINE), str(program), *map(str, arguments)],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    windows = dict(line.split() for line in result.stdout.splitlines())
    assert len(windows) == len(real)
    for variable, value in zip(real, linux.get(*[variable.name for variable in real]), strict=True):
        # another libm: DREM's gain of 1e15 is not on, and nothing else amplifies an ulp so much
        assert float(windows[str(variable.valueReference)]) == pytest.approx(value, rel=1e-9, abs=1e-9), variable.name
    linux.free()
