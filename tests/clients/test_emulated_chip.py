"""The firmware on an emulated Cortex-M3, driven as the virtual module is: by PyTrinamic over TCP and PTY, and by `tmcl`.

    cargo xtask firmware
    cargo build --profile system-tests --workspace --bin emulated-module

Environment variable EMULATED_MODULE names the program. The chip computes its physics in software and is slower than the clock
while a motor turns, so moves are short.
"""

from __future__ import annotations

import json
import signal
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import host
import pytest
from harness import EmulatedChip, Port, Server, datagram, status_of, wait_for
from host import CONNECTION, TMCL_STATUS, notation, tmcl
from pytrinamic.connections.tmcl_interface import TmclInterface
from pytrinamic.modules import TMCM1311, TMCM1640
from pytrinamic.tmcl import TMCLCommand, TMCLStatus
from test_programs import COUNT, VARIABLES, download, mode, run
from test_tmcm1640_motion import configure, configure_encoder

#: Counts of the encoder, whatever the client's class calls them.
ENCODER = 209

#: Command 255 wants this.
MAGIC = 1234

#: What is in COUNT, with fewer rounds: the chip takes its time.
ROUNDS = 100
PROGRAM = [(command, kind, motor, ROUNDS if value == 1000 else value) for command, kind, motor, value in COUNT]

#: (command, type, motor or bank, value), and what both modules say to it.
REFUSALS = [
    ((0, 0, 0, 0), TMCLStatus.INVALID_COMMAND),
    ((TMCLCommand.BOOT_GET_INFO, 0, 0, 0), TMCLStatus.INVALID_COMMAND),
    ((TMCLCommand.GAP, 99, 0, 0), TMCLStatus.WRONG_TYPE),
    ((TMCLCommand.GGP, 0, 4, 0), TMCLStatus.WRONG_TYPE),
    ((TMCLCommand.GAP, 4, 1, 0), TMCLStatus.INVALID_VALUE),
    ((TMCLCommand.SGP, 65, 0, 12), TMCLStatus.INVALID_VALUE),
    ((TMCLCommand.JA, 0, 0, 0), TMCLStatus.COMMAND_NOT_AVAILABLE),
]


def move_a_stepper(connection: TmclInterface) -> None:
    """Half a turn, and back by a quarter. Standing, it lags behind by friction."""
    motor = TMCM1311(connection).motors[0]
    turn, counts = 51_200, motor.get_axis_parameter(motor.AP.EncoderResolution)
    motor.linear_ramp.max_velocity = 100_000
    motor.linear_ramp.max_acceleration = 500_000
    for target in (25_600, 12_800):
        motor.move_to(target)
        wait_for(motor.get_position_reached, f"position {target}")
        assert motor.actual_position == target
        expected = target * counts // turn
        wait_for(lambda there=expected: abs(motor.get_axis_parameter(ENCODER) - there) <= 10, "rest")


def move_a_servo(connection: TmclInterface) -> None:
    """A turn and a half with field-oriented control, and back by a turn."""
    module = TMCM1640(connection)
    motor = module.motors[0]
    configure(module, 1000, 10_000)
    configure_encoder(module, motor.ENUM.ENCODER_INIT_MODE_0)
    motor.actual_position = 0
    places = []
    for target in (6144, 2048):
        motor.move_to(target)
        wait_for(motor.get_position_reached, f"position {target}")
        wait_for(lambda target=target: abs(motor.actual_position - target) <= 5 and motor.actual_velocity == 0, "rest")
        places.append((motor.actual_position, motor.get_axis_parameter(ENCODER)))
    # The initialisation turns the rotor before the first motion, so that only distances compare.
    (there, counted_there), (back, counted_back) = places
    assert abs((there - back) - (counted_there - counted_back)) <= 10, places


@dataclass(frozen=True)
class Kind:
    """A kind of module."""

    version: str
    max_velocity: int
    move: Callable[[TmclInterface], None]


KINDS = {
    "tmcm-1311": Kind("1311V111", 51_200, move_a_stepper),
    "tmcm-1640": Kind("1640V200", 4000, move_a_servo),
}

#: Who is held to the same: the chip, and the virtual module as the other tests have it.
TARGETS: dict[str, tuple[type[Server], tuple[str, ...]]] = {
    "chip": (EmulatedChip, ()),
    "virtual": (Server, ("--speed", "20")),
}

Serve = Callable[..., Server]


@pytest.fixture(params=KINDS)
def name(request: pytest.FixtureRequest) -> str:
    """Which module."""
    return request.param


@pytest.fixture(params=TARGETS)
def target(request: pytest.FixtureRequest) -> str:
    """What it is."""
    return request.param


@pytest.fixture
def start(serve: Serve, link: str, tmp_path: Path) -> Callable[[str, str], Server]:
    """Starts a module on one TCP port and one pseudo terminal; what it stored is there again when it is started again."""

    def start(target: str, name: str) -> Server:
        kind, more = TARGETS[target]
        memory = ("--memory", str(tmp_path / "chip.psram")) if target == "chip" else ("--state", str(tmp_path / "state"))
        return serve("--tcp", "127.0.0.1:0", "--pty", link, *memory, *more, module=name, kind=kind)

    return start


def reply(status: int, command: int, value: int = 0) -> bytes:
    """The bytes of a reply: to host 2, from module 1."""
    body = bytes([2, 1, status, command]) + value.to_bytes(4, "big", signed=True)
    return body + bytes([sum(body) & 0xFF])


def parameters(connection: TmclInterface, kind: Kind) -> None:
    """Set, read, stored and brought back."""
    assert connection.get_version_string() == kind.version
    assert connection.get_axis_parameter(4, 0) == kind.max_velocity
    connection.set_axis_parameter(4, 0, 1111)
    connection.store_axis_parameter(4, 0)
    connection.set_axis_parameter(4, 0, 2222)
    assert connection.get_axis_parameter(4, 0) == 2222
    connection.send(TMCLCommand.RSAP, 4, 0, 0)
    assert connection.get_axis_parameter(4, 0) == 1111
    connection.set_global_parameter(7, VARIABLES, -4711)
    connection.store_global_parameter(7, VARIABLES)
    connection.set_global_parameter(7, VARIABLES, 1)
    assert connection.get_global_parameter(7, VARIABLES, signed=True) == 1
    connection.send(TMCLCommand.RSGP, 7, VARIABLES, 0)
    assert connection.get_global_parameter(7, VARIABLES, signed=True) == -4711


def program(connection: TmclInterface) -> None:
    """Downloaded, read back, run."""
    download(connection, PROGRAM)
    for address, (command, kind, motor, value) in enumerate(PROGRAM):
        read = connection.send(TMCLCommand.READ_TMCL_MEMORY, 0, 0, address)
        assert (read.module_address, read.status, read.command, read.value) == (command, kind, motor, value)
    run(connection)
    wait_for(lambda: mode(connection) == 0, "the program stops")
    assert connection.get_global_parameter(0, VARIABLES) == ROUNDS


def refusals(port: Port) -> None:
    """What is wrong is said, and what comes in one go is answered in order, without a byte lost."""
    broken = datagram(TMCLCommand.SAP, 4, 0, 55)[:-1] + b"\x00"
    requests = [(datagram(*request), reply(status, request[0])) for request, status in REFUSALS]
    requests.append((broken, reply(TMCLStatus.WRONG_CHECKSUM, 0)))
    requests += [(datagram(TMCLCommand.GGP, 7, VARIABLES), reply(100, TMCLCommand.GGP, -4711))] * 200
    expected = b"".join(answer for _, answer in requests)
    with port.open_raw() as line:
        line.write(b"".join(request for request, _ in requests))
        assert line.read(len(expected)) == expected


def reset(port: Port) -> None:
    """Command 255, which has no reply, and what comes until the module is back is lost."""
    with port.open_raw() as line:
        line.write(datagram(255, 0, 0, MAGIC))
    at = ("--port", notation(port))
    wait_for(lambda: host.run("get", "--raw", "axis.4", *at).stdout == "1111\n", "the stored value is back")


def test_a_session(start: Callable[[str, str], Server], name: str, target: str, transport: str) -> None:
    """All that a client does in a day."""
    kind = KINDS[name]
    port = start(target, name).port(transport)
    with port.connect() as connection:
        parameters(connection, kind)
        program(connection)
        for request, status in REFUSALS:
            assert status_of(connection.send, *request) == status
    refusals(port)
    with port.connect() as connection:
        connection.set_axis_parameter(4, 0, 2222)
        kind.move(connection)
        connection.set_global_parameter(8, VARIABLES, 1)
    reset(port)
    with port.connect() as connection:
        # What was stored is back, and what was only set is gone.
        assert connection.get_global_parameter(8, VARIABLES) == 0
        assert connection.get_axis_parameter(4, 0) == 1111
        assert connection.get_axis_parameter(1, 0) == 0
        assert connection.get_global_parameter(7, VARIABLES, signed=True) == -4711
        assert connection.send(TMCLCommand.READ_TMCL_MEMORY, 0, 0, 2).value == ROUNDS


def test_what_is_stored_outlives_the_process(start: Callable[[str, str], Server], name: str, link: str) -> None:
    """Ended by either signal, it ends well, and its link is gone; one memory is for one chip at a time."""
    for how, before, after in [(signal.SIGINT, KINDS[name].max_velocity, 1111), (signal.SIGTERM, 1111, 2222)]:
        chip = start("chip", name)
        with chip.port("pty").connect() as connection:
            assert connection.get_axis_parameter(4, 0) == before
            connection.set_axis_parameter(4, 0, after)
            connection.store_axis_parameter(4, 0)
        assert chip.stop(how) == 0
        assert chip.rest_of_stdout() == []
        assert not Path(link).is_symlink()


def test_a_killed_one_leaves_nothing_behind(start: Callable[[str, str], Server], link: str) -> None:
    """Killed without a chance to end QEMU, it lets go of the memory, where what was stored is."""
    name = "tmcm-1311"
    chip = start("chip", name)
    with chip.port("tcp").connect() as connection:
        connection.set_axis_parameter(4, 0, 1111)
        connection.store_axis_parameter(4, 0)
    chip.kill()
    assert Path(link).is_symlink(), "what nobody could take away is replaced"
    with start("chip", name).port("pty").connect() as connection:
        assert connection.get_axis_parameter(4, 0) == 1111


def test_the_host_tools(start: Callable[[str, str], Server], serve: Serve, name: str, tmp_path: Path) -> None:
    """`tmcl` finds on the chip what it finds at a virtual module."""
    server = start("chip", name)
    at = ("--port", notation(server.port("tcp")))
    terminal = ("--port", notation(server.port("pty")))
    virtual = ("--port", notation(serve("--tcp", "127.0.0.1:0", "--speed", "20", module=name).port("tcp")))

    def same(*arguments: str, **options: Any) -> str:
        texts = [
            tmcl(*arguments, *port, folder=tmp_path, **options).stdout.replace(port[1], "PORT") for port in (at, virtual)
        ]
        assert texts[0] == texts[1]
        return texts[0]

    assert name.upper() in tmcl("info", *at).stdout
    same("dump")
    (tmp_path / "settings.toml").write_text(tmcl("dump", *at).stdout)
    same("set", "max_velocity=2222")
    assert same("get", "--raw", "max_velocity") == "2222\n"
    assert tmcl("get", "--raw", "max_velocity", *terminal).stdout == "2222\n"
    same("apply", "settings.toml", "--store")
    assert same("get", "--raw", "max_velocity") == f"{KINDS[name].max_velocity}\n"
    (tmp_path / "once.tmc").write_text(f"//! module: {name}\n    SGP 1, 2, 4711\n")
    done = tmcl("download", "once.tmc", "--verify", *at, folder=tmp_path)
    assert "2 instructions of 2048 stored, read back and the same" in done.stderr
    tmcl("download", "once.tmc", *virtual, folder=tmp_path)
    # It reads the whole memory, which takes a while; once is enough.
    if name == "tmcm-1640":
        assert "SGP 1, 2, 4711" in same("upload")
    assert same("status").startswith("stopped")
    tmcl("start", "0", *at)
    wait_for(lambda: json.loads(tmcl("exec", "GGP 1, 2", "--json", *at).stdout)[0]["value"] == 4711, "the program")
    wait_for(lambda: tmcl("status", *at).stdout.startswith("stopped"), "the program ends")
    same("exec", "GAP 99, 0", code=TMCL_STATUS)
    tmcl("info", "--address", "9", "--timeout", "200ms", "--retries", "0", *at, code=CONNECTION)
