"""Play a scenario's plant, or a record, as PMUs: a C37.118.2 server over TCP and UDP, for any PDC to connect to.

Every machine that the scenario observes becomes a station with V1 and I1 in V and A, and with P_m and E_f as analogs.
Noise, latency and losses are those of the scenario's PmuChannel, or what the options say. Stamps are UTC, from the next
full second on. A record (records as `convert` writes them) is played from its first to its last frame.
"""

import argparse
import asyncio
import contextlib
import math
import signal
import time
from collections.abc import Callable
from fractions import Fraction
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

from rich.console import Console

from .. import loader, study
from ..errors import UserError
from ..fmu import Fmu
from ..live import playback, settings
from ..live.server import Server
from ..plan import Plan

HELP = "play a scenario or a record as PMUs: a C37.118 server"
EXAMPLES = [
    ("pmu ieee39_all", "the New England system: ten PMUs in one stream, 127.0.0.1:4712"),
    ("pmu ieee39_all --seconds 60 --dropout 0.02 --latency 0.05", "with losses and latency, for a minute"),
    ("pmu smib_fault --tve 0.005 --port 4720 --integers", "one machine and a fault, with noise, as 16-bit integers"),
    ("pmu my_record.csv --speed 10", "a record, ten times as fast as it was"),
]

FOREVER = 10**9
"""s."""

DEFAULT_RATE = 60.0
"""frames/s; of PmuChannel."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("source", metavar="SCENARIO", help="a scenario (see list), its .toml, or a record's .csv")
    parser.add_argument("--host", default="127.0.0.1", help="address to listen on (default: %(default)s)")
    parser.add_argument("--port", type=int, default=4712, help="TCP and UDP (default: %(default)s)")
    parser.add_argument("--idcode", type=int, default=39, help="of the stream (default: %(default)s)")
    parser.add_argument("--send-to", metavar="HOST:PORT", action="append", default=[], help="UDP without being asked")
    parser.add_argument("--seconds", type=float, help="how long (default: until Ctrl-C, or the end of the record)")
    parser.add_argument("--speed", type=float, default=1.0, help="times real time (default: %(default)s)")
    parser.add_argument("--wait", action="store_true", help="begin when somebody has turned the data on")
    parser.add_argument("--kv", type=float, default=20.0, help="kV line-line of 1 pu (default: %(default)s)")
    parser.add_argument("--mva", type=float, default=100.0, help="MVA of 1 pu (default: %(default)s)")
    parser.add_argument("--nominal", type=int, choices=(50, 60), default=60, help="Hz (default: %(default)s)")
    parser.add_argument("--fmu", choices=study.KINDS, default="python", help="kind of FMU (default: %(default)s)")
    parser.add_argument("--integers", action="store_true", help="16-bit integers in place of floating point")
    for name, about in (
        ("tve", "noise: RMS of the total vector error"),
        ("dropout", "probability that a frame is lost"),
        ("latency", "s, from measurement to sending"),
        ("gross-error-probability", "probability of a gross error"),
        ("rate", "frames/s; the scenario's step divides the period"),
    ):
        parser.add_argument(f"--{name}", type=float, help=f"{about} (default: as in the scenario)")
    parser.add_argument("--seed", type=int, help="of the noise (default: as in the scenario)")


def run(arguments: argparse.Namespace, console: Console) -> int:
    if not (arguments.speed > 0 and arguments.kv > 0 and arguments.mva > 0 and 0 < arguments.idcode < 65535):
        raise UserError("--speed, --kv, --mva and --idcode must be positive, and an idcode is below 65535")
    source = arguments.source
    scenario = playback.of_record(Path(source)) if source.endswith(".csv") else loader.load(source)
    if scenario.csv:
        stop = min(Fraction(arguments.seconds or FOREVER).limit_denominator(1000), scenario.stop)
    else:
        stop = Fraction(arguments.seconds or FOREVER).limit_denominator(1000)
    scenario = scenario.model_copy(update={"stop": scenario.index(stop) * scenario.step})
    names = ("tve", "dropout", "latency", "gross_error_probability", "rate", "seed")
    overrides = {name: getattr(arguments, name) for name in names if getattr(arguments, name) is not None}
    say = partial(console.print, highlight=False, markup=False)
    with study.prepared(scenario, arguments.fmu, say) as plan, TemporaryDirectory() as folder:
        channel = Fmu(study.built("pmu", "PmuChannel", arguments.fmu, say), Path(folder))
        arranged, sites = playback.arranged(plan, channel, overrides)
        asyncio.run(serve(arguments, arranged, sites, say))
    return 0


async def serve(arguments: argparse.Namespace, plan: Plan, sites: list[playback.Site], say: Callable[[str], None]):
    """Play until the plan's end, or until SIGINT or SIGTERM."""
    rates = {site.channel.parameters.get("rate", DEFAULT_RATE) for site in sites}
    if len(rates) > 1:
        raise UserError(f"the PMUs send {sorted(rates)} frames/s; one stream has one rate: give --rate")
    of_pu = playback.bases(arguments.kv, arguments.mva)
    rate = rates.pop()
    if rate != round(rate) or rate < 1:
        raise UserError(f"{rate:g} frames/s: a stream sends a whole number of frames a second; give --rate")
    told = playback.configuration(sites, arguments.idcode, round(rate), arguments.nominal, of_pu, arguments.integers)
    send_to = tuple(settings.address(text) for text in arguments.send_to)
    async with Server(told, arguments.port, arguments.host, f"pmu {arguments.source}", send_to) as server:
        names = ", ".join(site.name for site in sites)
        say(f"C37.118 on {arguments.host}:{server.port} (TCP, UDP), IDCODE {told.idcode}, {rate:g} frames/s: {names}")
        say(f"1 pu is {arguments.kv:g} kV and {arguments.mva:g} MVA; Ctrl-C stops it")
        while arguments.wait and not server.listeners:
            await asyncio.sleep(0.05)
        soc = math.ceil(time.time())
        await asyncio.sleep(soc - time.time())
        playing = asyncio.ensure_future(
            playback.play(playback.Frames(plan, sites, told, of_pu, soc), server, arguments.speed, say)
        )
        for number in (signal.SIGINT, signal.SIGTERM):
            with contextlib.suppress(NotImplementedError):  # Windows
                asyncio.get_running_loop().add_signal_handler(number, playing.cancel)
        with contextlib.suppress(asyncio.CancelledError):
            await playing
        say(f"{server.sent} frames sent, {server.dropped} not taken by clients that were too slow")
