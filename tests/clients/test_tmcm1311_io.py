"""Digital and analogue inputs, digital outputs."""

from __future__ import annotations

import pytest
from harness import status_of
from pytrinamic.connections.tmcl_interface import TmclInterface
from pytrinamic.modules import TMCM1311
from pytrinamic.tmcl import TMCLCommand, TMCLStatus

OUTPUTS = [number for name, number in vars(TMCM1311.IO).items() if name.startswith("OUT")]
INPUTS = [number for name, number in vars(TMCM1311.IO).items() if name.startswith("IN")]


def outputs(module: TMCM1311) -> list[int]:
    """What all outputs read."""
    return [module.get_digital_output(number) for number in OUTPUTS]


def test_outputs_one_by_one(module: TMCM1311) -> None:
    """Each can be set and cleared, and no other follows."""
    assert outputs(module) == [0] * 8
    for number in OUTPUTS:
        module.set_digital_output(number)
        assert outputs(module) == [int(other == number) for other in OUTPUTS]
        module.clear_digital_output(number)
    assert outputs(module) == [0] * 8


def test_outputs_add_up(module: TMCM1311) -> None:
    """All on, then off one after the other."""
    for number in OUTPUTS:
        module.set_digital_output(number)
    for number in OUTPUTS:
        assert module.get_digital_output(number) == 1
        module.clear_digital_output(number)
        assert module.get_digital_output(number) == 0


def test_all_outputs_at_once(module: TMCM1311, connection: TmclInterface) -> None:
    """SIO 255, 2: a bit each; 3 sets OUT_0 and OUT_1 (decisions §5.1)."""
    connection.send(TMCLCommand.SIO, 255, 2, 3)
    assert outputs(module) == [1, 1, 0, 0, 0, 0, 0, 0]
    connection.send(TMCLCommand.SIO, 255, 2, 0xAA)
    assert outputs(module) == [0, 1, 0, 1, 0, 1, 0, 1]
    assert status_of(connection.send, TMCLCommand.SIO, 255, 2, 256) == TMCLStatus.INVALID_VALUE
    assert outputs(module) == [0, 1, 0, 1, 0, 1, 0, 1]


def test_digital_inputs(module: TMCM1311) -> None:
    """Eight of them, one at a time and all at once (port 255, decisions §3.13)."""
    levels = [module.get_digital_input(number) for number in INPUTS]
    assert len(levels) == 8
    assert set(levels) <= {0, 1}
    assert module.get_digital_input(255) == sum(level << number for number, level in zip(INPUTS, levels, strict=True))


def test_analogue_inputs(module: TMCM1311) -> None:
    """AIN_0 and AIN_4 (0 to 10 V in 12 bits), supply (0.1 V), temperature; the rest of bank 1 is currents."""
    for number in (0, 4):
        assert 0 <= module.get_analog_input(number) <= 4095
    assert 400 <= module.get_analog_input(8) <= 500
    assert 0 <= module.get_analog_input(9) <= 100
    for number in (10, 11, 12):
        assert isinstance(module.get_analog_input(number), int)
    assert module.get_analog_input(8) == module.get_axis_parameter(153, 0)


@pytest.mark.parametrize("number", [1, 2, 3, 5, 6, 7, 13, 255])
def test_other_analogue_inputs(module: TMCM1311, number: int) -> None:
    """Do not exist."""
    assert status_of(module.get_analog_input, number) == TMCLStatus.WRONG_TYPE


@pytest.mark.parametrize("number", [8, 100])
def test_other_digital_ports(module: TMCM1311, number: int) -> None:
    """Do not exist."""
    calls = [
        module.get_digital_input,
        module.get_digital_output,
        module.set_digital_output,
        module.clear_digital_output,
    ]
    for call in calls:
        assert status_of(call, number) == TMCLStatus.WRONG_TYPE


def test_inputs_cannot_be_set(connection: TmclInterface) -> None:
    """SIO on bank 0 and 1, and on banks that do not exist."""
    for bank in (0, 1, 3):
        assert status_of(connection.send, TMCLCommand.SIO, 0, bank, 1) == TMCLStatus.WRONG_TYPE


def test_an_output_is_on_or_off(module: TMCM1311, connection: TmclInterface) -> None:
    """Nothing between and nothing beyond."""
    for value in (2, -1, 255):
        assert status_of(connection.send, TMCLCommand.SIO, 0, 2, value) == TMCLStatus.INVALID_VALUE
    assert outputs(module) == [0] * 8
