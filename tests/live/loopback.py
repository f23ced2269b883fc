"""A server and a client on a real socket of this machine."""

import asyncio
from collections.abc import Awaitable, Callable
from contextlib import asynccontextmanager

from scenarios.live import client
from scenarios.live.client import Source
from scenarios.live.server import Server
from scenarios.live.session import Arrived, Configured, Session

LIMIT = 10.0
"""s; no test waits longer."""


class Received:
    """What a client received, and what it said."""

    def __init__(self, idcode: int, **options):
        self.events: list[Configured | Arrived] = []
        self.said: list[str] = []
        self.session = Session(idcode, say=self.said.append, **options)

    @property
    def arrived(self) -> list[Arrived]:
        return [event for event in self.events if isinstance(event, Arrived)]

    @property
    def configured(self) -> list[Configured]:
        return [event for event in self.events if isinstance(event, Configured)]


@asynccontextmanager
async def listening(source: Source, received: Received, silence: float = client.SILENCE):
    """A client of the source while the context is open."""
    task = asyncio.ensure_future(client.receive(source, received.session, received.events.append, silence))
    try:
        yield received
    finally:
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)


async def when(condition: Callable[[], object]) -> None:
    """Returns when it holds, and fails after LIMIT."""
    async with asyncio.timeout(LIMIT):
        while not condition():
            await asyncio.sleep(0.005)


async def connected(server: Server) -> None:
    await when(lambda: server.listeners)


def run(test: Callable[[], Awaitable[None]]) -> None:
    async def limited():
        async with asyncio.timeout(3 * LIMIT):
            await test()

    asyncio.run(limited())


def write(server: Server, raw: bytes) -> None:
    """Any bytes, to whoever has turned the data on."""
    for one in server.clients.values():
        if one.on:
            one.write(raw)
