"""Everything that PyTrinamic's TMCM1311 class can set and read."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import pytest
from harness import assert_in_step, status_of, wait_for
from pytrinamic.connections.tmcl_interface import TmclInterface
from pytrinamic.modules import TMCM1311
from pytrinamic.tmcl import TMCLCommand, TMCLStatus

Motor: TypeAlias = TMCM1311._MotorTypeA

AXIS_PARAMETERS = {name: number for name, number in vars(Motor.AP).items() if isinstance(number, int)}
GLOBAL_PARAMETERS = {name: number for name, number in vars(TMCM1311.GP0).items() if isinstance(number, int)}
INTERRUPT_PARAMETERS = {name: number for name, number in vars(TMCM1311.GP3).items() if isinstance(number, int)}


@dataclass(frozen=True)
class Property:
    """A property of one of the client's feature classes, the axis parameter behind it, and that one's range."""

    feature: str
    name: str
    number: int
    lowest: int
    highest: int
    factory: int

    def __str__(self) -> str:
        return f"{self.feature}.{self.name}"


#: Those that the client can send.
PROPERTIES = [
    Property("drive_settings", "max_current", 6, 0, 255, 128),
    Property("drive_settings", "standby_current", 7, 0, 255, 8),
    Property("drive_settings", "boost_current", 200, 0, 255, 0),
    Property("drive_settings", "microstep_resolution", 140, 0, 8, 8),
    Property("linear_ramp", "max_velocity", 4, 0, 327_679_999, 51_200),
    Property("linear_ramp", "max_acceleration", 5, 1, 24_999_998, 51_200),
    Property("stallguard2", "stop_velocity", 181, 0, 327_679_999, 0),
    Property("coolstep", "hysteresis", 170, 0, 15, 0),
    Property("coolstep", "hysteresis_start", 172, 0, 15, 0),
    Property("coolstep", "threshold_speed", 182, 0, 327_679_999, 0),
    Property("coolstep", "slow_run_current", 183, 0, 255, 0),
]

#: Those where the client looks for a name that its own list of axis parameters lacks.
UNSENDABLE = [
    Property("coolstep", "current_minimum", 168, 0, 1, 0),
    Property("coolstep", "current_down_step", 169, 0, 3, 0),
    Property("coolstep", "current_up_step", 171, 1, 3, 1),
    Property("stallguard2", "filter", 173, 0, 1, 0),
    Property("stallguard2", "threshold", 174, -64, 63, 0),
]

#: Properties that the client offers for other modules; for this one it sends nothing.
ABSENT = [
    ("drive_settings", "commutation_mode"),
    ("drive_settings", "motor_type"),
    ("drive_settings", "pole_pairs"),
    ("drive_settings", "poles"),
    ("drive_settings", "open_loop_current"),
    ("drive_settings", "position_sensor"),
    ("drive_settings", "velocity_sensor"),
    ("drive_settings", "motor_halted_velocity"),
    ("drive_settings", "target_reached_distance"),
    ("drive_settings", "target_reached_velocity"),
    ("drive_settings", "reference_switch_tolerance"),
    ("linear_ramp", "enabled"),
]

#: Defaults that the manual does not give and the project chose (decisions §5.15).
CHOSEN_DEFAULTS = {
    4: 51_200, 5: 51_200, 6: 128, 7: 8, 17: 1000, 20: 1000, 25: 13_200, 26: 118_800, 108: 300_000, 109: 600_000,
    124: 10_000, 126: 0, 127: 1, 162: 2, 165: 3, 166: 4, 167: 5, 171: 1, 175: 3, 176: 3, 193: 1, 210: 40_000,
}  # fmt: skip

#: Axis parameters, values that are allowed, and values that are not: signs, gaps and odd ends of ranges.
RANGES = [
    (12, [0, 1], [2, -1]),
    (25, [0, 2**31 - 1, -1], []),  # unsigned 32 bits travel as two's complement
    (127, [0, 1, 2], [3, -1]),
    (130, [0, 327_679_999], [-1, 327_680_000]),
    (165, [-3, 12], [-4, 13]),
    (167, [0, 2, 15], [1, 16, -1]),
    (193, [1, 8, 129, 136], [0, 9, 128, 137]),
    (194, [-327_678_000, 327_679_999], [-327_678_001, 327_680_000]),
    (201, [0, 4, 8, 16, 28], [1, 5, 29, 32, -4]),
    (212, [-(2**31), 2**31 - 1], []),
    (214, [1, 65_535], [0, 65_536]),
]


class TestProperties:
    """The properties of drive_settings, linear_ramp, stallguard2 and coolstep."""

    @pytest.mark.parametrize("prop", PROPERTIES, ids=str)
    def test_what_the_client_can_send(self, motor: Motor, prop: Property) -> None:
        """Reads the factory setting, takes both ends of the range and refuses what is beyond."""
        feature = getattr(motor, prop.feature)
        assert getattr(feature, prop.name) == prop.factory
        for value in (prop.lowest, prop.highest):
            setattr(feature, prop.name, value)
            assert getattr(feature, prop.name) == value
            assert motor.get_axis_parameter(prop.number) == value
        for value in (prop.lowest - 1, prop.highest + 1):
            assert status_of(setattr, feature, prop.name, value) == TMCLStatus.INVALID_VALUE
        assert getattr(feature, prop.name) == prop.highest

    @pytest.mark.parametrize("prop", UNSENDABLE, ids=str)
    def test_what_the_client_cannot_send(self, motor: Motor, connection: TmclInterface, prop: Property) -> None:
        """The client itself raises, before anything is sent; the axis parameter is there all the same."""
        feature = getattr(motor, prop.feature)
        with pytest.raises(AttributeError, match="'AP' has no attribute"):
            getattr(feature, prop.name)
        with pytest.raises(AttributeError, match="'AP' has no attribute"):
            setattr(feature, prop.name, prop.lowest)
        assert_in_step(connection)

        signed = prop.lowest < 0
        assert motor.get_axis_parameter(prop.number, signed) == prop.factory
        for value in (prop.lowest, prop.highest):
            motor.set_axis_parameter(prop.number, value)
            assert motor.get_axis_parameter(prop.number, signed) == value
        for value in (prop.lowest - 1, prop.highest + 1):
            assert status_of(motor.set_axis_parameter, prop.number, value) == TMCLStatus.INVALID_VALUE
        assert motor.get_axis_parameter(prop.number, signed) == prop.highest

    @pytest.mark.parametrize(("feature", "name"), ABSENT)
    def test_what_the_client_knows_to_be_absent(self, motor: Motor, feature: str, name: str) -> None:
        """It reads None without asking the module."""
        assert getattr(getattr(motor, feature), name) is None

    def test_load_value(self, motor: Motor) -> None:
        """AP 206, read only; ten bits."""
        assert 0 <= motor.stallguard2.load_value <= 1023
        assert status_of(motor.set_axis_parameter, Motor.AP.LoadValue, 0) == TMCLStatus.WRONG_TYPE

    def test_how_they_print(self, motor: Motor) -> None:
        """The examples print their settings; of stallguard2 and coolstep the client cannot."""
        assert str(motor.drive_settings).endswith(
            "{'max_current': 128, 'standby_current': 8, 'boost_current': 0, 'microstep_resolution': 8}"
        )
        assert str(motor.linear_ramp) == "LinearRamp {'max_velocity': 51200, 'max_acceleration': 51200, 'enable': None}"
        assert str(motor) == (
            "MotorControl {'motor': 0, 'target_position': 0, 'actual_position': 0, 'target_velocity': 0, 'actual_velocity': 0}"
        )
        for feature in (motor.stallguard2, motor.coolstep):
            with pytest.raises(AttributeError):
                str(feature)

    def test_flags_the_client_has_no_number_for(self, motor: Motor, connection: TmclInterface) -> None:
        """The client raises; the status word (AP 18) and the driver flags (AP 208) are there all the same."""
        for read in (motor.get_status_flags, motor.get_error_flags):
            with pytest.raises(AttributeError):
                read()
        assert_in_step(connection)
        assert motor.get_axis_parameter(Motor.AP.StatusWord) & 1 == 1  # position reached
        assert 0 <= motor.get_axis_parameter(Motor.AP.DriverErrorFlags) <= 255


class TestAxisParameters:
    """Axis parameters by number."""

    def test_every_one_the_client_names_can_be_read(self, motor: Motor) -> None:
        """But for AP 29, which is write only (decisions §2a.7)."""
        write_only = {"ClearIITExceededFlag"}
        for name, number in AXIS_PARAMETERS.items():
            if name in write_only:
                assert status_of(motor.get_axis_parameter, number) == TMCLStatus.WRONG_TYPE
            else:
                assert isinstance(motor.get_axis_parameter(number), int), name

    def test_chosen_defaults(self, motor: Motor) -> None:
        """A fresh module has them."""
        assert {number: motor.get_axis_parameter(number) for number in CHOSEN_DEFAULTS} == CHOSEN_DEFAULTS

    @pytest.mark.parametrize(("number", "allowed", "refused"), RANGES)
    def test_ranges(self, motor: Motor, number: int, allowed: list[int], refused: list[int]) -> None:
        """What is allowed reads back; what is not leaves the last value."""
        for value in allowed:
            motor.set_axis_parameter(number, value)
            assert motor.get_axis_parameter(number, signed=True) == value
        for value in refused:
            assert status_of(motor.set_axis_parameter, number, value) == TMCLStatus.INVALID_VALUE
        assert motor.get_axis_parameter(number, signed=True) == allowed[-1]

    def test_negative_values(self, motor: Motor) -> None:
        """The same 32 bits with and without a sign."""
        motor.set_axis_parameter(Motor.AP.StallGuard2Threshold, -64)
        assert motor.get_axis_parameter(Motor.AP.StallGuard2Threshold, signed=True) == -64
        assert motor.get_axis_parameter(Motor.AP.StallGuard2Threshold) == 2**32 - 64
        motor.actual_position = -123_456
        assert motor.actual_position == -123_456
        assert motor.get_axis_parameter(Motor.AP.ActualPosition) == 2**32 - 123_456

    def test_the_reply_carries_the_value_that_was_sent(self, connection: TmclInterface) -> None:
        """Decisions §1.4."""
        assert connection.set_axis_parameter(Motor.AP.MaxCurrent, 0, 99) == 99
        assert connection.set_axis_parameter(Motor.AP.ActualPosition, 0, -1) == 2**32 - 1

    def test_switches_at_rest(self, motor: Motor) -> None:
        """Nothing wired blocks nothing (decisions §5.10)."""
        for number in (Motor.AP.HomeSwitch, Motor.AP.RightEndstop, Motor.AP.LeftEndstop):
            assert motor.get_axis_parameter(number) == 0

    def test_reading_what_is_measured(self, motor: Motor) -> None:
        """Supply (0.1 V), board temperature and coil currents are there without physics too, and plausible."""
        assert 400 <= motor.get_axis_parameter(Motor.AP.SupplyVoltage) <= 500
        assert 0 <= motor.get_axis_parameter(Motor.AP.ModuleTemperature) <= 100
        for number in (Motor.AP.CurrentPhaseA, Motor.AP.CurrentPhaseB):
            assert -5000 <= motor.get_axis_parameter(number, signed=True) <= 5000

    def test_microstep_resolutions_by_name(self, motor: Motor) -> None:
        """As the examples set them."""
        names = [name for name in vars(Motor.ENUM) if name.startswith("MicrostepResolution")]
        assert len(names) == 9
        for name in names:
            motor.drive_settings.microstep_resolution = getattr(motor.ENUM, name)
            assert motor.drive_settings.microstep_resolution == getattr(motor.ENUM, name)


def restart(connection: TmclInterface) -> None:
    """Software reset (command 255); its reply may be lost (decisions §1.6)."""
    try:
        connection.send(255, 0, 0, 1234)
    except (RuntimeError, TimeoutError):
        pass


#: Axis parameters that can be stored, with values that are not their defaults.
STORED = {4: 20_000, 5: 40_000, 6: 50, 7: 0, 12: 1, 130: 100, 140: 4, 194: -5000, 200: 30, 204: 77, 214: 33}


class TestStorage:
    """STAP, RSAP, STGP, RSGP, the EEPROM lock, resets."""

    def test_store_and_restore_axis_parameters(self, module: TMCM1311, motor: Motor) -> None:
        """RSAP brings back what STAP stored; without anything stored, the factory setting."""
        motor.drive_settings.max_current = 100
        module.store_axis_parameter(Motor.AP.MaxCurrent, 0)
        motor.drive_settings.max_current = 50
        module.restore_axis_parameter(Motor.AP.MaxCurrent, 0)
        assert motor.drive_settings.max_current == 100

        motor.drive_settings.standby_current = 77
        module.restore_axis_parameter(Motor.AP.StandbyCurrent, 0)
        assert motor.drive_settings.standby_current == 8

    def test_what_is_stored_survives_a_reset_and_nothing_else_does(self, connection: TmclInterface) -> None:
        """Command 255 starts the module anew."""
        for number, value in STORED.items():
            connection.set_and_store_axis_parameter(number, 0, value)
        connection.set_axis_parameter(Motor.AP.MaxCurrent, 0, 51)
        connection.set_axis_parameter(Motor.AP.ChopperBlankTime, 0, 3)
        connection.set_axis_parameter(Motor.AP.ActualPosition, 0, 1000)
        restart(connection)
        read = {number: connection.get_axis_parameter(number, 0, signed=True) for number in STORED}
        assert read == STORED
        assert connection.get_axis_parameter(Motor.AP.ChopperBlankTime, 0) == 2
        assert connection.get_axis_parameter(Motor.AP.ActualPosition, 0) == 0

    @pytest.mark.parametrize("number", [0, 1, 2, 3, 8, 128, 168, 174, 206, 209])
    def test_what_cannot_be_stored(self, module: TMCM1311, number: int) -> None:
        """Parameters without E."""
        assert status_of(module.store_axis_parameter, number, 0) == TMCLStatus.WRONG_TYPE
        assert status_of(module.restore_axis_parameter, number, 0) == TMCLStatus.WRONG_TYPE

    def test_user_variables(self, module: TMCM1311, connection: TmclInterface) -> None:
        """STGP and RSGP on bank 2; 0 to 55 can be stored, the others cannot."""
        module.set_global_parameter(55, 2, -7)
        module.store_global_parameter(55, 2)
        module.set_global_parameter(55, 2, 8)
        module.restore_global_parameter(55, 2)
        assert module.get_global_parameter(55, 2, signed=True) == -7
        connection.set_and_store_global_parameter(0, 2, 2**31 - 1)
        restart(connection)
        assert module.get_global_parameter(0, 2) == 2**31 - 1
        assert status_of(module.store_global_parameter, 56, 2) == TMCLStatus.WRONG_TYPE
        assert status_of(module.restore_global_parameter, 56, 2) == TMCLStatus.WRONG_TYPE

    def test_settings_are_stored_at_once(self, module: TMCM1311, connection: TmclInterface) -> None:
        """Bank 0 needs no STGP (decisions §2a.9)."""
        module.set_global_parameter(TMCM1311.GP0.CANReplyID, 0, 1234)
        module.store_global_parameter(TMCM1311.GP0.CANReplyID, 0)
        module.restore_global_parameter(TMCM1311.GP0.CANReplyID, 0)
        restart(connection)
        assert module.get_global_parameter(TMCM1311.GP0.CANReplyID, 0) == 1234

    def test_the_lock(self, module: TMCM1311) -> None:
        """GP 73: 1234 locks, 4321 unlocks, nothing else is taken (decisions §2a.10)."""
        assert module.get_global_parameter(73, 0) == 0
        module.set_global_parameter(73, 0, 1234)
        assert module.get_global_parameter(73, 0) == 1
        locked = TMCLStatus.EEPROM_LOCKED
        assert status_of(module.store_axis_parameter, 6, 0) == locked
        assert status_of(module.set_global_parameter, TMCM1311.GP0.CANReplyID, 0, 3) == locked
        assert status_of(module.store_global_parameter, 0, 2) == locked
        module.set_axis_parameter(6, 0, 99)  # in RAM, so it has nothing to do with the lock
        module.set_global_parameter(0, 2, 99)
        assert status_of(module.set_global_parameter, 73, 0, 1) == TMCLStatus.INVALID_VALUE
        module.set_global_parameter(73, 0, 4321)
        assert module.get_global_parameter(73, 0) == 0
        module.store_axis_parameter(6, 0)

    def test_factory_reset(self, module: TMCM1311, connection: TmclInterface) -> None:
        """Command 137 with 1234 has no reply; what was stored is gone."""
        connection.set_and_store_axis_parameter(Motor.AP.MaxCurrent, 0, 50)
        connection.set_and_store_global_parameter(3, 2, 50)
        module.set_global_parameter(TMCM1311.GP0.CANReplyID, 0, 50)
        assert status_of(connection.send, TMCLCommand.RESTORE_FACTORY_SETTINGS, 0, 0, 1) == TMCLStatus.INVALID_VALUE
        connection.send(TMCLCommand.RESTORE_FACTORY_SETTINGS, 0, 0, 1234, no_reply=True)
        assert_in_step(connection)
        assert module.get_axis_parameter(Motor.AP.MaxCurrent, 0) == 128
        assert module.get_global_parameter(3, 2) == 0
        assert module.get_global_parameter(TMCM1311.GP0.CANReplyID, 0) == 2

    def test_reset_wants_its_number(self, connection: TmclInterface) -> None:
        """Command 255 with anything but 1234 does nothing."""
        connection.set_global_parameter(0, 2, 5)
        assert status_of(connection.send, 255, 0, 0, 0) == TMCLStatus.INVALID_VALUE
        assert connection.get_global_parameter(0, 2) == 5


class TestGlobalParameters:
    """Banks 0, 2 and 3."""

    def test_every_one_the_client_names_can_be_read(self, module: TMCM1311) -> None:
        """By the names of the client's GP0 and GP3."""
        for name, number in GLOBAL_PARAMETERS.items():
            assert isinstance(module.get_global_parameter(number, 0), int), name
        for name, number in INTERRUPT_PARAMETERS.items():
            assert module.get_global_parameter(number, 3) == 0, name

    def test_factory_settings(self, module: TMCM1311) -> None:
        """Decisions §2a.20: host 2, module 1, 9600 baud, CAN reply 2; nothing starts or is protected by itself."""
        expected = {
            "serialBaudRate": 0, "serialAddress": 1, "serialHeartbeat": 0, "CANBitrate": 8, "CANReplyID": 2, "CANModuleID": 1,
            "telegramPauseTime": 0, "serialHostAddress": 2, "autoStartMode": 0, "endSwitchPolarity": 0, "protectionMode": 0,
            "CANSecondaryAddress": 0, "eepromCoordinateStore": 0, "zeroUserVariables": 0, "serialSecondaryAddress": 0,
            "applicationStatus": 0, "downloadMode": 0, "programCounter": 0, "SuppressReply": 0,
        }  # fmt: skip
        assert {name: module.get_global_parameter(GLOBAL_PARAMETERS[name], 0) for name in expected} == expected

    @pytest.mark.parametrize(
        ("name", "allowed", "refused"),
        [
            ("serialBaudRate", [0, 11], [12, -1]),
            ("serialHeartbeat", [65_535, 0], [65_536, -1]),
            ("CANBitrate", [2, 8], [1, 9]),
            ("CANReplyID", [0, 2047], [2048, -1]),
            ("telegramPauseTime", [255, 0], [256]),
            ("autoStartMode", [1, 0], [2]),
            ("endSwitchPolarity", [1, 0], [2]),
            ("protectionMode", [3, 0], [4]),
            ("eepromCoordinateStore", [1, 0], [2]),
            ("zeroUserVariables", [1, 0], [2]),
        ],
    )
    def test_ranges(self, module: TMCM1311, name: str, allowed: list[int], refused: list[int]) -> None:
        """As for axis parameters."""
        number = GLOBAL_PARAMETERS[name]
        for value in allowed:
            module.set_global_parameter(number, 0, value)
            assert module.get_global_parameter(number, 0) == value
        for value in refused:
            assert status_of(module.set_global_parameter, number, 0, value) == TMCLStatus.INVALID_VALUE
        assert module.get_global_parameter(number, 0) == allowed[-1]

    @pytest.mark.parametrize("number", [128, 129, 130, 133])
    def test_read_only(self, module: TMCM1311, number: int) -> None:
        """Application status, download mode, program counter, random number."""
        assert status_of(module.set_global_parameter, number, 0, 0) == TMCLStatus.WRONG_TYPE

    def test_user_variables(self, module: TMCM1311) -> None:
        """256 of them, 0 at first, each its own."""
        for number in range(256):
            assert module.get_global_parameter(number, 2) == 0
            module.set_global_parameter(number, 2, number - 128)
        for number in range(256):
            assert module.get_global_parameter(number, 2, signed=True) == number - 128
        assert module.get_global_parameter(0, 2) == 2**32 - 128

    def test_interrupt_settings(self, module: TMCM1311) -> None:
        """Bank 3: periods of timers and edges of inputs. They cannot be stored."""
        for name, number in INTERRUPT_PARAMETERS.items():
            highest = 2**32 - 1 if name.startswith("timer") else 3
            module.set_global_parameter(number, 3, highest)
            assert module.get_global_parameter(number, 3) == highest
            assert status_of(module.store_global_parameter, number, 3) == TMCLStatus.WRONG_TYPE
        assert status_of(module.set_global_parameter, TMCM1311.GP3.input_0, 3, 4) == TMCLStatus.INVALID_VALUE

    def test_the_tick_timer_runs(self, module: TMCM1311) -> None:
        """GP 132 counts milliseconds and can be set."""
        timer = TMCM1311.GP0.tickTimer
        module.set_global_parameter(timer, 0, 1_000_000_000)
        first = module.get_global_parameter(timer, 0)
        assert first >= 1_000_000_000
        wait_for(lambda: module.get_global_parameter(timer, 0) > first, "the tick timer counts")
        module.set_global_parameter(timer, 0, 0)
        assert module.get_global_parameter(timer, 0) < 1_000_000_000

    def test_random_numbers(self, module: TMCM1311) -> None:
        """GP 133: 31 bits, another each time."""
        drawn = [module.get_global_parameter(TMCM1311.GP0.randomNumber, 0) for _ in range(20)]
        assert all(0 <= number < 2**31 for number in drawn)
        assert len(set(drawn)) > 15

    def test_no_replies(self, connection: TmclInterface) -> None:
        """GP 255 = 1: only SGP 255 itself is answered (decisions §2a.12)."""
        suppress = TMCM1311.GP0.SuppressReply
        assert connection.set_global_parameter(suppress, 0, 1).status == 100
        connection.send(TMCLCommand.SAP, Motor.AP.MaxCurrent, 0, 44, no_reply=True)
        connection.send(TMCLCommand.GAP, 255, 0, 0, no_reply=True)
        reply = connection.set_global_parameter(suppress, 0, 0)
        assert (reply.command, reply.status) == (TMCLCommand.SGP, 100)
        assert connection.get_axis_parameter(Motor.AP.MaxCurrent, 0) == 44


def test_the_accumulator(connection: TmclInterface) -> None:
    """CALC, CALCX, AAP, AGP and ACO work on the module's A and X and reply with A (decisions §3.9)."""

    def send(command: int, kind: int, motor: int = 0, value: int = 0) -> int:
        return connection.send(command, kind, motor, value).value

    assert send(TMCLCommand.CALC, 9, 0, 40) == 40  # LOAD
    assert send(TMCLCommand.CALCX, 9) == 40  # X = A
    assert send(TMCLCommand.CALC, 0, 0, 2) == 42  # ADD
    assert send(TMCLCommand.CALCX, 0) == 82
    assert send(TMCLCommand.AAP, Motor.AP.MaxCurrent) == 82
    assert send(TMCLCommand.AGP, 7, 2) == 82
    assert send(TMCLCommand.ACO, 5) == 82
    assert connection.get_axis_parameter(Motor.AP.MaxCurrent, 0) == 82  # which leaves A alone
    assert connection.get_global_parameter(7, 2) == 82
    assert send(TMCLCommand.GCO, 5) == 82
    assert send(TMCLCommand.CALC, 1, 0, 83) == 2**32 - 1  # SUB
