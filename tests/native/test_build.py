"""The native FMUs as files: the interface of the Python ones, reproducible, for five platforms, with their sources."""

import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import lief
import pytest
from fmpy import read_model_description
from fmpy.build import build_platform_binary
from fmpy.validation import validate_fmu

import build_fmu

from ..fmu.instance import OK, Instance

NAMES = build_fmu.native_names()
HEADER = Path(fmpy.__file__).parent / "c-code" / "fmi2Functions.h"
FMI_FUNCTIONS = set(re.findall(r"FMI2_Export fmi2\w+TYPE\s+(fmi2\w+)", HEADER.read_text()))

MACH_O_IMAGE = {"_mh_dylib_header", "__dso_handle"}
"""What Zig's linker lets every dylib export of itself; names that no importer looks for."""

lief.logging.disable()


@pytest.fixture(params=NAMES)
def path(request, native_dist):
    return native_dist / "native" / f"{request.param}.fmu"


def test_fmpy_finds_no_problem(path):
    """Its checks include the XML schema of FMI 2.0."""
    assert validate_fmu(str(path)) == []


def test_the_interface_is_that_of_the_python_fmu(dist, path):
    native, python = (read_model_description(p) for p in (path, dist / "python" / path.name))
    assert native.guid != python.guid
    for mine, theirs in zip(native.modelVariables, python.modelVariables, strict=True):
        for attribute in (
            *("name", "valueReference", "type", "causality", "variability", "initial", "description"),
            *("start", "unit", "min", "max", "nominal"),
        ):
            assert getattr(mine, attribute) == getattr(theirs, attribute), (mine.name, attribute)
    assert native.coSimulation and not native.coSimulation.needsExecutionTool
    assert not native.coSimulation.canBeInstantiatedOnlyOncePerProcess


def test_an_fmu_that_is_current_is_left_alone(path, tmp_path):
    (tmp_path / "native").mkdir()
    copy = Path(shutil.copy(path, tmp_path / "native"))
    before, said = copy.stat().st_mtime_ns, []
    build_fmu.build_native(path.stem, tmp_path, said.append)
    assert (copy.stat().st_mtime_ns, said) == (before, [f"{path.stem}: equations to C"])


def test_a_broken_file_is_replaced_and_the_same_sources_give_the_same_bytes(native_dist, tmp_path):
    good = (native_dist / "native" / "SmibPlant.fmu").read_bytes()
    (tmp_path / "native").mkdir()
    (tmp_path / "native" / "SmibPlant.fmu").write_bytes(good[: len(good) // 2])
    assert build_fmu.build_native("SmibPlant", tmp_path).read_bytes() == good


def test_no_path_of_the_building_machine_is_in_it(path):
    with zipfile.ZipFile(path) as fmu:
        content = b"".join(fmu.read(name) for name in fmu.namelist())
    for place in (Path(build_fmu.__file__).parent, Path.home(), Path(sys.prefix), "/tmp/"):
        assert str(place).encode() not in content


def exports(path, binary):
    """The names that the binary of a platform exports, without the underscore that Mach-O puts before each."""
    with zipfile.ZipFile(path) as fmu:
        content = fmu.read(f"binaries/{binary}")
    if binary.endswith(".so"):
        elf = lief.ELF.parse(list(content))
        assert elf
        return [[str(symbol.name) for symbol in elf.exported_symbols]]
    if binary.startswith("win64"):
        pe = lief.PE.parse(list(content))
        table = pe.get_export() if pe else None
        assert table
        return [[str(entry.name) for entry in table.entries]]
    fat = lief.MachO.parse(list(content))
    assert fat and [slice.header.cpu_type.name for slice in fat] == ["X86_64", "ARM64"]
    return [[str(symbol.name).removeprefix("_") for symbol in slice.exported_symbols] for slice in fat]


@pytest.mark.parametrize("binary", ["linux64/{}.so", "aarch64-linux/{}.so", "win64/{}.dll", "darwin64/{}.dylib"])
def test_the_binaries_export_the_functions_of_fmi_and_no_others(path, binary):
    for names in exports(path, binary.format(path.stem)):
        assert set(names) - (MACH_O_IMAGE if "darwin" in binary else set()) == FMI_FUNCTIONS


def test_the_linux_binary_needs_only_an_old_c_library(path):
    with zipfile.ZipFile(path) as fmu:
        elf = lief.ELF.parse(list(fmu.read(f"binaries/linux64/{path.stem}.so")))
    assert elf
    assert {str(library) for library in elf.libraries} <= {"libc.so.6", "libm.so.6"}
    versions = {
        str(aux.name) for requirement in elf.symbols_version_requirement for aux in requirement.get_auxiliary_symbols()
    }
    assert max(tuple(map(int, version.removeprefix("GLIBC_").split("."))) for version in versions) <= (2, 17)


@pytest.mark.skipif(not (shutil.which("cmake") and shutil.which("cc")), reason="there is no CMake or no C compiler")
@pytest.mark.parametrize("name", ["PmuObserver", "SmibPlant"])
def test_fmpy_compiles_it_from_its_own_sources(native_dist, tmp_path, name):
    """The way for platforms that no binary is packed for; the results are the same."""
    path = native_dist / "native" / f"{name}.fmu"
    folder = tmp_path / "unzipped"
    with zipfile.ZipFile(path) as fmu:
        fmu.extractall(folder)
    binary = folder / "binaries" / fmpy.platform / f"{path.stem}{fmpy.sharedLibraryExtension}"
    packed = binary.read_bytes()
    binary.unlink()
    build_platform_binary(folder)
    assert binary.read_bytes() != packed
    rebuilt = tmp_path / path.name
    with zipfile.ZipFile(rebuilt, "w") as fmu:
        for file in folder.rglob("*"):
            fmu.write(file, file.relative_to(folder))
    first, second = (Instance(p).initialise() for p in (path, rebuilt))
    for k in range(10):
        assert first.step(k * 0.01, 0.01) == second.step(k * 0.01, 0.01) == OK
    assert first.outputs() == pytest.approx(second.outputs(), rel=1e-12)


def test_the_command_says_what_it_does(tmp_path):
    root = Path(build_fmu.__file__).parent
    command = [sys.executable, "build_fmu.py", "--native", "--only", "SmibPlant", "--out", str(tmp_path)]
    result = subprocess.run(command, cwd=root, capture_output=True, text=True, check=True)
    words = ("SmibPlant: equations to C", "linux64, win64, darwin64, aarch64-linux", "SmibPlant.fmu", " kB")
    assert all(word in result.stdout for word in words)
