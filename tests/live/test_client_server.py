"""Client and server over real sockets: the conversation, every transport, and what neither of them may do."""

import asyncio
import socket

import pytest

from scenarios.live import c37118
from scenarios.live.c37118 import CONFIG_2, CONFIG_3, Command, Stamp
from scenarios.live.client import Source
from scenarios.live.server import MOST_UNSENT, Address, Server

from .frames import configuration, data
from .loopback import Received, connected, listening, run, when


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@pytest.mark.parametrize("transport", ["tcp", "udp"])
@pytest.mark.parametrize("kind", [CONFIG_2, CONFIG_3])
def test_a_conversation(transport, kind):
    told = configuration(kind)

    async def test():
        async with Server(told, 0) as server:
            source = Source("127.0.0.1", server.port, transport)
            async with listening(source, Received(7, third=kind == CONFIG_3)) as received:
                await connected(server)
                for number in range(30):
                    server.send(data(told, number))
                await when(lambda: len(received.arrived) == 30)
                assert received.configured[0].configuration.stations[1].name == "STATION 2"
                assert received.configured[0].configuration.kind == kind
                assert [event.data.stamp for event in received.arrived] == [data(told, k).stamp for k in range(30)]
                assert received.arrived[3].t == pytest.approx(3 / 60, abs=1e-7)
                assert received.arrived[3].troubles == ("", "", "")
            await when(lambda: not server.listeners)  # it turned the data off

    run(test)


def test_udp_that_comes_by_itself():
    """No command is sent; frames before the first configuration are counted, not read."""
    told, port = configuration(), free_port()

    async def test():
        source = Source("127.0.0.1", port, "udp_spontaneous")
        async with (
            listening(source, Received(7, commands=False)) as received,
            Server(told, 0, send_to=(Address("127.0.0.1", port),)) as server,
        ):
            while not received.configured:  # the first may come before the client listens
                server.udp.sendto(server.configuration_frame(CONFIG_2), ("127.0.0.1", port))
                await asyncio.sleep(0.02)
            for number in range(10):
                server.send(data(told, number))
            await when(lambda: len(received.arrived) == 10)
            assert not server.clients  # it never asked

    run(test)


def test_datagrams_of_another_host_are_not_read():
    told, port = configuration(), free_port()
    elsewhere = Source("127.0.0.2", port, "udp_spontaneous")

    async def test():
        received = Received(7, commands=False)
        async with listening(elsewhere, received):
            await asyncio.sleep(0.05)
            with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
                for _ in range(3):
                    other.sendto(c37118.encode_configuration(told), ("127.0.0.1", port))
                    await asyncio.sleep(0.02)
            assert not received.events

    run(test)


def test_frames_of_another_stream_are_not_read():
    told = configuration()

    async def test():
        async with (
            Server(told, 0) as server,
            listening(Source("127.0.0.1", server.port), Received(7)) as received,
        ):
            await connected(server)
            server.send(data(told, 0)._replace(idcode=8))
            server.send(data(told, 1))
            await when(lambda: received.arrived)
            assert received.arrived[0].data.idcode == 7

    run(test)


def test_a_command_for_another_stream_is_not_obeyed():
    async def test():
        async with Server(configuration(), 0, header="Bus 30") as server:
            reader, writer = await asyncio.open_connection("127.0.0.1", server.port)
            writer.write(b"\xaaGET / HTTP/1.1\r\n")
            writer.write(c37118.encode_command(9, Stamp(0), Command.SEND_CONFIG_2))
            writer.write(c37118.encode_command(7, Stamp(0), Command.SEND_HEADER))
            frame = await reader.readexactly(c37118.size_announced(start := await reader.readexactly(4)) - 4)
            assert c37118.decode_header(start + frame)[2] == "Bus 30"
            writer.close()

    run(test)


def test_a_slow_reader_misses_frames_and_nobody_waits():
    told = configuration()

    async def test():
        async with Server(told, 0) as server:
            _, writer = await asyncio.open_connection("127.0.0.1", server.port, limit=1 << 12)
            writer.write(c37118.encode_command(7, Stamp(0), Command.DATA_ON))
            await connected(server)
            async with listening(Source("127.0.0.1", server.port), Received(7)) as received:
                await when(lambda: server.listeners == 2)
                frames = 0
                while not server.dropped:
                    for _ in range(200):
                        server.send(data(told, frames))
                        frames += 1
                    await when(lambda: len(received.arrived) == frames)  # noqa: B023
                assert all(one.unsent() < 2 * MOST_UNSENT for one in server.clients.values())
                assert len(received.arrived) == frames
            writer.close()

    run(test)


def test_nothing_listens_on_other_interfaces():
    async def test():
        async with Server(configuration(), 0) as server:
            assert server.tcp.sockets[0].getsockname()[0] == "127.0.0.1"
            assert server.udp.get_extra_info("sockname")[0] == "127.0.0.1"

    run(test)
