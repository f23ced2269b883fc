"""smib.ssp: plant, PMU and observer in one file, run by three importers.

All three set an instance's inputs, step it, and read its outputs, one after the other: at the end of a step the channel
cannot know the plant of that instant yet. What it shows is the plant at `t_frame`, and the observer dates it so.
"""

import zipfile
from math import pi
from pathlib import Path

import numpy as np
import pytest
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import read_ssd, read_ssv

import build_fmu
from fmu_src.runtime import ssp as runtime_ssp
from fmu_src.systems.smib import SYSTEM

from . import runs

H = 1 / 60
STEPS = 480
STATES = ("delta", "omega", "e1d", "e1q")
IMPORTERS = {importer.module: importer for importer in runs.IMPORTERS}
WITHOUT_ERRORS = {"channel.tve": 0.0}

FAULT = {**SYSTEM.sets["ieee39_g6_fault"], "observer.tve": 1e-3}
"""The fault is from 5 s to 5.1 s."""


@pytest.fixture(scope="module")
def shipped(native_dist) -> Path:
    return build_fmu.build_ssp(native_dist)


@pytest.fixture(scope="module")
def fault(native_dist, tmp_path_factory) -> Path:
    """The same system with the other set bound, and a channel without errors: ecos and libcosim take what is bound."""
    path = tmp_path_factory.mktemp("ssp") / "smib.ssp"
    fmus = {name: native_dist / "native" / f"{model.name}.fmu" for name, model in SYSTEM.components.items()}
    runtime_ssp.build(SYSTEM._replace(sets={"fault": {**FAULT, **WITHOUT_ERRORS}}), fmus, path)
    return path


def with_fmpy(path: Path, tmp_path: Path) -> dict[str, np.ndarray]:
    rows = simulate_ssp(str(path), stop_time=STEPS * H - H / 2, step_size=H, parameter_set=read_bound(path))
    return {name: rows[name] for name in rows.dtype.names or ()}


def with_ecos(path: Path, tmp_path: Path) -> dict[str, np.ndarray]:
    from .with_ecos import simulate

    rows = simulate(path, STEPS * H, H, "fault")
    reals = [name for name in rows[0] if name.endswith("[REAL]")]
    return {name.removesuffix("[REAL]").replace("::", "."): np.array([row[name] for row in rows]) for name in reals}


def with_libcosim(path: Path, tmp_path: Path) -> dict[str, np.ndarray]:
    from .with_libcosim import simulate

    with zipfile.ZipFile(path) as content:
        content.extractall(tmp_path)
    rows = simulate(tmp_path, STEPS)
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


RUNS = {"with_fmpy": (with_fmpy, 0.0), "with_ecos": (with_ecos, 1e-6), "with_libcosim": (with_libcosim, 0.0)}
"""And what is lost where the importer records: six decimals."""


def read_bound(path: Path):
    """The set of values that is in the SSP as a file, which FMPy's master does not apply by itself."""
    with zipfile.ZipFile(path) as content:
        name = next(name for name in content.namelist() if name.endswith(("fault.ssv", "paper_smib.ssv")))
    return read_ssv(str(path), resource=name)


def wrapped(angle):
    return (angle + pi) % (2 * pi) - pi


@pytest.mark.parametrize("importer", RUNS)
def test_the_fault(fault, tmp_path, importer):
    if runs.missing(IMPORTERS[importer]):
        pytest.skip(runs.missing(IMPORTERS[importer]))
    run, lost = RUNS[importer]
    values = run(fault, tmp_path)
    of_plant, of_frame = values["plant.t_frame"], values["channel.t_frame"]
    # what the channel shows is the plant at t_frame, every frame once, a step ago
    place = np.searchsorted(of_plant, of_frame - H / 2)
    known = (of_frame > of_plant[0] - H / 2) & (place < len(of_plant))
    assert known.sum() >= STEPS - 3
    for name in ("V_t", "theta_t", "I_t", "phi_t"):
        shown, true = values[f"channel.{name}"][known], values[f"plant.{name}"][place[known]]
        assert (
            np.abs(wrapped(shown - true) if "t_t" in name or "phi" in name else shown - true).max() <= 1e-9 + 2 * lost
        )
    assert np.all(np.diff(of_frame[3:]) > H / 2)
    error = {name: values[f"observer.{name}"] - values[f"plant.{name}"] for name in STATES}
    delta = np.abs(wrapped(error["delta"]))
    late = of_plant > 2.0
    at_edge = np.any([np.abs(of_plant - t - 1.5 * H) < 1.6 * H for t in (5.0, 5.1)], axis=0)
    assert delta[late & ~at_edge].max() < 1e-3
    # at an edge the observer has the frame of two steps ago, and the rotor gained speed by at most b0 P_m = 35 rad/s2
    assert delta[at_edge].max() < 35 / 2 * (2 * H) ** 2


def test_the_same_fmus_give_the_same_bytes(shipped, native_dist):
    before = shipped.read_bytes()
    shipped.unlink()
    assert build_fmu.build_ssp(native_dist).read_bytes() == before
    with zipfile.ZipFile(shipped) as content:
        assert content.read("resources/PmuObserver.fmu") == (native_dist / "native" / "PmuObserver.fmu").read_bytes()


def test_the_system_is_described(shipped, tmp_path):
    """FMPy checks the schema of SSP 1.0: units, a set of values a machine, connectors of the system in its variant."""
    system = read_ssd(str(shipped)).system
    assert system and system.connectors == []
    with zipfile.ZipFile(shipped) as content:
        text = content.read("container.ssd").decode()
    with zipfile.ZipFile(tmp_path / "container.ssp", "w") as content:
        content.writestr("SystemStructure.ssd", text)
    system = read_ssd(str(tmp_path / "container.ssp")).system
    assert system and {connector.name for connector in system.connectors} == set(SYSTEM.outputs)
    assert '<ssc:Real unit="rad" />' in text and '<ssc:Unit name="rad">' in text
    for name, expected in SYSTEM.sets.items():
        found = read_ssv(str(shipped), resource=f"resources/{name}.ssv")
        assert {p.name: float(p.value) for p in found.parameters} == pytest.approx(expected, rel=1e-15)


def test_every_input_of_the_channel_is_connected():
    """The mechanical power too, which a connector that was not declared used to set."""
    inputs = {
        f"channel.{p.variable.name}" for p in runtime_ssp.ports(SYSTEM.components["channel"]) if p.causality == "input"
    }
    assert inputs <= set(SYSTEM.connections)
