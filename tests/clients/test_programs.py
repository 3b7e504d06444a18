"""A program downloaded, run, stepped, stopped and read through nothing but PyTrinamic's own `send`."""

from __future__ import annotations

from collections.abc import Sequence

import pytest
from harness import Port, Server, status_of, wait_for
from pytrinamic.connections.tmcl_interface import TmclInterface
from pytrinamic.tmcl import TMCLCommand, TMCLStatus

Instruction = tuple[int, int, int, int]

#: User variables are bank 2.
VARIABLES = 2

#: Counts variable 0 up to 1000 in a subroutine and stops.
COUNT: Sequence[Instruction] = [
    (TMCLCommand.SGP, 0, VARIABLES, 0),
    (TMCLCommand.CSUB, 0, 0, 5),
    (TMCLCommand.COMP, 0, 0, 1000),
    (TMCLCommand.JC, 6, 0, 1),
    (TMCLCommand.STOP, 0, 0, 0),
    (TMCLCommand.GGP, 0, VARIABLES, 0),
    (TMCLCommand.CALC, 0, 0, 1),
    (TMCLCommand.AGP, 0, VARIABLES, 0),
    (TMCLCommand.RSUB, 0, 0, 0),
]


def download(connection: TmclInterface, program: Sequence[Instruction]) -> None:
    """132, the instructions, 133."""
    connection.send(TMCLCommand.START_DOWNLOAD_MODE, 0, 0, 0)
    for instruction in program:
        assert connection.send(*instruction).status == TMCLStatus.COMMAND_LOADED
    connection.send(TMCLCommand.QUIT_DOWNLOAD_MODE, 0, 0, 0)


def run(connection: TmclInterface, address: int = 0) -> None:
    """131, 129."""
    connection.send(TMCLCommand.RESET_APPLICATION, 0, 0, 0)
    connection.send(TMCLCommand.RUN_APPLICATION, 1, 0, address)


def mode(connection: TmclInterface) -> int:
    """0 stop, 1 run, 2 step, 3 reset; the program counter is below it."""
    return connection.send(TMCLCommand.GET_APPLICATION_STATUS, 0, 0, 0).value >> 24


def test_a_program_runs(connection: TmclInterface) -> None:
    """1000 rounds of eight instructions, 50 µs each, are 0.4 s of virtual time."""
    download(connection, COUNT)
    assert mode(connection) == 0
    run(connection)
    wait_for(lambda: mode(connection) == 0, "the program stops")
    assert connection.get_global_parameter(0, VARIABLES) == 1000


def test_it_is_read_back(connection: TmclInterface) -> None:
    """134 answers with the seven bytes of an instruction; the client reads them as module, status, command and value."""
    download(connection, COUNT)
    for address, (command, kind, motor, value) in enumerate(COUNT):
        reply = connection.send(TMCLCommand.READ_TMCL_MEMORY, 0, 0, address)
        assert (reply.module_address, reply.status, reply.command, reply.value) == (command, kind, motor, value)


def test_direct_mode_does_not_disturb_it(connection: TmclInterface) -> None:
    """Reading never touches the accumulator of a program that computes with it (TMCM-1311 §5.5)."""
    download(connection, COUNT)
    run(connection)
    while mode(connection) == 1:
        assert connection.get_axis_parameter(140, 0) == 8
        assert connection.get_analog_input(0) >= 0
    assert connection.get_global_parameter(0, VARIABLES) == 1000


def test_it_is_stopped_goes_on_and_is_stepped(connection: TmclInterface) -> None:
    """128 and 129, type 0; 130 executes one instruction before its reply."""
    loop = [
        (TMCLCommand.GGP, 0, VARIABLES, 0),
        (TMCLCommand.CALC, 0, 0, 1),
        (TMCLCommand.AGP, 0, VARIABLES, 0),
        (TMCLCommand.JA, 0, 0, 0),
    ]
    download(connection, loop)
    run(connection)
    wait_for(lambda: connection.get_global_parameter(0, VARIABLES) > 10, "the program counts")
    connection.send(TMCLCommand.STOP_APPLICATION, 0, 0, 0)
    assert mode(connection) == connection.get_global_parameter(128, 0) == 0
    count, address = connection.get_global_parameter(0, VARIABLES), connection.get_global_parameter(130, 0)
    assert connection.get_global_parameter(0, VARIABLES) == count
    for _ in range(8):
        connection.send(TMCLCommand.STEP_APPLICATION, 0, 0, 0)
        address = (address + 1) % 4
        assert connection.get_global_parameter(130, 0) == address
    assert mode(connection) == 2
    assert connection.get_global_parameter(0, VARIABLES) == count + 2
    connection.send(TMCLCommand.RUN_APPLICATION, 0, 0, 0)
    wait_for(lambda: connection.get_global_parameter(0, VARIABLES) > count + 10, "the program goes on")


def test_routines_are_called_at_their_addresses(connection: TmclInterface) -> None:
    """TMCM-1311 §11.6: jumps at 0, 1 and 2 lead to routines that a host starts with command 129."""
    jumps = [(TMCLCommand.JA, 0, 0, 3 + 2 * routine) for routine in range(3)]
    routines = [
        instruction
        for routine in range(3)
        for instruction in ((TMCLCommand.SGP, 0, VARIABLES, 100 + routine), (TMCLCommand.STOP, 0, 0, 0))
    ]
    download(connection, jumps + routines)
    for routine in (2, 0, 1):
        run(connection, routine)
        wait_for(lambda: mode(connection) == 0, "the program stops")
        assert connection.get_global_parameter(0, VARIABLES) == 100 + routine


@pytest.mark.parametrize("address", [-1, 2048])
def test_an_address_outside_the_memory(connection: TmclInterface, address: int) -> None:
    """Status 4, as every value out of range."""
    for command in (TMCLCommand.RUN_APPLICATION, TMCLCommand.START_DOWNLOAD_MODE):
        kind = 1 if command == TMCLCommand.RUN_APPLICATION else 0
        assert status_of(connection.send, command, kind, 0, address) == TMCLStatus.INVALID_VALUE


def test_a_second_client_looks_on(server: Server, port: Port) -> None:
    """While one port downloads, what comes from another is executed."""
    with port.connect() as programmer, server.port("tcp").connect() as observer:
        programmer.send(TMCLCommand.START_DOWNLOAD_MODE, 0, 0, 0)
        assert observer.get_global_parameter(129, 0) == 1
        assert observer.get_axis_parameter(140, 0) == 8
        assert programmer.send(TMCLCommand.STOP, 0, 0, 0).status == TMCLStatus.COMMAND_LOADED
        programmer.send(TMCLCommand.QUIT_DOWNLOAD_MODE, 0, 0, 0)
        assert observer.get_global_parameter(129, 0) == 0
