"""What a machine's channels become in pu, what is said where they are missing, and an FMU that fails."""

import cmath
import math
from collections.abc import Mapping
from typing import Any

import pytest

from scenarios.live.c37118 import Configuration, Measurement, Phasor, Station
from scenarios.live.channels import ChannelError, Frame, find
from scenarios.live.observer import NOTHING, REST, Observer
from scenarios.live.settings import Current, Machine, Voltage
from scenarios.machines.table import Machine as MachineData

DATA = MachineData("G6", {"machine_model": "two_axis", "S_n": 500.0, "omega_s": 2 * math.pi * 60}, V_n=20.0)
PHASES = (Phasor("VA"), Phasor("VB"), Phasor("VC"), Phasor("IA", True))
STREAM = Configuration(7, (Station("WEST", 8, PHASES),), 60)
THREE = Machine(unit="G6", V=Voltage(phasor=["VA", "VB", "VC"]), I=Current(phasor=["IA"]))


def test_rated_phase_voltages_and_current_are_1_pu():
    V = 20e3 / math.sqrt(3)
    phases = tuple(cmath.rect(V, 0.3 - k * 2 * math.pi / 3) for k in range(3))
    rated = cmath.rect(500e6 / (math.sqrt(3) * 20e3), 0.1)
    frame = find(STREAM, THREE, DATA).read(Measurement(0, (*phases, rated), 60.0, 0.0))
    assert pytest.approx(cmath.rect(1, 0.3)) == frame.V and pytest.approx(cmath.rect(1, 0.1)) == frame.I


def test_ratio_direction_and_line_to_line():
    given = Machine(
        unit="G6",
        V=Voltage.model_validate({"phasor": "VA", "is": "AB", "ratio": 200}),
        I=Current(phasor=["IA"], direction="into the generator", ratio=1000),
    )
    secondary = cmath.rect(100.0, math.pi / 6)  # V_AB of 20 kV, 30 deg ahead of V_A
    frame = find(STREAM, given, DATA).read(Measurement(0, (secondary, 0, 0, -5.0), 60.0, 0.0))
    assert pytest.approx(1.0) == frame.V
    assert pytest.approx(5000 / (500e6 / (math.sqrt(3) * 20e3))) == frame.I


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (Machine(unit="G6", station="WST"), 'no station "WST"; did you mean "WEST"?'),
        (Machine(unit="G6", station=9), 'no station "9"'),
        (Machine(unit="G6"), 'station WEST has no voltage "V1"; known: VA, VB, VC'),
        (Machine(unit="G6", V=Voltage(phasor=["IA"])), 'no voltage "IA"'),
    ],
)
def test_what_is_missing_is_said(given, said):
    with pytest.raises(ChannelError, match=r"^G6: ") as error:
        find(STREAM, given, DATA)
    assert said in str(error.value)


def test_another_nominal_frequency_is_refused():
    stream = STREAM._replace(stations=(STREAM.stations[0]._replace(nominal_frequency=50),))
    with pytest.raises(ChannelError, match="50 Hz"):
        find(stream, THREE, DATA)


class Failing:
    """A component whose third step fails; `instances` counts how often it was started."""

    variables: Mapping[str, Any] = {"delta": None, "status": None}
    feedthrough: Mapping[str, frozenset[str]] = {}

    def __init__(self):
        self.instances = self.steps = 0

    def instantiate(self, label):
        self.instances += 1
        return self

    def set(self, values): ...
    def enter_initialization(self, stop): ...
    def exit_initialization(self): ...
    def close(self): ...

    def step(self, t, h):
        self.steps += 1
        if self.steps == 3:
            raise OSError("access violation")

    def get(self, names):
        return [2.0 for _ in names]


def test_an_fmu_that_fails_is_put_aside_and_started_anew():
    component = Failing()
    observer = Observer(component, "G6", {}, 0.1)
    frame = Frame(1 + 0j, 1 + 0j, math.nan, math.nan)
    first = [observer.estimate(0.1 * k, frame, True, k == 0)[-1] for k in range(2)]
    assert first == [2.0, 2.0]
    assert observer.estimate(0.2, frame, True, False) is NOTHING
    assert observer.failure == "OSError: access violation"
    assert observer.estimate(0.2 + REST / 2, frame, True, False) is NOTHING and component.instances == 1
    assert observer.estimate(0.3 + REST, frame, True, False)[-1] == 2.0
    assert component.instances == 2 and not observer.failure


def test_missing_frames_are_steps_without_a_frame():
    component = Failing()
    component.steps = 10
    observer = Observer(component, "G6", {}, 0.1)
    frame = Frame(1 + 0j, 1 + 0j, math.nan, math.nan)
    observer.estimate(0.0, frame, True, True)
    observer.estimate(0.4, frame, True, False)  # those at 0.1, 0.2 and 0.3 did not come
    assert component.steps == 10 + 1 + 3 + 1
