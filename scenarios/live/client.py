"""A client of a PMU or PDC on asyncio: TCP, UDP with commands, and UDP that comes by itself (annex F).

It connects to the configured host only, for ever again, and stops when it is cancelled.
"""

import asyncio
import contextlib
import socket
import time
from collections.abc import Callable
from ipaddress import ip_address
from typing import Any, Literal, NamedTuple

from .session import Arrived, Configured, Session

TICK = 0.1
"""s."""

SILENCE = 3.0
"""s without a data frame: then the connection is made anew."""

FIRST_PAUSE, LONGEST_PAUSE = 0.2, 5.0
"""s, before the next attempt to connect; doubled from attempt to attempt."""

RECEIVE_BUFFER = 1 << 20
"""Bytes; what the system keeps of datagrams that are not yet read."""


class Source(NamedTuple):
    host: str
    port: int
    transport: Literal["tcp", "udp", "udp_spontaneous"] = "tcp"
    """udp_spontaneous listens on `port` for what `host` sends by itself."""


Deliver = Callable[[Configured | Arrived], None]


async def receive(source: Source, session: Session, deliver: Deliver, silence: float = SILENCE) -> None:
    """Connect and deliver events until cancelled."""
    connect = over_tcp if source.transport == "tcp" else over_udp
    pause = FIRST_PAUSE
    while True:
        frames = session.counters.frames
        try:
            await connect(source, session, deliver, silence)
            session.say(f"{source.host}:{source.port}: the connection has ended")
        except OSError as error:
            session.say(f"{source.host}:{source.port}: {error.strerror or error}")
        pause = FIRST_PAUSE if session.counters.frames > frames else min(2 * pause, LONGEST_PAUSE)
        await asyncio.sleep(pause)


async def over_tcp(source: Source, session: Session, deliver: Deliver, silence: float) -> None:
    async with asyncio.timeout(LONGEST_PAUSE):
        reader, writer = await asyncio.open_connection(source.host, source.port)
    session.connected(time.time())
    reading = asyncio.ensure_future(reader.read(1 << 16))
    try:
        while not silent(session, silence):
            flush(session, writer.write)
            await asyncio.wait([reading], timeout=TICK)
            if reading.done():
                if not (received := reading.result()):
                    return
                reading = asyncio.ensure_future(reader.read(1 << 16))
                for event in session.receive(received, time.time()):
                    deliver(event)
            session.tick(time.time())
    finally:
        reading.cancel()
        with contextlib.suppress(OSError):
            session.farewell(time.time())
            flush(session, writer.write)
            writer.close()


async def over_udp(source: Source, session: Session, deliver: Deliver, silence: float) -> None:
    loop = asyncio.get_running_loop()
    by_itself = source.transport == "udp_spontaneous"
    ends = await loop.run_in_executor(None, socket.getaddrinfo, source.host, source.port, 0, socket.SOCK_DGRAM)
    family, *_, address = ends[0]
    host = str(address[0])
    every, own = ("::", "::1") if family == socket.AF_INET6 else ("0.0.0.0", "127.0.0.1")
    here = own if ip_address(host).is_loopback else every
    transport, _ = await loop.create_datagram_endpoint(
        lambda: Datagrams(session, deliver, host),
        local_addr=(here, source.port) if by_itself else None,
        remote_addr=None if by_itself else (host, source.port),
        family=family,
    )
    try:
        transport.get_extra_info("socket").setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER)
        session.connected(time.time())
        while by_itself or not silent(session, silence):
            flush(session, transport.sendto)
            await asyncio.sleep(TICK)
            session.tick(time.time())
    finally:
        session.farewell(time.time())
        flush(session, transport.sendto)
        transport.close()


class Datagrams(asyncio.DatagramProtocol):
    def __init__(self, session: Session, deliver: Deliver, host: str):
        self.session, self.deliver, self.host = session, deliver, host

    def connection_made(self, transport: Any) -> None:
        self.transport = transport

    def datagram_received(self, data: bytes, addr: Any) -> None:
        if addr[0] == self.host:
            for event in self.session.receive(data, time.time(), whole=True):
                self.deliver(event)
            if self.session.commands:
                flush(self.session, self.transport.sendto)

    def error_received(self, exc: Exception) -> None:
        pass  # nobody there yet: the silence ends the connection


def silent(session: Session, silence: float) -> bool:
    period = session.layout.configuration.period if session.layout else 0.0
    return time.time() - session.last_data > max(silence, 5 * period)


def flush(session: Session, write: Callable[[bytes], Any]) -> None:
    for frame in session.outgoing:
        write(frame)
    session.outgoing.clear()
