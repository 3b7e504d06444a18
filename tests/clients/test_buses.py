"""Two modules on one bus: RS485 over TCP and a pseudo terminal, CAN through a serial adapter (slcan)."""

from __future__ import annotations

from collections.abc import Callable

import can
import pytest
import serial
from conftest import SPEED
from harness import PATIENCE_S, Server, datagram, wait_for
from pytrinamic.connections import SerialTmclInterface, SocketTmclInterface
from pytrinamic.modules import TMCM1311, TMCM1640
from pytrinamic.tmcl import TMCLCommand, TMCLReply

STEPPER_AND_BRUSHLESS = "tmcm-1311@1 tmcm-1640@2"
TWO_STEPPERS = "tmcm-1311@1 tmcm-1311@3"
TURN = 51_200


@pytest.mark.parametrize("kind", [SocketTmclInterface, SerialTmclInterface])
def test_a_stepper_and_a_brushless_motor_on_one_line(serve: Callable[..., Server], link: str, kind: type) -> None:
    """Both move at the same time, each as its own class says, over one connection."""
    server = serve("--tcp", "127.0.0.1:0", "--pty", link, "--speed", SPEED, module=STEPPER_AND_BRUSHLESS)
    transport = "tcp" if kind is SocketTmclInterface else "pty"
    with server.port(transport).connect() as connection:
        assert type(connection) is kind
        assert [connection.get_version_string(address) for address in (1, 2)] == ["1311V111", "1640V200"]
        stepper = TMCM1311(connection, module_id=1).motors[0]
        brushless = TMCM1640(connection, module_id=2).motors[0]
        stepper.linear_ramp.max_velocity = TURN
        stepper.linear_ramp.max_acceleration = TURN
        stepper.move_to(2 * TURN)
        brushless.rotate(500)
        wait_for(stepper.get_position_reached, "the stepper arrives")
        assert stepper.actual_position == 2 * TURN
        wait_for(lambda: abs(brushless.actual_velocity - 500) <= 25, "the brushless motor turns")
        brushless.stop()
        wait_for(lambda: brushless.actual_velocity == 0, "the brushless motor stands")
        assert stepper.actual_position == 2 * TURN


def test_a_new_address_over_the_line(serve: Callable[..., Server], link: str) -> None:
    """The old address answers, and then the new one only (decisions §2a.11)."""
    server = serve("--pty", link, module=STEPPER_AND_BRUSHLESS)
    with server.port("pty").connect() as connection:
        assert connection.set_global_parameter(66, 0, 9, module_id=2).module_address == 2
        assert connection.get_version_string(9) == "1640V200"
        assert connection.get_version_string(1) == "1311V111"


def test_at_a_baud_rate(serve: Callable[..., Server], link: str) -> None:
    """A line at 9600 baud, the rate that modules come with; a request and its reply take at least 18.75 ms of virtual time."""
    server = serve("--pty", link, "--baud", "9600", module=STEPPER_AND_BRUSHLESS)
    with server.port("pty").connect("--data-rate 9600") as connection:
        assert [connection.get_version_string(address) for address in (1, 2)] == ["1311V111", "1640V200"]
        before = connection.get_global_parameter(132, 0, module_id=1)
        after = connection.get_global_parameter(132, 0, module_id=1)
        assert after - before >= 18


def test_a_line_that_follows_its_terminal(serve: Callable[..., Server], link: str) -> None:
    """Who scans the baud rates finds the one that the module has."""
    server = serve("--pty", link, "--baud", "auto", "--speed", "5")
    request, found = datagram(TMCLCommand.GGP, 66), []
    for baud in (115_200, 19_200, 9600, 57_600):
        with serial.Serial(server.port("pty").place, baudrate=baud, timeout=PATIENCE_S if baud == 9600 else 0.2) as line:
            line.write(request)
            if line.read(9) == TMCLReply(2, 1, 100, TMCLCommand.GGP, 1).to_buffer():
                found.append(baud)
    assert found == [9600]


def test_two_steppers_on_can(serve: Callable[..., Server], link: str) -> None:
    """PyTrinamic's slcan interface, as its users choose it; it sends eight bytes a frame."""
    server = serve("--slcan", link, "--speed", SPEED, module=TWO_STEPPERS)
    with server.port("slcan").connect() as connection:
        assert [connection.get_version_string(address) for address in (1, 3)] == ["1311V111", "1311V111"]
        motors = [TMCM1311(connection, module_id=address).motors[0] for address in (1, 3)]
        for motor, turns in zip(motors, (1, -2)):
            motor.linear_ramp.max_velocity = TURN
            motor.linear_ramp.max_acceleration = TURN
            motor.move_to(turns * TURN)
        for motor, turns in zip(motors, (1, -2)):
            wait_for(motor.get_position_reached, f"{turns} turns")
            assert motor.actual_position == turns * TURN


def test_a_can_bus_has_one_rate(serve: Callable[..., Server], link: str) -> None:
    """A module at 1 Mbit/s hears nothing at 500 kbit/s; frames have the identifiers of GP 71 and 70, and 7 bytes."""
    server = serve("--slcan", link, module=TWO_STEPPERS)
    request = can.Message(arbitration_id=3, is_extended_id=False, data=datagram(TMCLCommand.GGP, 71)[1:8])
    for bitrate, answers in ((500_000, False), (1_000_000, True)):
        adapter = can.Bus(interface="slcan", channel=server.port("slcan").place, bitrate=bitrate, sleep_after_open=0)
        with adapter as bus:
            bus.send(request)
            reply = bus.recv(PATIENCE_S if answers else 0.3)
            assert (reply is not None) == answers
    assert reply is not None
    assert (reply.arbitration_id, reply.is_extended_id) == (2, False)
    assert bytes(reply.data) == bytes([3, 100, TMCLCommand.GGP, 0, 0, 0, 3])


def test_the_adapter_answers_as_lawicels_does(serve: Callable[..., Server], link: str) -> None:
    """CR for done, BEL for not done; a closed channel passes nothing; time stamps when they are asked for."""
    server = serve("--slcan", link)
    request = b"t0017" + datagram(TMCLCommand.GGP, 66)[1:8].hex().upper().encode() + b"\r"
    reply = b"t0027" + bytes([1, 100, TMCLCommand.GGP, 0, 0, 0, 1]).hex().upper().encode()
    with server.port("slcan").open_raw() as line:

        def say(text: bytes, answer: bytes) -> None:
            line.write(text)
            assert line.read(len(answer)) == answer, text

        say(b"\r\r\r", b"\r\r\r")
        say(b"V\r", b"V1013\r")
        say(b"N\r", b"NTMCL\r")
        say(request, b"\a")
        say(b"nonsense\r", b"\a")
        say(b"S8\r", b"\r")
        say(b"O\r", b"\r")
        say(b"S6\r", b"\a")
        say(request, b"z\r" + reply + b"\r")
        say(b"r0017\r", b"z\r")
        say(b"T000000017" + b"00" * 7 + b"\r", b"Z\r")
        say(b"F\r", b"F00\r")
        say(b"C\r", b"\r")
        say(b"Z1\r", b"\r")
        say(b"L\r", b"\r")
        say(request, b"\a")
        say(b"C\r", b"\r")
        say(b"O\r", b"\r")
        line.write(request)
        stamped = line.read(len(b"z\r" + reply) + 5)
        assert stamped.startswith(b"z\r" + reply) and stamped.endswith(b"\r")
        assert int(stamped[-5:-1], 16) < 60_000
