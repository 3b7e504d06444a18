"""The motor in open loop, as PyTrinamic moves it."""

from __future__ import annotations

from typing import TypeAlias

import pytest
from harness import PATIENCE_S, status_of, wait_for
from pytrinamic.connections.tmcl_interface import TmclInterface
from pytrinamic.modules import TMCM1311
from pytrinamic.tmcl import TMCLCommand, TMCLReply, TMCLStatus

Motor: TypeAlias = TMCM1311._MotorTypeA

#: µsteps in a turn: 200 full steps of 256.
TURN = 51_200

#: So far away that no test sees the motor arrive: 200 s of virtual time.
FAR = 200 * TURN

#: A limit for moves that shall be over soon, in pps and pps/s.
FAST = 500_000


def arrive(motor: Motor) -> None:
    """The loop at the end of every move in the vendor's examples."""
    wait_for(motor.get_position_reached, "position reached")
    assert motor.actual_velocity == 0


def stand_still(motor: Motor) -> int:
    """Waits until the motor stands, and returns where."""
    wait_for(lambda: motor.actual_velocity == 0, "standstill")
    position = motor.actual_position
    assert motor.actual_position == position
    return position


@pytest.fixture
def fast(motor: Motor) -> Motor:
    """The motor with a ramp that makes moves short."""
    motor.linear_ramp.max_velocity = FAST
    motor.linear_ramp.max_acceleration = FAST
    return motor


class TestRotate:
    """ROR, ROL, MST and AP 2."""

    @pytest.mark.parametrize("velocity", [TURN, -TURN])
    def test_rotate_and_stop(self, module: TMCM1311, motor: Motor, velocity: int) -> None:
        """Up to speed, round and round, and down again; the sign is the direction."""
        module.rotate(0, velocity)
        assert motor.target_velocity == velocity
        wait_for(lambda: motor.actual_velocity == velocity, "full speed")
        first = motor.actual_position
        assert first * velocity > 0
        wait_for(lambda: (motor.actual_position - first) * velocity > 0, "it goes on")
        module.stop(0)
        assert motor.target_velocity == 0
        stand_still(motor)

    def test_through_the_motor_object(self, motor: Motor) -> None:
        """As the examples do; and AP 2 is another way to say it (decisions §2a.1)."""
        motor.rotate(TURN)
        wait_for(lambda: motor.actual_velocity == TURN, "full speed")
        motor.target_velocity = -TURN
        wait_for(lambda: motor.actual_velocity == -TURN, "full speed the other way")
        motor.stop()
        stand_still(motor)

    def test_left_is_negative(self, connection: TmclInterface, motor: Motor) -> None:
        """ROL v is ROR -v (decisions §3, "ROL")."""
        reply = connection.send(TMCLCommand.ROL, 0, 0, TURN)
        assert reply.value == TURN
        assert motor.target_velocity == -TURN
        wait_for(lambda: motor.actual_position < 0, "it turns to the left")

    def test_faster_than_allowed(self, motor: Motor) -> None:
        """Accepted, and limited to AP 4 in effect (decisions §2a.5)."""
        motor.linear_ramp.max_velocity = 10_000
        motor.rotate(TURN)
        assert motor.target_velocity == TURN
        wait_for(lambda: motor.actual_velocity == 10_000, "the limit")
        seen = {motor.actual_velocity for _ in range(50)}
        assert seen == {10_000}

    def test_the_ramp_mode_follows(self, motor: Motor) -> None:
        """AP 128: 0 position, 1 velocity."""
        motor.rotate(TURN)
        assert motor.get_axis_parameter(Motor.AP.RampMode) == 1
        motor.move_to(FAR)
        assert motor.get_axis_parameter(Motor.AP.RampMode) == 0
        motor.stop()
        assert motor.get_axis_parameter(Motor.AP.RampMode) == 1


class TestMove:
    """MVP and AP 0."""

    def test_move_to(self, module: TMCM1311, motor: Motor) -> None:
        """One turn and back, exactly, with the ramp the module comes with."""
        for target in (TURN, 0, -TURN // 2):
            module.move_to(0, target)
            assert motor.target_position == target
            arrive(motor)
            assert motor.actual_position == target

    def test_position_reached_is_cleared_before_the_reply(self, motor: Motor) -> None:
        """Clients poll at once; a flag left over from the last move would end the loop before it began (decisions §2a.1)."""
        for command in (motor.move_to, motor.move_by):
            assert motor.get_position_reached() == 1
            command(FAR)
            assert motor.get_position_reached() == 0
            assert motor.get_axis_parameter(Motor.AP.StatusWord) & 1 == 0
            motor.stop()
            motor.move_to(stand_still(motor))
            arrive(motor)

    def test_a_move_to_where_it_stands(self, motor: Motor) -> None:
        """Is over at once."""
        motor.move_to(0)
        assert motor.get_position_reached() == 1

    def test_on_its_way(self, motor: Motor) -> None:
        """Nearer at each look, never too fast, never too far."""
        motor.move_to(2 * TURN)
        positions, velocities = [], []
        while not motor.get_position_reached():
            positions.append(motor.actual_position)
            velocities.append(motor.actual_velocity)
        assert len(positions) > 5
        assert positions == sorted(positions)
        assert positions[-1] <= 2 * TURN == motor.actual_position
        assert 0 < max(velocities) <= TURN
        assert min(velocities) >= 0

    def test_a_velocity_along_with_the_move(self, module: TMCM1311, motor: Motor) -> None:
        """The client sets AP 4 first."""
        module.move_to(0, 1000, 30_000)
        assert motor.linear_ramp.max_velocity == 30_000
        module.move_by(0, 1000, 40_000)
        assert motor.linear_ramp.max_velocity == 40_000

    def test_move_by(self, fast: Motor) -> None:
        """Relative to where the motor is: what AP 127 is set to in the examples, and by the factory (decisions §2a.3)."""
        assert fast.get_axis_parameter(Motor.AP.RelativePositioningOption) == 1
        fast.actual_position = 1000
        for delta, target in ((-3000, -2000), (500, -1500), (TURN, TURN - 1500)):
            fast.move_by(delta)
            assert fast.target_position == target
            arrive(fast)
            assert fast.actual_position == target

    def test_move_by_from_the_target(self, motor: Motor) -> None:
        """AP 127 = 0: relative to where the motor is going to."""
        motor.set_axis_parameter(Motor.AP.RelativePositioningOption, 0)
        motor.move_to(FAR)
        motor.move_by(-1000)
        assert motor.target_position == FAR - 1000

    def test_the_target_is_a_property_too(self, fast: Motor) -> None:
        """Setting AP 0 starts the move (decisions §2a.1)."""
        fast.target_position = -TURN
        arrive(fast)
        assert fast.actual_position == -TURN

    def test_a_new_target_in_mid_flight(self, fast: Motor) -> None:
        """Away, and then back across the start: it turns round and still ends where it should."""
        fast.move_to(FAR)
        wait_for(lambda: fast.actual_position > 0, "it is on its way")
        fast.move_to(-TURN)
        arrive(fast)
        assert fast.actual_position == -TURN

    def test_from_turning_to_a_place(self, fast: Motor) -> None:
        """From velocity mode to position mode without stopping first."""
        fast.rotate(FAST)
        wait_for(lambda: fast.actual_velocity > 0, "it turns")
        fast.move_to(0)
        arrive(fast)
        assert fast.actual_position == 0

    def test_redefining_the_position_moves_nothing(self, motor: Motor) -> None:
        """SAP 1 shifts the target along (decisions §2a.1); the examples begin with it."""
        motor.actual_position = 12_345
        assert motor.actual_position == motor.target_position == 12_345
        assert motor.get_position_reached() == 1
        assert motor.actual_velocity == 0

    def test_the_encoder_sees_the_shaft_turn(self, fast: Motor) -> None:
        """40 000 counts a turn, upwards (decisions §5.15). Within half a degree: a rotor lags behind its field."""
        fast.move_to(TURN)
        arrive(fast)
        there = fast.get_axis_parameter(Motor.AP.EncoderPosition, signed=True)
        fast.move_to(-TURN)
        arrive(fast)
        back = fast.get_axis_parameter(Motor.AP.EncoderPosition, signed=True)
        assert there - back == pytest.approx(80_000, abs=55)

    def test_coarser_microsteps_turn_further(self, fast: Motor) -> None:
        """With 16 µsteps in a full step a turn is 3200 of them."""
        fast.drive_settings.microstep_resolution = fast.ENUM.MicrostepResolution16Microsteps
        before = fast.get_axis_parameter(Motor.AP.EncoderPosition, signed=True)
        fast.linear_ramp.max_velocity = fast.linear_ramp.max_acceleration = FAST // 16
        fast.move_by(3200)
        arrive(fast)
        assert fast.get_axis_parameter(Motor.AP.EncoderPosition, signed=True) - before == pytest.approx(40_000, abs=55)


class TestCoordinates:
    """SCO, GCO, CCO and MVP COORD, for which the client has no methods of its own."""

    def test_set_and_move_there(self, connection: TmclInterface, fast: Motor) -> None:
        """Coordinates 0 to 20."""
        for number in range(21):
            assert connection.send(TMCLCommand.GCO, number, 0, 0).value == 0
        connection.send(TMCLCommand.SCO, 20, 0, -TURN)
        assert connection.send(TMCLCommand.GCO, 20, 0, 0).value == 2**32 - TURN
        connection.move(2, 0, 20)
        assert fast.target_position == -TURN
        arrive(fast)
        assert fast.actual_position == -TURN
        connection.send(TMCLCommand.CCO, 3, 0, 0)
        assert connection.send(TMCLCommand.GCO, 3, 0, 0).value == 2**32 - TURN

    @pytest.mark.parametrize("command", [TMCLCommand.SCO, TMCLCommand.GCO, TMCLCommand.CCO])
    def test_there_is_no_coordinate_21(self, connection: TmclInterface, command: int) -> None:
        """Decisions §2."""
        assert status_of(connection.send, command, 21, 0, 0) == TMCLStatus.INVALID_VALUE
        assert status_of(connection.move, 2, 0, 21) == TMCLStatus.INVALID_VALUE


class TestPositionReachedEvent:
    """Command 138 (decisions §1.9). The client can send it, but not wait for the second reply, so that is read by hand."""

    @staticmethod
    def second_reply(connection: TmclInterface) -> TMCLReply:
        """What comes without having been asked for again."""
        return TMCLReply.from_buffer(connection._recv(2, 1))

    def test_when_the_motor_arrives(self, connection: TmclInterface, motor: Motor) -> None:
        """One reply at once, one more when it is there, and only one."""
        connection.set_timeout(PATIENCE_S)
        motor.move_to(TURN)
        first = connection.send(TMCLCommand.TARGET_POSITION_REACHED, 0, 0, 0)
        assert (first.status, first.value) == (100, 1)
        second = self.second_reply(connection)
        assert (second.status, second.command, second.value) == (128, 138, 1)
        assert second.is_checksum_correct()
        assert motor.get_position_reached() == 1
        assert motor.actual_position == TURN
        motor.move_to(TURN + 10)
        arrive(motor)

    def test_when_it_has_arrived_already(self, connection: TmclInterface) -> None:
        """It follows at once."""
        assert connection.send(TMCLCommand.TARGET_POSITION_REACHED, 0, 0, 0).status == 100
        assert self.second_reply(connection).status == 128
