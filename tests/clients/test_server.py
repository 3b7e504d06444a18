"""`tmcl serve` as a program: what it prints, and how it ends."""

from __future__ import annotations

import os
import re
import signal
import stat
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from harness import PATIENCE_S, Server, assert_in_step, binary, datagram, wait_for
from pytrinamic.connections import ConnectionManager
from pytrinamic.modules import TMCM1311
from pytrinamic.tmcl import TMCLCommand

#: `tmcl --help`, "Exit codes".
EXIT_CONNECTION = 3

SIGNALS = [signal.SIGTERM, signal.SIGINT]


def test_one_line_per_port_and_nothing_else_on_stdout(serve: Callable[..., Server], link: str) -> None:
    """Scripts read these lines (as this suite does), so that stdout carries nothing else."""
    server = serve("--tcp", "127.0.0.1:0", "--pty", link, "--tcp", "127.0.0.1:0", "--pty", f"{link}2")
    assert [port.place for port in server.ports if port.transport == "pty"] == [link, f"{link}2"]
    numbers = [port.address() for port in server.ports if port.transport == "tcp"]
    assert len(set(numbers)) == 2
    assert all(host == "127.0.0.1" and number != 0 for host, number in numbers)
    for port in server.ports:
        with port.connect() as connection:
            assert_in_step(connection)
    assert server.stop() == 0
    assert server.rest_of_stdout() == []


def test_stderr_has_arguments_to_copy_and_paste(server: Server) -> None:
    """What it suggests for PyTrinamic works as it stands, for every port."""

    def suggestions() -> set[str]:
        return set(re.findall(r"--interface \w+ --port [^\s\"'`]+", server.stderr()))

    expected = {port.arguments() for port in server.ports}
    wait_for(lambda: len(suggestions()) == len(expected), "a suggestion for every port")
    assert suggestions() == expected
    for arguments in expected:
        with ConnectionManager(arguments).connect() as connection:
            assert_in_step(connection)


def test_the_pty_is_a_link_to_a_terminal(server: Server) -> None:
    """A fixed name for a device that is a new one each time."""
    path = Path(server.port("pty").place)
    assert path.is_symlink()
    assert stat.S_ISCHR(path.stat().st_mode)


@pytest.mark.parametrize("how", SIGNALS, ids=lambda how: how.name)
def test_a_signal_ends_it_cleanly(server: Server, how: signal.Signals) -> None:
    """Exit code 0, and the link is gone."""
    path = Path(server.port("pty").place)
    assert server.stop(how) == 0
    assert not os.path.lexists(path)


@pytest.mark.parametrize("how", SIGNALS, ids=lambda how: how.name)
def test_a_signal_ends_it_with_clients_connected_and_the_motor_turning(server: Server, how: signal.Signals) -> None:
    """A client that stays does not hold it up."""
    path = Path(server.port("pty").place)
    with server.port("tcp").connect() as one, server.port("pty").connect() as other:
        TMCM1311(one).rotate(0, 51200)
        assert_in_step(other)
        assert server.stop(how) == 0
    assert not os.path.lexists(path)


@pytest.mark.parametrize("how", SIGNALS, ids=lambda how: how.name)
def test_a_signal_ends_it_although_a_client_does_not_read(server: Server, transport: str, how: signal.Signals) -> None:
    """The line is full, in both directions, and a server that waits for it waits for ever."""
    with server.port(transport).open_raw() as line:
        line.fill(datagram(TMCLCommand.GAP, 1) * 100, 4 << 20)
        assert server.stop(how) == 0
    assert not os.path.lexists(server.port("pty").place)


def test_the_same_ports_again_after_it_ended(serve: Callable[..., Server], server: Server, link: str) -> None:
    """Restarting right away works, also where a client was connected when it ended."""
    tcp = server.port("tcp").place
    with server.port("tcp").connect() as connection:
        assert_in_step(connection)
        assert server.stop() == 0
    again = serve("--tcp", tcp, "--pty", link)
    assert [(port.transport, port.place) for port in again.ports] == [("tcp", tcp), ("pty", link)]
    for port in again.ports:
        with port.connect() as connection:
            assert_in_step(connection)


def test_virtual_time_keeps_the_pace_it_was_told(serve: Callable[..., Server]) -> None:
    """Generously: at speed 20 the tick timer (ms) runs faster than the wall clock by far, at speed 1/4 slower."""

    def pace(speed: str) -> float:
        server = serve("--tcp", "127.0.0.1:0", "--speed", speed)
        with server.port("tcp").connect() as connection:
            timer = TMCM1311.GP0.tickTimer
            began, first = time.monotonic(), connection.get_global_parameter(timer, 0)
            time.sleep(0.4)
            last, ended = connection.get_global_parameter(timer, 0), time.monotonic()
        return (last - first) / (ended - began) / 1000

    assert 0.05 < pace("0.25") < 0.75
    assert pace("20") > 4


def test_the_link_of_a_killed_server_is_replaced(serve: Callable[..., Server], link: str) -> None:
    """Nobody had the chance to remove it, and it is in nobody's use."""
    Server("--pty", link).kill()
    assert os.path.lexists(link)
    server = serve("--pty", link)
    with server.port("pty").connect() as connection:
        assert_in_step(connection)
    assert server.stop() == 0
    assert not os.path.lexists(link)


class TestItDoesNotStart:
    """What is in the way stays as it is; stderr names it, and the exit code says so."""

    @staticmethod
    def refusal(*arguments: str) -> str:
        """What `tmcl serve` says when it does not start."""
        command = [str(binary()), "serve", "tmcm-1311", *arguments]
        result = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S, check=False)
        assert result.returncode == EXIT_CONNECTION, result.stderr
        assert "panicked" not in result.stderr
        return result.stderr

    def test_a_file_in_the_way(self, tmp_path: Path) -> None:
        """It might be anything."""
        path = tmp_path / "precious"
        path.write_text("precious")
        assert str(path) in self.refusal("--pty", str(path))
        assert path.read_text() == "precious"

    def test_the_link_of_a_server_that_runs(self, server: Server) -> None:
        """Its clients go on finding it."""
        port = server.port("pty")
        assert port.place in self.refusal("--pty", port.place)
        with port.connect() as connection:
            assert_in_step(connection)

    def test_the_tcp_port_of_a_server_that_runs(self, server: Server) -> None:
        """Likewise."""
        port = server.port("tcp")
        assert port.place in self.refusal("--tcp", port.place)
        with port.connect() as connection:
            assert_in_step(connection)

    def test_it_takes_back_what_it_had_begun(self, tmp_path: Path, link: str) -> None:
        """The first link goes when the second cannot be made."""
        path = tmp_path / "precious"
        path.write_text("precious")
        assert str(path) in self.refusal("--pty", link, "--pty", str(path))
        assert not os.path.lexists(link)
