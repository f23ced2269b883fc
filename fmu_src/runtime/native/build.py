"""Building the native FMU of a model: binaries for five platforms with 64 bits, made on any one of them.

The compiler is Zig's clang, from PyPI, which brings the C libraries of all targets along. The sources are packed too,
for every other platform: `fmpy compile` makes a binary of them.
"""

import struct
import subprocess
import sys
import zipfile
from concurrent.futures import ThreadPoolExecutor
from importlib import metadata
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Callable, Dict, List
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from ..companions import companions
from ..model import Model
from ..modeldescription import model_description
from ..package import content_hash, guid_of, license_text, write_fmu
from .generate import sources

CAPABILITIES = {
    "needsExecutionTool": "false",
    "canBeInstantiatedOnlyOncePerProcess": "false",
    "canNotUseMemoryManagementFunctions": "true",
}

TARGETS = {
    "linux64": (".so", ["x86_64-linux-gnu.2.17"]),
    "win64": (".dll", ["x86_64-windows-gnu"]),
    "darwin64": (".dylib", ["x86_64-macos.10.15", "aarch64-macos.11.0"]),
    "aarch64-linux": (".so", ["aarch64-linux-gnu.2.17"]),
}
"""FMI platform (Linux on ARM by its name of FMI 3.0, as FMI 2.0.4 has it; macOS on ARM is in darwin64): suffix of its
binaries, and what they are compiled for."""

# no contraction of a*b + c into one rounding, so that C and Python agree to the last bit
FLAGS = [
    "-std=c99",
    "-O2",
    "-fno-math-errno",
    "-ffp-contract=off",
    "-fPIC",
    "-fvisibility=hidden",
    "-g0",
    "-s",
    "-shared",
]


def build(model: Model, path: Path, say: Callable[[str], None]) -> bool:
    """Write the native FMU of the model, unless it is there and current; returns whether the file changed.

    `say` is told what is being done. Raises RuntimeError if the C does not compile.
    """
    say(f"{model.name}: equations to C")
    compiler = f"ziglang {metadata.version('ziglang')} {FLAGS} {TARGETS}".encode()
    described = {"modelDescription.xml": description(model, ""), "compiler": compiler}
    beside = {**companions(model), "sources/buildDescription.xml": build_description(model)}
    guid = guid_of(content_hash({**sources(model, ""), **described, **beside}))
    if is_current(path, description(model, guid)):
        return False

    say(f"{model.name}: C to binaries for {', '.join(TARGETS)} (minutes the first time, then seconds)")
    code = sources(model, guid)
    files = {f"sources/{name}": content for name, content in code.items()}
    files["modelDescription.xml"] = description(model, guid)
    files["documentation/licenses/license.txt"] = license_text()
    files.update(beside)
    return write_fmu(path, {**files, **binaries(model.name, code)})


def description(model: Model, guid: str) -> bytes:
    return model_description(model, guid, CAPABILITIES, source_files=("fmi2_slave.c",))


def build_description(model: Model) -> bytes:
    """sources/buildDescription.xml, in the form of FMI 3.0 that FMI 2.0.4 takes over."""
    root = Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = SubElement(root, "BuildConfiguration", modelIdentifier=model.name)
    files = SubElement(configuration, "SourceFileSet", language="C99")
    SubElement(files, "SourceFile", name="fmi2_slave.c")
    SubElement(
        configuration, "Library", name="m", external="true", description="the C library's own, where it is apart"
    )
    indent(root)
    return b'<?xml version="1.0" encoding="UTF-8"?>\n' + tostring(root, encoding="utf-8") + b"\n"


def is_current(path: Path, wanted: bytes) -> bool:
    """Is this the FMU that `wanted` describes? The guid in there stands for everything that makes its bytes."""
    try:
        with zipfile.ZipFile(path) as fmu:
            return fmu.testzip() is None and fmu.read("modelDescription.xml") == wanted
    except (OSError, KeyError, zipfile.BadZipFile):
        return False


def binaries(name: str, code: Dict[str, bytes]) -> Dict[str, bytes]:
    """The binaries by their place in the FMU."""
    with TemporaryDirectory() as folder, ThreadPoolExecutor() as compilers:
        for file, content in code.items():
            (Path(folder) / file).write_bytes(content)
        suffixes = {target: suffix for suffix, targets in TARGETS.values() for target in targets}
        jobs = {
            target: compilers.submit(compile_for, target, name + suffix, folder) for target, suffix in suffixes.items()
        }
        return {
            f"binaries/{platform}/{name}{suffix}": universal([jobs[target].result() for target in targets])
            for platform, (suffix, targets) in TARGETS.items()
        }


def compile_for(target: str, library: str, folder: str) -> bytes:
    output = f"{target}-{library}"
    # by default, a dylib would hold the path that it was compiled at
    name = [f"-Wl,-install_name,@rpath/{library}"] if "macos" in target else []
    command = ["ziglang", "cc", "-target", target, *FLAGS, *name, "-o", output, "fmi2_slave.c", "-lm"]
    result = subprocess.run([sys.executable, "-m", *command], cwd=folder, capture_output=True, text=True, check=False)
    if result.returncode != 0:
        raise RuntimeError(f"{library} does not compile for {target}:\n{result.stderr}")
    return (Path(folder) / output).read_bytes()


def universal(parts: List[bytes]) -> bytes:
    """One Mach-O file of several, each at a page of its own behind a table of them all; a single one stays as it is."""
    if len(parts) == 1:
        return parts[0]
    page = 1 << 14
    header, body = struct.pack(">2I", 0xCAFEBABE, len(parts)), b""
    for part in parts:
        body += bytes(-len(body) % page)
        cpu_type, cpu_subtype = struct.unpack_from("<2I", part, 4)
        header += struct.pack(">5I", cpu_type, cpu_subtype, page + len(body), len(part), 14)
        body += part
    return header.ljust(page, b"\0") + body
