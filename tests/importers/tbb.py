"""Where PyPI's `tbb` has put libtbb.so.12, which ecos needs (Debian: libtbb12)."""

from importlib import metadata
from pathlib import Path


def library() -> Path:
    files = metadata.files("tbb") or []
    return Path(next(str(file.locate()) for file in files if file.name == "libtbb.so.12")).resolve()
