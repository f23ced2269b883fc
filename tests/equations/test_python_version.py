"""What goes into a Python FMU needs no more than Python 3.9: the host's interpreter runs it, not ours."""

import pytest
import vermin

import build_fmu
from fmu_src.runtime.python.build import imported_sources

LOWEST = (3, 9)
MODELS = build_fmu.all_models()


def needed(source: str):
    """The lowest Python 3 that a source runs on, its annotations evaluated: the interface is made of them."""
    config = vermin.Config()
    config.set_eval_annotations(True)
    config.enable_feature("union-types")
    return vermin.detect(source, config)[1]


@pytest.mark.parametrize("name", MODELS)
def test_the_sources_in_the_fmu(name):
    sources = imported_sources(MODELS[name][1], MODELS[name][0])
    own = {path: text.decode() for path, text in sources.items() if path.endswith(".py") and "pythonfmu" not in path}
    assert len(own) > 10
    versions = {path: needed(source) for path, source in own.items()}
    assert {path: version for path, version in versions.items() if version > LOWEST} == {}


@pytest.mark.parametrize(
    ("source", "version"),
    [
        ("from typing import Annotated\n", (3, 9)),
        ("match 1:\n    case 1:\n        pass\n", (3, 10)),
        ("def f(x: int | None): ...\n", (3, 10)),
        ("from itertools import pairwise\n", (3, 10)),
    ],
)
def test_newer_python_is_found(source, version):
    """So that the test above can fail."""
    assert needed(source) == version
