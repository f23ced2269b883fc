"""FMU states: complete, repeatable to the bit, in another process too; a damaged or foreign one is refused."""

import subprocess
import sys
from ctypes import c_void_p, pointer
from pathlib import Path

import pytest

import build_fmu

from ..fmu.instance import ERROR, FRAME, OK, Instance

H = 1 / 60
ESTIMATORS = range(1, 1 + build_fmu.all_models()["PmuObserver"][1].selected)

CONTINUE = """
import sys
from pathlib import Path
from tests.fmu.instance import Instance
from tests.native.test_state import run
instances = []
for path, state in (sys.argv[1:3], sys.argv[3:5]):
    instance = Instance(Path(path))
    instance.slave.setFMUState(instance.slave.deserializeFMUState(Path(state).read_bytes()))
    instances.append(instance)
print(repr(run(*instances, 60, 120)))
"""


def start(native_dist, estimator=1):
    """Plant and observer at 1 s."""
    plant = Instance(native_dist / "native" / "SmibPlant.fmu", "plant").initialise()
    observer = Instance(native_dist / "native" / "PmuObserver.fmu", "observer", estimator=estimator)
    observer.initialise(P_m=0.1, E_f=0.1, **dict(zip(FRAME, plant.get(*FRAME), strict=True)))
    run(plant, observer, 0, 60)
    return plant, observer


def run(plant, observer, first, last):
    """Steps number `first` to `last`; every output of both at the end."""
    for k in range(first, last):
        observer.set(**dict(zip(FRAME, plant.get(*FRAME), strict=True)))
        assert plant.step(k * H, H) == OK
        assert observer.step(k * H, H) == OK
    return plant.outputs() + observer.outputs()


def blob(instance):
    state = instance.slave.getFMUState()
    content = instance.slave.serializeFMUState(state)
    instance.slave.freeFMUState(state)
    return content


def load_status(instance, content):
    """The worse status of deserializing and setting a state."""
    state = c_void_p()
    status = instance.call("fmi2DeSerializeFMUstate", content, len(content), pointer(state))
    if status == OK:
        status = instance.call("fmi2SetFMUstate", state)
        instance.slave.freeFMUState(state)
    return status


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_another_process_continues_to_the_bit(native_dist, tmp_path, estimator):
    pair = start(native_dist, estimator)
    arguments = []
    for instance in pair:
        state = tmp_path / f"{instance.path.stem}.state"
        state.write_bytes(blob(instance))
        arguments += [str(instance.path), str(state)]
    once = run(*pair, 60, 120)
    root = Path(build_fmu.__file__).parent
    command = [sys.executable, "-c", CONTINUE, *arguments]
    result = subprocess.run(command, cwd=root, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    assert result.stdout.strip() == repr(once)
    for instance in pair:
        instance.free()


def test_rolling_back_repeats_to_the_bit(native_dist):
    pair = start(native_dist)
    states = [instance.slave.getFMUState() for instance in pair]
    once = run(*pair, 60, 90)
    for instance, state in zip(pair, states, strict=True):
        instance.slave.setFMUState(state)
        instance.slave.freeFMUState(state)
    assert run(*pair, 60, 90) == once
    for instance in pair:
        instance.free()


def test_a_damaged_or_foreign_state_is_refused(native_dist):
    plant, observer = start(native_dist)
    content, before = blob(observer), observer.outputs()
    for length in (0, 1, 8, 16, 55, len(content) // 2, len(content) - 1):
        assert load_status(observer, content[:length]) == ERROR
        assert f"size = {length} is not allowed; it must be {len(content)}" in observer.messages[-1]
    assert load_status(observer, content + b"x") == ERROR
    for place in range(len(content)):
        assert load_status(observer, content[:place] + bytes([content[place] ^ 1]) + content[place + 1 :]) == ERROR, (
            place
        )
    assert load_status(observer, b"\xff" * len(content)) == ERROR
    foreign = content[:20] + b"x" + content[21:]
    assert load_status(observer, foreign) == ERROR
    assert "is that of another FMU" in observer.messages[-1]
    assert load_status(observer, blob(plant)) == ERROR
    assert blob(observer) == content
    assert observer.outputs() == before
    assert load_status(observer, content) == OK
    plant.free()
    observer.free()


def test_a_forged_state_cannot_choose_a_program_that_is_not_there(native_dist):
    """With the right checksum, but a parameter out of range: it would index a table."""
    _, observer = start(native_dist)
    content = bytearray(blob(observer))
    reference = observer.variables["estimator"].valueReference
    header, situation = 56, 32  # bytes before the situation, and before the values in it
    place = header + situation + 8 * reference
    content[place : place + 8] = bytes(6) + b"\x59\x40"  # 100.0
    checksum = 14695981039346656037
    for byte in content[header:]:
        checksum = (checksum ^ byte) * 1099511628211 % 2**64
    content[8:16] = checksum.to_bytes(8, "little")
    assert load_status(observer, bytes(content)) == ERROR
    assert "is damaged" in observer.messages[-1]
    observer.free()
