"""`tmcl serve` as a program: what it prints, and how it ends."""

from __future__ import annotations

import os
import re
import signal
import stat
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from harness import Port, Server, assert_in_step
from pytrinamic.connections import ConnectionManager
from pytrinamic.modules import TMCM1311

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
    suggestions = set(re.findall(r"--interface \w+ --port [^\s\"'`]+", server.stderr()))
    assert suggestions == {port.arguments() for port in server.ports}
    for arguments in suggestions:
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


def test_links_and_files_in_the_way(serve: Callable[..., Server], tmp_path: Path) -> None:
    """What a killed server left behind is replaced."""
    link = tmp_path / "left_behind"
    killed = Server("--pty", str(link))
    killed.kill()
    server = serve("--pty", str(link))
    with Port("pty", str(link)).connect() as connection:
        assert_in_step(connection)
    assert server.stop() == 0
    assert not os.path.lexists(link)
