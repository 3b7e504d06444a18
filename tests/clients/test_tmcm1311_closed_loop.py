"""The motor in closed loop, as PyTrinamic's closed-loop example drives it.

Encoder detection, closed loop, rotate, move by what was turned, move back: with the motors of all four presets, and a coarse
and a fine encoder.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from harness import Server, status_of, wait_for
from pytrinamic.modules import TMCM1311
from pytrinamic.tmcl import TMCLStatus

#: The four stepper presets of the bench.
MOTORS = ("QSH4218-35-10-027", "QSH4218-51-10-049", "QSH5718-51-28-101", "QSH5718-76-28-189")

#: Counts in a turn.
ENCODERS = (4000, 40_000)

#: The example's velocity and acceleration, in µsteps of 1/256 full step.
VELOCITY = 20_000
ACCELERATION = 40_000

#: µsteps in a turn.
TURN = 51_200


def bench(folder: Path, motor: str, counts: int, more: str = "") -> str:
    """A bench file with this motor and encoder."""
    file = folder / "bench.toml"
    file.write_text(
        f'[[module]]\nkind = "tmcm-1311"\n[module.motor]\npreset = "{motor}"\n[module.encoder]\ncounts = {counts}\n{more}'
    )
    return str(file)


def close_loop(module: TMCM1311, counts: int) -> None:
    """The example's first half: settings, detection, closed loop, ramp."""
    motor = module.motors[0]
    motor.drive_settings.max_current = 32
    motor.drive_settings.standby_current = 8
    motor.drive_settings.boost_current = 0
    motor.drive_settings.microstep_resolution = motor.ENUM.MicrostepResolution256Microsteps
    motor.set_axis_parameter(motor.AP.EncoderInitialization, 1)
    wait_for(lambda: motor.get_axis_parameter(motor.AP.EncoderInitialization) == 2, "encoder detection")
    assert motor.get_axis_parameter(motor.AP.EncoderResolution) == counts
    motor.set_axis_parameter(motor.AP.ClosedLoopMode, 1)
    wait_for(lambda: motor.get_axis_parameter(motor.AP.CLInitFlag) == 1, "closed loop")
    motor.linear_ramp.max_velocity = VELOCITY
    motor.linear_ramp.max_acceleration = ACCELERATION


def double_and_return(module: TMCM1311, counts: int, turn_s: float) -> None:
    """The example's second half: turns for a while, goes as far again, and back to 0."""
    motor = module.motors[0]
    motor.set_axis_parameter(motor.AP.RelativePositioningOption, 1)
    motor.actual_position = 0
    motor.rotate(VELOCITY)
    time.sleep(turn_s)
    motor.stop()
    wait_for(lambda: motor.actual_velocity == 0, "standstill")
    distance = motor.actual_position
    assert distance > counts // 20
    start = motor.actual_position
    motor.move_by(distance, VELOCITY)
    wait_for(motor.get_position_reached, "furthest point")
    # Where the ramp was is where the motor was, but for what little it lagged; the window is 50 counts.
    assert abs(motor.actual_position - start - distance) <= 50 + counts // 200
    assert abs(motor.actual_position - motor.target_position) <= 50
    motor.move_to(0, VELOCITY)
    assert not motor.get_position_reached()
    wait_for(motor.get_position_reached, "the way back")
    assert abs(motor.actual_position) <= 50


def test_the_vendors_example_in_real_time(serve: Callable[..., Server], tmp_path: Path) -> None:
    """Every motor with either encoder, all of them at once, each as fast as it would really be."""

    def play(server: Server, counts: int) -> None:
        with server.ports[0].connect() as connection:
            module = TMCM1311(connection)
            close_loop(module, counts)
            double_and_return(module, counts, turn_s=1.0)

    with ThreadPoolExecutor() as pool:
        plays = {}
        for name, counts in itertools.product(MOTORS, ENCODERS):
            folder = tmp_path / f"{name}-{counts}"
            folder.mkdir()
            server = serve("--bench", bench(folder, name, counts), "--tcp", "127.0.0.1:0")
            plays[name, counts] = pool.submit(play, server, counts)
        failures = {drive: error for drive, played in plays.items() if (error := played.exception())}
    assert not failures


def test_a_dead_encoder_is_told(serve: Callable[..., Server], tmp_path: Path) -> None:
    """Detection ends in 3, and the loop does not close."""
    dead = '[[event]]\nat = "0s"\nset = { "fault.encoder_line" = "a" }\n'
    file = bench(tmp_path, MOTORS[2], 4000, dead)
    server = serve("--bench", file, "--tcp", "127.0.0.1:0", "--speed", "20")
    with server.ports[0].connect() as connection:
        motor = TMCM1311(connection).motors[0]
        motor.set_axis_parameter(motor.AP.EncoderInitialization, 1)
        wait_for(lambda: motor.get_axis_parameter(motor.AP.EncoderInitialization) == 3, "the verdict")
        motor.set_axis_parameter(motor.AP.ClosedLoopMode, 1)
        assert motor.get_axis_parameter(motor.AP.ClosedLoopMode) == 1
        wait_for(lambda: motor.get_axis_parameter(motor.AP.ClosedLoopMode) == 0, "the end of the initialisation")
        assert motor.get_axis_parameter(motor.AP.CLInitFlag) == 0


def test_torque_mode(serve: Callable[..., Server]) -> None:
    """Refused before the loop is closed; then AP 14 turns the motor, and AP 19 follows its slope."""
    server = serve("--tcp", "127.0.0.1:0", "--speed", "20")
    with server.ports[0].connect() as connection:
        module = TMCM1311(connection)
        motor = module.motors[0]
        torque = motor.AP.CLTorqueModeTargetCurrent
        refused = status_of(motor.set_axis_parameter, torque, 100)
        assert refused == TMCLStatus.COMMAND_NOT_AVAILABLE
        close_loop(module, 40_000)
        motor.set_axis_parameter(torque, -300)
        wait_for(lambda: motor.get_axis_parameter(motor.AP.MeasuredSpeed, signed=True) < -TURN, "a turn a second to the left")
        motor.stop()
        wait_for(lambda: motor.get_axis_parameter(motor.AP.MeasuredSpeed) == 0, "standstill")
