"""The TMCM-1076, which PyTrinamic has no class for, as its generic interface sees it."""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from harness import Port, Server, binary, status_of
from pytrinamic.connections.tmcl_interface import TmclInterface
from pytrinamic.tmcl import TMCLCommand as Command
from pytrinamic.tmcl import TMCLStatus

#: Module number and version (decisions §1.5).
VERSION_NUMBER = 0x0434_0102

MAX_CURRENT, TSTEP, MICROSTEPS, STALLGUARD_THRESHOLD, CHOPCONF = 6, 135, 140, 174, 138


@pytest.fixture
def port(serve: Callable[..., Server], link: str, transport: str) -> Port:
    """A TMCM-1076 fresh from the factory, on both kinds of port."""
    return serve("--tcp", "127.0.0.1:0", "--pty", link, module="tmcm-1076").port(transport)


@pytest.fixture
def connection(port: Port) -> Iterator[TmclInterface]:
    """A connected client."""
    with port.connect() as connection:
        yield connection


def tmcl(command: str, port: Port, *arguments: str) -> str:
    """What our own tool prints when it talks to the same port."""
    place = f"tcp://{port.place}" if port.transport == "tcp" else port.place
    run = subprocess.run([binary(), command, "--port", place, *arguments], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    return run.stdout


def test_who_it_is(connection: TmclInterface) -> None:
    assert connection.get_version_string() == "1076V102"
    reply = connection.send(Command.GET_FIRMWARE_VERSION, 1, 0, 0)
    assert (reply.status, reply.value, reply.reply_address, reply.module_address) == (100, VERSION_NUMBER, 2, 1)


def test_axis_parameters(connection: TmclInterface) -> None:
    assert connection.get_axis_parameter(MAX_CURRENT, 0) == 24
    assert connection.get_axis_parameter(TSTEP, 0) == 1_048_575
    connection.set_axis_parameter(MAX_CURRENT, 0, 31)
    assert connection.get_axis_parameter(MAX_CURRENT, 0) == 31
    connection.set_axis_parameter(STALLGUARD_THRESHOLD, 0, -64)
    assert connection.get_axis_parameter(STALLGUARD_THRESHOLD, 0, signed=True) == -64
    connection.store_axis_parameter(MAX_CURRENT, 0)
    connection.set_axis_parameter(MAX_CURRENT, 0, 5)
    connection.restore_axis_parameter(MAX_CURRENT, 0)
    assert connection.get_axis_parameter(MAX_CURRENT, 0) == 31


def test_inputs(connection: TmclInterface) -> None:
    assert [connection.get_digital_input(number) for number in (0, 1)] == [0, 0]


@pytest.mark.parametrize(
    ("request_fields", "status"),
    [
        ((Command.ROR, 0, 0, 100), TMCLStatus.INVALID_COMMAND),
        ((Command.MVP, 0, 0, 100), TMCLStatus.INVALID_COMMAND),
        ((Command.MST, 0, 0, 0), TMCLStatus.INVALID_COMMAND),
        ((Command.GGP, 66, 0, 0), TMCLStatus.INVALID_COMMAND),
        ((Command.SIO, 0, 2, 1), TMCLStatus.INVALID_COMMAND),
        ((132, 0, 0, 0), TMCLStatus.INVALID_COMMAND),
        ((Command.TMCL_UF0, 0, 0, 0), TMCLStatus.INVALID_COMMAND),
        ((Command.GAP, 1, 0, 0), TMCLStatus.WRONG_TYPE),
        ((Command.GIO, 2, 0, 0), TMCLStatus.WRONG_TYPE),
        ((Command.SAP, MAX_CURRENT, 0, 32), TMCLStatus.INVALID_VALUE),
    ],
)
@pytest.mark.parametrize("transport", ["tcp"])
def test_what_it_refuses(
    connection: TmclInterface, request_fields: tuple[int, int, int, int], status: TMCLStatus
) -> None:
    assert status_of(connection.send, *request_fields) == status


def test_our_own_tools_at_the_same_port(port: Port, tmp_path: Path) -> None:
    with port.connect() as connection:
        connection.set_axis_parameter(MICROSTEPS, 0, 6)
    assert "microsteps_64" in tmcl("get", port, "microstep_resolution")
    tmcl("set", port, "microstep_interpolation=on")
    settings = tmp_path / "settings.toml"
    settings.write_text(tmcl("dump", port))
    with port.connect() as connection:
        connection.set_axis_parameter(MICROSTEPS, 0, 2)
    tmcl("apply", port, str(settings))
    with port.connect() as connection:
        assert connection.get_axis_parameter(MICROSTEPS, 0) == 6


def test_a_neighbour_with_the_same_address_is_noticed(serve: Callable[..., Server]) -> None:
    server = serve("--tcp", "127.0.0.1:0", module="tmcm-1311 tmcm-1076")
    assert "m1 and m2 have the same address 1" in server.stderr()
