"""Refusals, as the client sees them: TMCLReplyStatusError with the right status (decisions §2)."""

from __future__ import annotations

import pytest
from harness import assert_in_step
from pytrinamic.connections.tmcl_interface import TmclInterface
from pytrinamic.modules import TMCM1311
from pytrinamic.tmcl import GetInfo, GetInfoRequestError, TMCLReplyStatusError, TMCLRequest, TMCLStatus
from pytrinamic.tmcl import TMCLCommand as Command

INVALID_COMMAND = TMCLStatus.INVALID_COMMAND
WRONG_TYPE = TMCLStatus.WRONG_TYPE
INVALID_VALUE = TMCLStatus.INVALID_VALUE
NOT_AVAILABLE = TMCLStatus.COMMAND_NOT_AVAILABLE

#: (command, type, motor or bank, value), and what the module says to it.
REFUSALS = [
    # Commands that this module does not have.
    ((0, 0, 0, 0), INVALID_COMMAND),
    ((16, 0, 0, 0), INVALID_COMMAND),
    ((Command.SAC, 0, 0, 0), INVALID_COMMAND),
    ((Command.CALCVV, 0, 0, 0), INVALID_COMMAND),
    ((Command.TMCL_UF0, 0, 0, 0), INVALID_COMMAND),
    ((Command.TMCL_UF7, 0, 0, 0), INVALID_COMMAND),
    ((Command.RAMDEBUG, 0, 0, 0), INVALID_COMMAND),
    ((Command.ASSIGNMENT, 0, 0, 0), INVALID_COMMAND),
    ((Command.READ_MC, 0, 0, 0), INVALID_COMMAND),
    ((Command.WRITE_DRV, 0, 0, 0), INVALID_COMMAND),
    ((Command.BOOT_GET_INFO, 0, 0, 0), INVALID_COMMAND),
    # Flow control belongs in programs.
    ((Command.JA, 0, 0, 0), NOT_AVAILABLE),
    ((Command.JC, 0, 0, 0), NOT_AVAILABLE),
    ((Command.CSUB, 0, 0, 0), NOT_AVAILABLE),
    ((Command.RSUB, 0, 0, 0), NOT_AVAILABLE),
    ((Command.WAIT, 0, 0, 0), NOT_AVAILABLE),
    ((Command.STOP, 0, 0, 0), NOT_AVAILABLE),
    ((Command.COMP, 0, 0, 0), NOT_AVAILABLE),
    ((Command.CLE, 0, 0, 0), NOT_AVAILABLE),
    ((Command.VECT, 0, 0, 0), NOT_AVAILABLE),
    ((Command.RETI, 0, 0, 0), NOT_AVAILABLE),
    ((Command.EI, 0, 0, 0), NOT_AVAILABLE),
    ((Command.DI, 0, 0, 0), NOT_AVAILABLE),
    # Parameters, banks and types that do not exist, or not for this.
    ((Command.GAP, 250, 0, 0), WRONG_TYPE),
    ((Command.SAP, 250, 0, 0), WRONG_TYPE),
    ((Command.SAP, 8, 0, 0), WRONG_TYPE),
    ((Command.GAP, 29, 0, 0), WRONG_TYPE),
    ((Command.STAP, 0, 0, 0), WRONG_TYPE),
    ((Command.RSAP, 0, 0, 0), WRONG_TYPE),
    ((Command.MVP, 3, 0, 0), WRONG_TYPE),
    ((Command.RFS, 3, 0, 0), WRONG_TYPE),
    ((Command.GGP, 0, 1, 0), WRONG_TYPE),
    ((Command.GGP, 0, 4, 0), WRONG_TYPE),
    ((Command.GGP, 63, 0, 0), WRONG_TYPE),
    ((Command.GGP, 3, 3, 0), WRONG_TYPE),
    ((Command.SGP, 128, 0, 0), WRONG_TYPE),
    ((Command.STGP, 0, 1, 0), WRONG_TYPE),
    ((Command.RSGP, 0, 1, 0), WRONG_TYPE),
    ((Command.GIO, 0, 3, 0), WRONG_TYPE),
    ((Command.SIO, 8, 2, 0), WRONG_TYPE),
    ((Command.CALC, 10, 0, 0), WRONG_TYPE),
    ((Command.GET_FIRMWARE_VERSION, 2, 0, 0), WRONG_TYPE),
    # Values out of range, and motors that there are not.
    ((Command.SAP, 6, 0, 256), INVALID_VALUE),
    ((Command.SAP, 6, 0, -1), INVALID_VALUE),
    ((Command.SAP, 6, 1, 0), INVALID_VALUE),
    ((Command.GAP, 6, 1, 0), INVALID_VALUE),
    ((Command.GAP, 6, 255, 0), INVALID_VALUE),
    ((Command.STAP, 6, 1, 0), INVALID_VALUE),
    ((Command.ROR, 0, 1, 0), INVALID_VALUE),
    ((Command.ROL, 0, 1, 0), INVALID_VALUE),
    ((Command.MST, 0, 1, 0), INVALID_VALUE),
    ((Command.MVP, 0, 1, 0), INVALID_VALUE),
    ((Command.ROR, 0, 0, 327_680_000), INVALID_VALUE),
    ((Command.MVP, 2, 0, 21), INVALID_VALUE),
    ((Command.SCO, 21, 0, 0), INVALID_VALUE),
    ((Command.SGP, 65, 0, 12), INVALID_VALUE),
    ((Command.SIO, 0, 2, 2), INVALID_VALUE),
    # Two at once: command, type, motor or bank, value, in this order.
    ((Command.GAP, 250, 1, 0), WRONG_TYPE),
    ((Command.SAP, 8, 1, -1), WRONG_TYPE),
    ((Command.MVP, 3, 1, 0), WRONG_TYPE),
    ((Command.SIO, 8, 2, 2), WRONG_TYPE),
]  # fmt: skip


def refusal(connection: TmclInterface, request: TMCLRequest) -> TMCLReplyStatusError:
    """What the client raises for a request."""
    with pytest.raises(TMCLReplyStatusError) as raised:
        connection.send_request(request)
    return raised.value


def test_refusals(connection: TmclInterface) -> None:
    """Each gets its status, its own command number, the value 0, and leaves the line in step."""
    heard = {}
    for fields, _ in REFUSALS:
        error = refusal(connection, TMCLRequest(1, *fields))
        assert (error.reply.command, error.reply.value) == (fields[0], 0)
        heard[fields] = error.status_code
    assert heard == dict(REFUSALS)
    assert_in_step(connection)


def test_the_lock_comes_before_the_value(connection: TmclInterface) -> None:
    """And after the type."""
    connection.set_global_parameter(73, 0, 1234)
    assert refusal(connection, TMCLRequest(1, Command.SGP, 65, 0, 12)).status_code == TMCLStatus.EEPROM_LOCKED
    assert refusal(connection, TMCLRequest(1, Command.SGP, 63, 0, 12)).status_code == WRONG_TYPE


def test_wrong_checksum(connection: TmclInterface) -> None:
    """Status 1, command 0, value 0 (decisions §1.3), and nothing is done."""
    error = refusal(connection, TMCLRequest(1, Command.SAP, 6, 0, 55, checksum=0x55))
    assert (error.status_code, error.reply.command, error.reply.value) == (TMCLStatus.WRONG_CHECKSUM, 0, 0)
    assert_in_step(connection)
    assert connection.get_axis_parameter(6, 0) == 128


def test_the_error_describes_itself(module: TMCM1311) -> None:
    """Through the client's methods, with the client's words."""
    with pytest.raises(TMCLReplyStatusError) as raised:
        module.set_axis_parameter(6, 0, 256)
    assert raised.value.status_code == INVALID_VALUE
    assert raised.value.error_description == "Invalid Value"


def test_every_command_number_is_answered(connection: TmclInterface) -> None:
    """One reply each, but for those that are meant to be different (decisions §1.10): the client never waits in vain."""
    different = {136, 138, 139}  # no checksum; two replies; another protocol
    changes = {Command.START_DOWNLOAD_MODE, Command.QUIT_DOWNLOAD_MODE}
    for number in sorted(set(range(256)) - different - changes):
        try:
            reply = connection.send(number, 0, 0, 0)
        except TMCLReplyStatusError as error:
            reply = error.reply
        assert reply.command in (number, 0) or number == Command.READ_TMCL_MEMORY
    assert_in_step(connection)


class TestGetInfo:
    """Command 157, which only later firmware has: status 2 (decisions §1.10), on which the client raises its own error."""

    ENTRIES = sorted(name for name, entry in vars(GetInfo).items() if isinstance(entry, type))

    @pytest.mark.parametrize("entry", [*ENTRIES, 0, 200, 255])
    def test_it_is_refused(self, connection: TmclInterface, entry: str | int) -> None:
        """By name and by number."""
        with pytest.raises(GetInfoRequestError) as raised:
            connection.get_info(entry)
        assert raised.value.tmcl_error.status_code == INVALID_COMMAND
        assert "Invalid Command" in str(raised.value)
        assert_in_step(connection)
