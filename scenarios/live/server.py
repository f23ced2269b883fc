"""A PMU or PDC as a server on asyncio: TCP and UDP with commands on one port, and UDP that it sends by itself.

A client that reads too slowly misses frames, which are counted; nobody waits for it and nothing piles up.
"""

import asyncio
import contextlib
import time
from typing import Any, NamedTuple

from . import c37118
from .c37118 import CONFIG_1, CONFIG_2, CONFIG_3, Command, Configuration, Data, FrameError, Stamp
from .splitter import Splitter

LOCAL = "127.0.0.1"

MOST_UNSENT = 1 << 18
"""Bytes that may wait for one client."""

MOST_CLIENTS = 64

CONFIGURATION_EVERY = 60.0
"""s; to those that cannot ask (UDP by itself)."""


class Address(NamedTuple):
    host: str
    port: int


class Client:
    """Somebody who asks: over TCP, or over UDP from one address."""

    def __init__(self, name: str, write: Any, unsent: Any):
        self.name, self.write, self.unsent = name, write, unsent
        self.splitter = Splitter()
        self.on = False
        self.dropped = 0


class Server:
    """Listens while its context is open; `send` hands a data frame to whoever has turned the data on."""

    def __init__(
        self,
        configuration: Configuration,
        port: int,
        host: str = LOCAL,
        header: str = "",
        send_to: tuple[Address, ...] = (),
    ):
        self.host, self.port, self.header, self.send_to = host, port, header, send_to
        self.clients: dict[Any, Client] = {}
        self.sent = 0
        self.dropped = 0
        """Frames that clients missed because they read too slowly."""
        self.reconfigure(configuration)

    def reconfigure(self, configuration: Configuration) -> None:
        """Data are of this configuration from now on. (STAT's bit should have announced it.)"""
        self.configuration, self.layout = configuration, c37118.layout(configuration)

    async def __aenter__(self) -> "Server":
        self.tcp = await asyncio.start_server(self.accept, self.host, self.port)
        self.port = self.tcp.sockets[0].getsockname()[1]  # 0 asks for a free one
        loop = asyncio.get_running_loop()
        self.udp, _ = await loop.create_datagram_endpoint(lambda: Requests(self), local_addr=(self.host, self.port))
        self.repeating = asyncio.ensure_future(self.repeat_configuration())
        return self

    async def __aexit__(self, *exception: object) -> None:
        self.repeating.cancel()
        self.tcp.close()
        self.udp.close()
        for key in list(self.clients):
            if isinstance(key, asyncio.StreamWriter):
                key.close()
        self.clients.clear()

    async def repeat_configuration(self) -> None:
        while True:
            for address in self.send_to:
                self.udp.sendto(self.configuration_frame(CONFIG_2), address)
            await asyncio.sleep(CONFIGURATION_EVERY)

    def configuration_frame(self, kind: int) -> bytes:
        asked = self.configuration._replace(kind=kind, stamp=Stamp(int(time.time())))
        return c37118.encode_configuration(asked)

    @property
    def listeners(self) -> int:
        """Clients that have turned the data on."""
        return sum(client.on for client in self.clients.values()) + len(self.send_to)

    def send(self, data: Data) -> None:
        self.send_frame(c37118.encode_data(data, self.layout))

    def send_frame(self, frame: bytes) -> None:
        self.sent += 1
        for address in self.send_to:
            self.udp.sendto(frame, address)
        for client in self.clients.values():
            if client.on and client.unsent() < MOST_UNSENT:
                client.write(frame)
            elif client.on:
                client.dropped += 1
                self.dropped += 1

    async def accept(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        name = "{}:{}".format(*writer.get_extra_info("peername")[:2])
        client = Client(name, writer.write, writer.transport.get_write_buffer_size)
        if len(self.clients) >= MOST_CLIENTS:
            writer.close()
            return
        self.clients[writer] = client
        try:
            while received := await reader.read(1 << 12):
                self.take(client, received)
        except ConnectionError:
            pass
        finally:
            self.clients.pop(writer, None)
            writer.close()

    def take(self, client: Client, received: bytes) -> None:
        """Commands for this stream; whatever else it may be is ignored."""
        for frame in client.splitter.feed(received):
            with contextlib.suppress(FrameError):
                idcode, _, command, _ = c37118.decode_command(frame)
                if idcode == self.configuration.idcode:
                    self.obey(client, command)

    def obey(self, client: Client, command: int) -> None:
        kinds = {
            Command.SEND_CONFIG_1: CONFIG_1,
            Command.SEND_CONFIG_2: CONFIG_2,
            Command.SEND_CONFIG_3: CONFIG_3,
        }
        if command in (Command.DATA_ON, Command.DATA_OFF):
            client.on = command == Command.DATA_ON
        elif command == Command.SEND_HEADER:
            stamp = Stamp(int(time.time()))
            client.write(c37118.encode_header(self.configuration.idcode, stamp, self.header))
        elif command in kinds:
            client.write(self.configuration_frame(kinds[Command(command)]))


class Requests(asyncio.DatagramProtocol):
    """Commands over UDP: every address that asks is a client, up to MOST_CLIENTS."""

    def __init__(self, server: Server):
        self.server = server

    def connection_made(self, transport: Any) -> None:
        self.transport = transport

    def datagram_received(self, data: bytes, addr: Any) -> None:
        clients = self.server.clients
        if addr not in clients and len(clients) < MOST_CLIENTS:
            clients[addr] = Client(
                f"{addr[0]}:{addr[1]}/udp",
                lambda frame: self.transport.sendto(frame, addr),
                self.transport.get_write_buffer_size,
            )
        if addr in clients:
            self.server.take(clients[addr], data)
            clients[addr].splitter.buffer.clear()
            if not clients[addr].on:
                del clients[addr]
