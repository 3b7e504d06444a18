"""The vendor's four examples for the TMCM-1640, with their settings: in time-lapse, and once each in real time.

They position by encoder and by halls, and turn as inputs say. The examples wait for people at the inputs; here events of the bench
press the buttons and turn the potentiometer.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from harness import Server, wait_for
from pytrinamic.modules import TMCM1640

#: Factors of real time.
SPEEDS = ("20", "1")

#: What the examples turn by.
TURNS = 50


@pytest.fixture(params=SPEEDS, ids=lambda speed: f"speed-{speed}")
def speed(request: pytest.FixtureRequest) -> str:
    """How fast virtual time runs."""
    return request.param


def ports(transport: str, link: str) -> tuple[str, str]:
    """One port of this kind."""
    return ("--tcp", "127.0.0.1:0") if transport == "tcp" else ("--pty", link)


def configure(module: TMCM1640, max_velocity: int, max_acceleration: int) -> None:
    """What the examples have in common; their motor is a QBL4208-61-04-013-1024-AT."""
    motor = module.motors[0]
    motor.drive_settings.poles = 8
    motor.drive_settings.max_current = 2000
    motor.drive_settings.target_reached_velocity = 500
    motor.drive_settings.target_reached_distance = 5
    motor.linear_ramp.max_velocity = max_velocity
    motor.linear_ramp.max_acceleration = max_acceleration
    motor.linear_ramp.enabled = 1
    motor.pid.torque_p = 600
    motor.pid.torque_i = 600
    motor.pid.velocity_p = 800
    motor.pid.velocity_i = 500
    motor.pid.position_p = 300


def configure_encoder(module: TMCM1640, init_mode: int) -> None:
    """The examples with an encoder; the first motion waits for the initialisation by itself."""
    motor = module.motors[0]
    motor.drive_settings.open_loop_current = 1000
    motor.abn_encoder.resolution = 4096
    motor.abn_encoder.direction = 0
    motor.abn_encoder.init_mode = init_mode
    motor.drive_settings.commutation_mode = motor.ENUM.COMM_MODE_FOC_ENCODER


def configure_halls(module: TMCM1640) -> None:
    """The examples without one."""
    motor = module.motors[0]
    motor.drive_settings.commutation_mode = motor.ENUM.COMM_MODE_FOC_HALL
    motor.drive_settings.motor_halted_velocity = 5
    motor.digital_hall.polarity = 0
    motor.digital_hall.interpolation = 0


def there_and_back(module: TMCM1640, distance: int) -> None:
    """The second half of both positioning examples."""
    motor = module.motors[0]
    motor.actual_position = 0
    for target in (distance, 0):
        motor.move_to(target)
        assert not motor.get_position_reached(), "the flag is right before the reply"
        wait_for(motor.get_position_reached, f"position {target}")
        # The flag tells that it was within 5; in a moment it is close for good.
        wait_for(lambda target=target: abs(motor.actual_position - target) <= 5 and motor.actual_velocity == 0, "rest")


def test_positioning_by_encoder(serve: Callable[..., Server], link: str, transport: str, speed: str) -> None:
    """encoder_position_mode.py."""
    server = serve(*ports(transport, link), "--speed", speed, module="tmcm-1640")
    with server.ports[0].connect() as connection:
        module = TMCM1640(connection)
        configure(module, 1000, 2000)
        configure_encoder(module, module.motors[0].ENUM.ENCODER_INIT_MODE_0)
        there_and_back(module, 4096 * TURNS)


def test_positioning_by_halls(serve: Callable[..., Server], link: str, transport: str, speed: str) -> None:
    """hall_position_mode.py."""
    server = serve(*ports(transport, link), "--speed", speed, module="tmcm-1640")
    with server.ports[0].connect() as connection:
        module = TMCM1640(connection)
        configure(module, 1000, 2000)
        configure_halls(module)
        there_and_back(module, 8 * 3 * TURNS)


def buttons(folder: Path, speed: str, settings: list[tuple[float, str]]) -> str:
    """A bench file whose events come so many seconds of real time after the start."""
    file = folder / "bench.toml"
    events = (
        f'[[event]]\nat = "{round(at_s * float(speed) * 1000)}ms"\nset = {{ {setting} }}\n' for at_s, setting in settings
    )
    file.write_text('[[module]]\nkind = "tmcm-1640"\n' + "".join(events))
    return str(file)


def test_inputs_turn_the_motor(
    serve: Callable[..., Server], tmp_path: Path, link: str, transport: str, speed: str
) -> None:
    """hall_digital_input.py: input 0 swaps the direction, input 1 stops the motor."""
    bench = buttons(tmp_path, speed, [(3.0, '"input.0" = 1'), (6.0, '"input.1" = 1')])
    server = serve("--bench", bench, *ports(transport, link), "--speed", speed, module="tmcm-1640")
    with server.ports[0].connect() as connection:
        module = TMCM1640(connection)
        motor = module.motors[0]
        configure(module, 1500, 2000)
        configure_halls(module)
        motor.actual_position = 0
        motor.rotate(500)
        wait_for(lambda: abs(motor.actual_velocity - 500) <= 25, "500 rpm")
        wait_for(lambda: module.get_digital_input(0), "input 0")
        assert motor.actual_position > 0
        motor.rotate(-500)
        wait_for(lambda: abs(motor.actual_velocity + 500) <= 25, "-500 rpm")
        wait_for(lambda: module.get_digital_input(1), "input 1")
        motor.rotate(0)
        wait_for(lambda: motor.actual_velocity == 0, "standstill")


def test_a_potentiometer_sets_the_velocity(
    serve: Callable[..., Server], tmp_path: Path, link: str, transport: str, speed: str
) -> None:
    """encoder_analog_input.py: twice the reading less 1024."""
    bench = buttons(tmp_path, speed, [(0.0, '"ain.0" = 1524'), (5.0, '"ain.0" = 774')])
    server = serve("--bench", bench, *ports(transport, link), "--speed", speed, module="tmcm-1640")
    with server.ports[0].connect() as connection:
        module = TMCM1640(connection)
        motor = module.motors[0]
        configure(module, 2048, 10_000)
        configure_encoder(module, motor.ENUM.ENCODER_INIT_MODE_1)
        for velocity in (1000, -500):
            wait_for(lambda wanted=velocity: (module.get_analog_input(0) - 1024) * 2 == wanted, "the potentiometer")
            motor.rotate(velocity)
            wait_for(lambda wanted=velocity: abs(motor.actual_velocity - wanted) <= 25, f"{velocity} rpm")
