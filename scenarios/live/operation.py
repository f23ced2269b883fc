"""The service in operation: its connections and sinks, from the start to a clean stop."""

import asyncio
import contextlib
import signal

from . import client, sinks
from .client import Source
from .server import Server
from .service import Service

EVERY = 10.0
"""s between two reports."""


async def operate(service: Service, seconds: float | None = None, once: bool = False) -> None:
    """Until SIGINT or SIGTERM, or `seconds`; `once`: until every machine has been tracked."""
    stopping = asyncio.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        with contextlib.suppress(NotImplementedError):  # Windows
            asyncio.get_running_loop().add_signal_handler(number, stopping.set)
    given = service.given
    async with contextlib.AsyncExitStack() as open_:
        open_.callback(service.close)
        files = None
        if given.csv and not once:
            files = sinks.CsvFiles(given.csv, given.beside(given.csv.folder), service)
            open_.callback(files.close)  # after the service's last estimates: those are handed out before
            open_.callback(service.flush)
            service.sinks.append(files)
        if given.c37118 and not once:
            await open_.enter_async_context(out(service))
        if given.metrics and not once:
            web = await asyncio.start_server(lambda r, w: answer(service, r, w), given.metrics.host, given.metrics.port)
            open_.callback(web.close)
            service.say(f"metrics: http://{given.metrics.host}:{web.sockets[0].getsockname()[1]}/metrics")
        for feed in service.feeds:
            source = Source(feed.given.host, feed.given.port, feed.given.transport)
            receiving = asyncio.ensure_future(
                client.receive(source, feed.session, lambda event, feed=feed: service.deliver(feed, event))
            )
            open_.push_async_callback(ended, receiving)
        await wait(service, stopping, seconds, once, files)
        for line in service.report():
            service.say(line)


@contextlib.asynccontextmanager
async def out(service: Service):
    """The C37.118 stream of the estimates; its configuration follows the rate of the streams that come in."""
    given = service.given.c37118
    assert given
    told = sinks.configuration(given, service)
    async with Server(told, given.port, given.host, "pmu-observer", tuple(given.send_to)) as server:
        service.say(f"estimates: C37.118 on {given.host}:{server.port}, IDCODE {given.idcode}")
        service.configured = lambda: server.reconfigure(sinks.configuration(given, service))
        service.sinks.append(sinks.Stream(server))
        service.output = server
        yield server


async def wait(service: Service, stopping: asyncio.Event, seconds: float | None, once: bool, files) -> None:
    clock = asyncio.get_running_loop().time
    start = reported = clock()
    while not stopping.is_set() and (seconds is None or clock() - start < seconds):
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(stopping.wait(), 0.2)
        if once and all(unit.tracked for unit in service.units):
            return
        if files:
            files.flush()
        if clock() - reported >= EVERY:
            reported = clock()
            for line in service.report():
                service.say(line)


async def ended(task: asyncio.Task) -> None:
    task.cancel()
    await asyncio.gather(task, return_exceptions=True)


async def answer(service: Service, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    """GET /metrics, and nothing else."""
    with contextlib.suppress(OSError, TimeoutError, ValueError, asyncio.IncompleteReadError):
        async with asyncio.timeout(5.0):
            request = await reader.readline()
            while (await reader.readline()).strip():
                pass
            found = request.split()[:2] == [b"GET", b"/metrics"]
            body = ("\n".join(sinks.metrics(service)) + "\n" if found else "see /metrics\n").encode()
            head = "200 OK" if found else "404 Not Found"
            kind = "text/plain; version=0.0.4; charset=utf-8"
            writer.write(f"HTTP/1.1 {head}\r\nContent-Type: {kind}\r\nContent-Length: {len(body)}\r\n".encode())
            writer.write(b"Connection: close\r\n\r\n" + body)
            await writer.drain()
    writer.close()
