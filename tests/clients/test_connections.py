"""Connecting, leaving and coming back; one client, two clients, clients that misbehave."""

from __future__ import annotations

import contextlib
import os
import select
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import pytest
from harness import INTERFACES, PATIENCE_S, Port, Server, assert_in_step, datagram, wait_for
from pytrinamic.connections import ConnectionManager, SerialTmclInterface, SocketTmclInterface
from pytrinamic.connections.tmcl_interface import TmclInterface
from pytrinamic.modules import TMCM1311
from pytrinamic.tmcl import TMCLCommand, TMCLReply

CLASSES = {"tcp": SocketTmclInterface, "pty": SerialTmclInterface}

#: A get-axis-parameter datagram that lacks its end.
CUT_OFF = datagram(TMCLCommand.GAP, 1)[:5]

#: Longer than a partial datagram lives (decisions §1.3: 100 ms on a stream without a baud rate).
SILENCE_S = 0.25


def test_connection_manager_as_the_examples_use_it(port: Port, transport: str) -> None:
    """`--interface … --port …` in one string, connect, use, disconnect; twice, because it keeps its settings."""
    manager = ConnectionManager(f"--interface {INTERFACES[transport]} --port {port.place}")
    for _ in range(2):
        connection = manager.connect()
        assert type(connection) is CLASSES[transport]
        assert connection.get_version_string() == "1311V111"
        manager.disconnect()


def test_version(connection: TmclInterface) -> None:
    """Command 136: characters without a checksum in place of a reply (type 0), then a number (type 1)."""
    assert connection.get_version_string() == "1311V111"
    assert_in_step(connection)


@pytest.mark.parametrize("data_rate", [9600, 115200])
def test_the_data_rate_does_not_matter(port: Port, data_rate: int) -> None:
    """A pseudo terminal has no baud rate, nor has a socket; the client passes one anyhow."""
    with port.connect(f"--data-rate {data_rate}") as connection:
        assert connection.get_version_string() == "1311V111"


def test_every_byte_passes(connection: TmclInterface) -> None:
    """No byte means anything to the line: no line ends, flow control, interrupt or end of file (0A, 0D, 11, 13, 03, 04)."""
    for first in range(0, 256, 4):
        sent = int.from_bytes(bytes(range(first, first + 4)), "big")
        reply = connection.set_global_parameter(0, 2, sent)
        assert reply.value == sent
        assert connection.get_global_parameter(0, 2) == sent


def test_a_pseudo_terminal_is_raw_before_anybody_asks(server: Server) -> None:
    """A program that opens it like a file, without setting it up, is understood too: no echo, no line editing, no signals."""
    line = os.open(server.port("pty").place, os.O_RDWR | os.O_NOCTTY)
    try:
        for value in (0x0A0D_0304, 0x1113_7F1A, 0x1C15_1617):
            for command in (TMCLCommand.SGP, TMCLCommand.GGP):
                os.write(line, datagram(command, 0, 2, value))
                reply = b""
                while len(reply) < 9 and select.select([line], [], [], PATIENCE_S)[0]:
                    reply += os.read(line, 9 - len(reply))
                assert reply == TMCLReply(2, 1, 100, command, value).to_buffer()
    finally:
        os.close(line)


@pytest.fixture(params=["0.05", "1", "20"])
def paced_port(request: pytest.FixtureRequest, serve: Callable[..., Server], link: str, transport: str) -> Port:
    """Clients live in wall-clock time, so what they may expect does not depend on the speed of virtual time."""
    return serve("--tcp", "127.0.0.1:0", "--pty", link, "--speed", request.param).port(transport)


def test_a_datagram_may_come_in_pieces(paced_port: Port) -> None:
    """Nobody promises that a stream keeps nine bytes together, and 20 ms are no silence (decisions §1.3: 100 ms)."""
    request = datagram(TMCLCommand.GGP, 66)
    with paced_port.open_raw() as line:
        for pieces in ([request[:5], request[5:]], [bytes([byte]) for byte in request]):
            for piece in pieces:
                line.write(piece)
                time.sleep(0.02 if len(pieces) == 2 else 0)
            assert line.read(9) == TMCLReply(2, 1, 100, TMCLCommand.GGP, 1).to_buffer()


def test_a_stray_byte_is_forgotten(paced_port: Port) -> None:
    """A cut-off datagram and then silence: the next datagram of the same client is answered (decisions §1.3)."""
    with paced_port.open_raw() as line:
        line.write(CUT_OFF)
        time.sleep(SILENCE_S)
        line.write(datagram(TMCLCommand.GGP, 66))
        assert line.read(9) == TMCLReply(2, 1, 100, TMCLCommand.GGP, 1).to_buffer()


def test_many_datagrams_may_come_at_once(serve: Callable[..., Server], link: str, transport: str) -> None:
    """Every one gets its reply, in order, wherever the server's reads cut the stream (decisions §1.10).

    As fast as the module can be, because then the least time passes unnoticed between two reads.
    """
    server = serve("--tcp", "127.0.0.1:0", "--pty", link, "--speed", "1000")
    with server.port(transport).open_raw() as line:
        for first in range(0, 2000, 100):
            values = range(first, first + 100)
            line.write(b"".join(datagram(TMCLCommand.SGP, 0, 2, value) for value in values))
            for value in values:
                assert line.read(9) == TMCLReply(2, 1, 100, TMCLCommand.SGP, value).to_buffer()


def test_reconnecting_many_times(port: Port) -> None:
    """Fifty clients, one after the other without a pause."""
    for turn in range(50):
        with port.connect() as connection:
            assert connection.get_version_string() == "1311V111"
            connection.set_global_parameter(0, 2, turn)
            assert connection.get_global_parameter(0, 2) == turn


def test_the_module_runs_on_without_a_client(port: Port) -> None:
    """A module does not notice that its host has gone; it remembers what it was told."""
    with port.connect() as connection:
        motor = TMCM1311(connection).motors[0]
        motor.rotate(51200)
        left_at = motor.actual_position
    with port.connect() as connection:
        motor = TMCM1311(connection).motors[0]
        wait_for(lambda: motor.actual_position > left_at + 51200, "the motor turns on")
        assert motor.target_velocity == 51200


def test_a_client_that_leaves_in_mid_datagram(port: Port) -> None:
    """What it left half-said does not disturb the next one."""
    for length in (1, 5, 8):
        with port.open_raw() as line:
            line.write(datagram(TMCLCommand.GAP, 1)[:length])
        if port.transport == "pty":
            # The kernel does not tell whose bytes are whose on a pseudo terminal, so silence has to.
            time.sleep(SILENCE_S)
        with port.connect() as connection:
            assert_in_step(connection)


@pytest.mark.parametrize("reset", [False, True], ids=["closes", "crashes"])
def test_a_client_that_leaves_with_replies_unread(port: Port, reset: bool) -> None:
    """The next one hears only what it asked for itself."""
    with port.open_raw() as line:
        line.write(datagram(TMCLCommand.GAP, 1) * 20)
        line.close(reset=reset)
    if port.transport == "pty":
        # Until the replies lie in the terminal's buffer, which the client throws away when it opens the terminal.
        time.sleep(SILENCE_S)
    for _ in range(3):
        with port.connect() as connection:
            assert_in_step(connection)


def test_a_client_that_never_reads_stops_nobody_else(server: Server, transport: str) -> None:
    """Its line fills up and the module goes on; once it has gone, its TCP port is as good as new."""
    other = "pty" if transport == "tcp" else "tcp"
    with server.port(other).connect() as connection, server.port(transport).open_raw() as line:
        written = line.fill(datagram(TMCLCommand.GAP, 1) * 100, 4 << 20)
        assert written > 0
        for _ in range(10):
            assert_in_step(connection)
    if transport == "tcp":
        with server.port(transport).connect() as connection:
            assert_in_step(connection)


def test_clients_share_a_tcp_port(serve: Callable[..., Server]) -> None:
    """Four at once, as many as a module has ports. A fifth is sent away and disturbs nobody; who leaves makes room."""
    port = serve("--tcp", "127.0.0.1:0").port("tcp")
    with port.connect() as a, port.connect() as b, port.connect() as c:
        with port.connect() as d:
            for connection in (a, b, c, d):
                assert_in_step(connection)
            with port.open_raw() as fifth:
                assert fifth.read(1) == b""
            for connection in (a, b, c, d):
                assert_in_step(connection)

        def is_served() -> bool:
            with port.open_raw() as line, contextlib.suppress(ConnectionError):
                line.write(datagram(TMCLCommand.GGP, 66))
                return len(line.read(9)) == 9
            return False

        wait_for(is_served, "the fourth client's place is free")
        assert_in_step(a)


@pytest.mark.parametrize("transports", [("tcp", "tcp"), ("tcp", "pty"), ("pty", "pty")], ids=["tcp-tcp", "tcp-pty", "pty-pty"])
class TestTwoClients:
    """Two clients on two ports of one module."""

    @pytest.fixture
    def two(self, serve: Callable[..., Server], link: str, transports: tuple[str, str]) -> list[Port]:
        """The two ports."""
        places = {"tcp": "127.0.0.1:0", "pty": link}
        arguments: list[str] = []
        for index, transport in enumerate(transports):
            place = places[transport] if transport == "tcp" else f"{places[transport]}{index}"
            arguments += [f"--{transport}", place]
        server = serve(*arguments, "--speed", "20")
        assert sorted(port.transport for port in server.ports) == sorted(transports)
        assert len({port.place for port in server.ports}) == 2
        return server.ports

    def test_they_see_the_same_motor(self, two: list[Port]) -> None:
        """One starts it, the other sees it turn and stops it."""
        with two[0].connect() as one, two[1].connect() as other:
            mine, theirs = TMCM1311(one).motors[0], TMCM1311(other).motors[0]
            mine.drive_settings.max_current = 77
            assert theirs.drive_settings.max_current == 77
            mine.rotate(-51200)
            assert theirs.target_velocity == -51200
            wait_for(lambda: theirs.actual_velocity == -51200, "the other client sees full speed")
            theirs.stop()
            wait_for(lambda: mine.actual_velocity == 0, "the first client sees standstill")
            assert mine.actual_position == theirs.actual_position < 0

    def test_replies_go_to_who_asked(self, two: list[Port]) -> None:
        """Both at once, as fast as they can, each with its own user variable."""

        def talk(port: Port, number: int) -> None:
            with port.connect() as connection:
                for value in range(300):
                    reply = connection.set_global_parameter(number, 2, value)
                    assert (reply.command, reply.value) == (TMCLCommand.SGP, value)
                    assert connection.get_global_parameter(number, 2) == value

        with ThreadPoolExecutor() as pool:
            for done in [pool.submit(talk, port, number) for number, port in enumerate(two)]:
                done.result()

    def test_half_a_datagram_on_one_port_does_not_matter_on_the_other(self, two: list[Port]) -> None:
        """Each port finds its own datagrams."""
        with two[0].open_raw() as line, two[1].connect() as connection:
            line.write(CUT_OFF)
            assert_in_step(connection)


class TestAddresses:
    """Who is spoken to (decisions §1.3, §2a.11)."""

    def test_a_foreign_address_gets_no_reply(self, connection: TmclInterface) -> None:
        """It is ignored, and the next request is answered."""
        for address in (2, 9, 255):
            connection.send(TMCLCommand.SGP, 0, 2, 5, address, no_reply=True)
            assert_in_step(connection)
        assert connection.get_global_parameter(0, 2) == 0

    def test_the_address_on_the_command_line(self, serve: Callable[..., Server], link: str, transport: str) -> None:
        """`tmcm-1311@7`, and a client that says `--module-id 7`."""
        server = serve("--tcp", "127.0.0.1:0", "--pty", link, module="tmcm-1311@7")
        with server.port(transport).connect("--module-id 7") as connection:
            assert connection.get_version_string() == "1311V111"
            assert TMCM1311(connection, module_id=7).get_global_parameter(TMCM1311.GP0.serialAddress, 0) == 7
            connection.send(TMCLCommand.GAP, 1, 0, 0, 1, no_reply=True)
            reply = connection.send(TMCLCommand.GGP, 66, 0, 0)
            assert (reply.command, reply.module_address, reply.value) == (TMCLCommand.GGP, 7, 7)

    def test_a_new_address_takes_effect_after_its_reply(self, connection: TmclInterface) -> None:
        """The reply still carries the old one; then only the new one is obeyed."""
        reply = connection.set_global_parameter(TMCM1311.GP0.serialAddress, 0, 42)
        assert reply.module_address == 1
        connection.send(TMCLCommand.GAP, 1, 0, 0, 1, no_reply=True)
        reply = connection.send(TMCLCommand.GGP, TMCM1311.GP0.serialAddress, 0, 0, 42)
        assert (reply.command, reply.module_address, reply.value) == (TMCLCommand.GGP, 42, 42)

    def test_a_new_host_address(self, connection: TmclInterface) -> None:
        """Replies go to whom global parameter 76 says; the reply to the change itself went to the old one."""
        reply = connection.set_global_parameter(TMCM1311.GP0.serialHostAddress, 0, 99)
        assert reply.reply_address == 2
        assert connection.send(TMCLCommand.GAP, 1, 0, 0).reply_address == 99
