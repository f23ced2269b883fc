"""The 39-bus system played as PMUs, observed over real sockets, and read again from what comes out."""

import asyncio
import csv
import math
from pathlib import Path

import pytest

from scenarios import loader, study
from scenarios.__main__ import main
from scenarios.fmu import Fmu
from scenarios.live import operation, playback, settings, sinks
from scenarios.live.client import Source
from scenarios.live.observer import NAMES
from scenarios.live.server import Server
from scenarios.live.service import Service

from .loopback import Received, connected, listening, run, when

SOC = 1_700_000_000
BASES = playback.bases(20.0, 100.0)
MACHINES = Path(__file__).parents[2] / "scenarios" / "live" / "ieee39_machines.csv"

LIVE = """
fmu = "python"
machines = "{machines}"
stream = [{{ host = "127.0.0.1", port = {port}, idcode = 39 }}]

[c37118]
port = 0

[metrics]
port = 0

[csv]
folder = "out"

[[machine]]
unit = "G6"
station = "G6"
P_m = {{ analog = "P_m MW", unit = "MW" }}
E_f = {{ analog = "E_f pu" }}
"""


@pytest.fixture(scope="module")
def played(tmp_path_factory):
    """Three seconds of the ten PMUs without noise: configuration, frames, and the plant's own outputs."""
    scenario = loader.load("ieee39_all")
    scenario = scenario.model_copy(update={"stop": 3 * 60 * scenario.step})
    with study.prepared(scenario) as plan:
        channel = Fmu(study.built("pmu", "PmuChannel"), tmp_path_factory.mktemp("channel"))
        plan, sites = playback.arranged(plan, channel, {"tve": 0.0})
        told = playback.configuration(sites, 39, 60, 60, BASES)
        plant = plan.instances[0]
        plant.watched |= {"G6.V_t", "G6.theta_t", "G6.I_t", "G6.P_m", "G6.delta", "G6.omega"}
        truth = []
        points = playback.master.points

        def noted(plan):
            for outputs in points(plan):
                truth.append(outputs[plant])
                yield outputs

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(playback.master, "points", noted)
            frames = [data for _, data in playback.Frames(plan, sites, told, BASES, SOC) if data]
    return told, frames, truth


def test_stations_carry_the_plants_values_in_si(played):
    told, frames, truth = played
    assert [station.name for station in told.stations] == [f"G{k}" for k in range(1, 11)]
    for k in (0, 7, 61):
        seen, plant = frames[k].measurements[5], truth[k]
        V, I = seen.phasors  # noqa: E741 - the usual name
        assert abs(V) == pytest.approx(plant["G6.V_t"] * 20e3 / math.sqrt(3), rel=1e-12)
        assert abs(I) == pytest.approx(plant["G6.I_t"] * 100e6 / (math.sqrt(3) * 20e3), rel=1e-12)
        assert seen.analogs[0] == pytest.approx(plant["G6.P_m"] * 100, rel=1e-12)
        stamp = frames[k].stamp
        assert (stamp.soc - SOC) + stamp.fraction / 1e6 == pytest.approx(k / 60, abs=1e-6)


def test_estimates_come_back_at_the_time_of_the_plants_state(played, tmp_path):
    """delta within 1 mrad, omega within .01 rad/s of the plant, read from the stream that the service sends."""
    told, frames, truth = played
    received = Received(1000)
    files = {}

    async def session():
        async with Server(told, 0) as pmus:
            path = tmp_path / "live.toml"
            path.write_text(LIVE.format(machines=MACHINES.as_posix(), port=pmus.port))
            given = settings.load(path)
            service = Service(given, Fmu(study.built("fmu", "PmuObserver"), tmp_path / "fmu"), lambda text: None)
            serving = asyncio.ensure_future(operation.operate(service, 60.0))
            await connected(pmus)
            assert service.output
            async with listening(Source("127.0.0.1", service.output.port), received):
                await connected(service.output)
                for data in frames:
                    pmus.send(data)
                    await asyncio.sleep(0)
                    sent = pmus.sent
                    if sent % 20 == 0:
                        await when(lambda sent=sent: service.snapshots >= sent - 1)
                await when(lambda: len(received.arrived) >= len(frames))
                files["metrics"] = list(sinks.metrics(service))
            serving.cancel()
            await asyncio.gather(serving, return_exceptions=True)

    run(session)
    delta, omega = NAMES.index("delta"), NAMES.index("omega")
    late = [one for one in received.arrived if one.data.stamp.soc >= SOC + 2]
    assert len(late) > 50
    for one in late:
        measured = one.data.measurements[0]
        k = round((one.data.stamp.soc - SOC + one.data.stamp.fraction / 1e6) * 60)
        if k >= len(truth):
            continue
        assert measured.digitals[0] == 2 and measured.stat == 0
        assert measured.analogs[delta] == pytest.approx(truth[k]["G6.delta"], abs=1e-3)
        assert measured.analogs[omega] == pytest.approx(truth[k]["G6.omega"], abs=0.01)
    assert any(
        line.startswith('pmu_analog_value{machine="G6",channel="delta",unit="rad"} ') for line in files["metrics"]
    )
    assert any(line.startswith("pmu_frames_total") and line.endswith(f" {len(frames)}") for line in files["metrics"])
    rows = [row for name in (tmp_path / "out").iterdir() for row in csv.reader(name.open())]
    assert len(rows) == 1 + len(frames) and rows[0][2] == "delta [rad]"


def test_a_wrong_key_is_one_line(tmp_path, capsys):
    path = tmp_path / "live.toml"
    path.write_text(
        'machines = "m.csv"\nstream = [{host = "a", port = 1, idcode = 1, prt = 2}]\nmachine = [{unit = "G"}]\n'
    )
    assert main(["live", str(path)]) == 2
    assert "stream.1.prt is not known" in capsys.readouterr().err
