"""Writing an FMU: the same content gives the same bytes."""

import hashlib
import zipfile
from importlib import metadata
from io import BytesIO
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import Dict

EPOCH = (1980, 1, 1, 0, 0, 0)
"""The earliest time stamp a zip can hold, for every file."""


def license_text() -> bytes:
    """The project's LICENSE: beside the sources, or among the metadata of the package that is installed."""
    beside = Path(__file__).resolve().parents[2] / "LICENSE"
    if beside.exists():
        return beside.read_bytes()
    return distributed_license("pmu-observer")


def distributed_license(package: str) -> bytes:
    """Of an installed package. Raises IndexError if it brings none."""
    found = [file for file in metadata.files(package) or [] if file.name == "LICENSE"]
    return Path(str(found[0].locate())).read_bytes()


def content_hash(files: Dict[str, bytes]) -> str:
    """32 hexadecimal digits that change with any name or byte of the files."""
    digest = hashlib.sha256()
    for name in sorted(files):
        digest.update(f"{name}\0{len(files[name])}\0".encode())
        digest.update(files[name])
    return digest.hexdigest()[:32]


def guid_of(digest: str) -> str:
    return "{" + "-".join((digest[:8], digest[8:12], digest[12:16], digest[16:20], digest[20:])) + "}"


def write_fmu(path: Path, files: Dict[str, bytes]) -> bool:
    """Write the zip, unless the file there has these bytes already. Returns whether it was written."""
    path.parent.mkdir(parents=True, exist_ok=True)
    content = BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as fmu:
        # modelDescription.xml first, where a reader looks for it first
        for name in sorted(files, key=lambda name: (name != "modelDescription.xml", name)):
            info = zipfile.ZipInfo(name, EPOCH)
            info.compress_type = zipfile.ZIP_DEFLATED
            info.external_attr = 0o644 << 16
            fmu.writestr(info, files[name])
    if path.exists() and path.read_bytes() == content.getvalue():
        return False
    # written beside it and moved there: who reads the path meanwhile, or writes it too, sees a whole file
    with NamedTemporaryFile(dir=path.parent, prefix=path.name, delete=False) as part:
        part.write(content.getvalue())
    Path(part.name).chmod(0o644)
    Path(part.name).replace(path)
    return True
