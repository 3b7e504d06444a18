"""Every feature of PyTrinamic's TMCM1640 class: what is set is read back, by the feature and by the axis parameter behind it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest
from harness import Server, status_of, wait_for
from pytrinamic.connections.tmcl_interface import TmclInterface
from pytrinamic.modules import TMCM1640
from pytrinamic.tmcl import TMCLCommand, TMCLStatus

AP = TMCM1640._MotorTypeA.AP

#: Command 136, type 1: module number, major and minor version (decisions §1.5).
VERSION_NUMBER = 0x0668_0200

#: Feature, property, axis parameter, the factory's value (decisions §6.6), and another one.
SETTINGS = [
    ("drive_settings", "poles", AP.MotorPoles, 8, 14),
    ("drive_settings", "max_current", AP.MaxCurrent, 2000, 3500),
    ("drive_settings", "commutation_mode", AP.CommutationMode, 6, 7),
    ("drive_settings", "open_loop_current", AP.OpenLoopCurrent, 1000, 1500),
    ("drive_settings", "target_reached_velocity", AP.TargetReachedVelocity, 500, 50),
    ("drive_settings", "target_reached_distance", AP.TargetReachedDistance, 5, 20),
    ("drive_settings", "motor_halted_velocity", AP.MotorHaltedVelocity, 5, 25),
    ("digital_hall", "polarity", AP.HallSensorPolarity, 0, 1),
    ("digital_hall", "interpolation", AP.HallSensorInterpolation, 0, 1),
    ("abn_encoder", "resolution", AP.EncoderSteps, 4096, 16_384),
    ("abn_encoder", "direction", AP.EncoderDirection, 0, 1),
    ("abn_encoder", "init_mode", AP.EncoderInitMode, 0, 2),
    ("linear_ramp", "max_velocity", AP.MaxVelocity, 4000, 1234),
    ("linear_ramp", "max_acceleration", AP.MaxAcceleration, 2000, 10_000),
    ("linear_ramp", "enabled", AP.EnableRamp, 1, 0),
    ("pid", "torque_p", AP.TorqueP, 600, 700),
    ("pid", "torque_i", AP.TorqueI, 9000, 4000),
    ("pid", "velocity_p", AP.VelocityP, 800, 900),
    ("pid", "velocity_i", AP.VelocityI, 500, 3000),
    ("pid", "position_p", AP.PositionP, 300, 350),
]


@pytest.fixture
def server(serve: Callable[..., Server], link: str) -> Server:
    """A module fresh from the factory, on one TCP port and one pseudo terminal."""
    return serve("--tcp", "127.0.0.1:0", "--pty", link, "--speed", "20", module="tmcm-1640")


@pytest.fixture
def module(connection: TmclInterface) -> TMCM1640:
    """The client's idea of the module."""
    return TMCM1640(connection)


def test_it_says_what_it_is(connection: TmclInterface) -> None:
    """Command 136."""
    assert connection.send(TMCLCommand.GET_FIRMWARE_VERSION, 1, 0, 0).value == VERSION_NUMBER


@pytest.mark.parametrize(("feature", "name", "number", "factory", "other"), SETTINGS, ids=lambda value: str(value))
def test_settings(module: TMCM1640, feature: str, name: str, number: int, factory: int, other: int) -> None:
    """The factory's value, another one by the feature, and back by the parameter."""
    motor = module.motors[0]
    settings: Any = getattr(motor, feature)
    assert getattr(settings, name) == factory
    setattr(settings, name, other)
    assert getattr(settings, name) == other
    assert motor.get_axis_parameter(number) == other
    motor.set_axis_parameter(number, factory)
    assert getattr(settings, name) == factory


def test_features_print(module: TMCM1640) -> None:
    """The examples print them all."""
    motor = module.motors[0]
    for feature in (motor.drive_settings, motor.digital_hall, motor.abn_encoder, motor.linear_ramp, motor.pid):
        assert str(feature)


def readable() -> Iterator[tuple[str, int]]:
    """The parameters of the class; the debug values 190 to 199 are in no manual."""
    for name, number in vars(AP).items():
        if not name.startswith(("_", "DebugValue")):
            yield name, number


@pytest.mark.parametrize(("name", "number"), list(readable()))
def test_parameters_of_the_class_exist(module: TMCM1640, name: str, number: int) -> None:
    """All of them are answered; what is not refuses with an error. Those that are for writing only take their value."""
    motor = module.motors[0]
    if name in ("ClearIItExceededFlag", "ReinitBldcRegulation"):
        assert status_of(motor.get_axis_parameter, number) == TMCLStatus.WRONG_TYPE
        motor.set_axis_parameter(number, 0)
    else:
        motor.get_axis_parameter(number)


def test_debug_values_are_unknown(module: TMCM1640) -> None:
    """No manual has them."""
    assert status_of(module.motors[0].get_axis_parameter, AP.DebugValue0) == TMCLStatus.WRONG_TYPE


def test_inputs_and_the_output(module: TMCM1640, connection: TmclInterface) -> None:
    """Idle inputs read 0 (decisions §6.9); the output follows."""
    assert [module.get_digital_input(number) for number in (0, 1)] == [0, 0]
    assert 0 <= module.get_analog_input(0) <= 4095
    for level in (1, 0):
        connection.send(TMCLCommand.SIO, module.DO.OUT_0, 2, level)
        assert module.get_digital_output(module.DO.OUT_0) == level


def test_the_n_channel_clears_the_position_once(module: TMCM1640) -> None:
    """AP 161 and 163: from 10 000 on, the position begins anew at the N channel, and then never again."""
    motor = module.motors[0]
    motor.drive_settings.commutation_mode = motor.ENUM.COMM_MODE_FOC_ENCODER
    motor.actual_position = 10_000
    motor.abn_encoder.clear_once_on_n_channel()
    assert (motor.get_axis_parameter(AP.ClearOnNull), motor.get_axis_parameter(AP.ClearOnce)) == (1, 1)
    motor.rotate(100)
    wait_for(lambda: motor.get_axis_parameter(AP.ClearOnNull) == 0, "the N channel")
    wait_for(lambda: motor.actual_position > 3 * 4096, "three more turns")


def test_torque(module: TMCM1640) -> None:
    """AP 155 turns the motor; AP 150 and the PID errors follow."""
    motor = module.motors[0]
    motor.pid.torque_i = 4000
    motor.set_axis_parameter(AP.TargetTorque, -300)
    wait_for(lambda: motor.actual_velocity < -500, "500 rpm to the left")
    assert motor.get_axis_parameter(AP.TargetTorque, True) == -300
    motor.stop()
    wait_for(lambda: motor.actual_velocity == 0, "standstill")


def test_the_driver_can_be_switched_off(module: TMCM1640) -> None:
    """AP 255: no current, no motion."""
    motor = module.motors[0]
    motor.rotate(1000)
    wait_for(lambda: motor.actual_velocity > 950, "1000 rpm")
    motor.set_axis_parameter(AP.EnableDriver, 0)
    wait_for(lambda: motor.actual_velocity == 0, "standstill")
    assert motor.get_axis_parameter(AP.ActualTorque, True) == 0


def test_the_server_says_how_to_connect(serve: Callable[..., Server]) -> None:
    """The hint names the class of this module, and a motion that the module can do as it comes."""
    server = serve("--tcp", "127.0.0.1:0", module="tmcm-1640")
    with server.ports[0].connect() as connection:
        TMCM1640(connection).motors[0].rotate(0)
    assert "from pytrinamic.modules import TMCM1640" in server.stderr()
    assert "motor = TMCM1640(connection).motors[0]\n    motor.rotate(1000)" in server.stderr()
