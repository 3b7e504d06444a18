//! Which status when: the table of decisions §2, row by row, and what the replies carry (decisions 1.4).

use crate::common::{EEPROM, Module, VARIABLES};
use tmcl_tables::tmcm_1311::{AxisParameter, SPEC};
use tmcl_tables::{Command, GlobalParameter, Status};
use tmcl_wire::{Request, serial};

use Status::{EepromLocked, InvalidCommand, InvalidValue, NotAvailable, Ok, WrongType};

/// Flow control, which direct mode does not have.
const FLOW_CONTROL: [Command; 12] = [
    Command::Compare,
    Command::JumpConditional,
    Command::Jump,
    Command::CallSubroutine,
    Command::ReturnFromSubroutine,
    Command::EnableInterrupt,
    Command::DisableInterrupt,
    Command::Wait,
    Command::Stop,
    Command::ClearErrorFlags,
    Command::SetInterruptVector,
    Command::ReturnFromInterrupt,
];

/// Addresses of the program memory: 2048 instructions (decisions 3.1).
const ADDRESSES: [(i32, Status); 7] = [
    (0, Ok),
    (1, Ok),
    (2047, Ok),
    (2048, InvalidValue),
    (65_536, InvalidValue),
    (-1, InvalidValue),
    (i32::MIN, InvalidValue),
];

/// Commands that find something wrong with all fields 0, for a reason of their own.
const REFUSE_ZEROS: [(Command, Status); 10] = [
    (Command::StoreAxisParameter, WrongType), // the target position has no E
    (Command::RestoreAxisParameter, WrongType),
    (Command::SetGlobalParameter, WrongType), // bank 0 begins at 64
    (Command::GetGlobalParameter, WrongType),
    (Command::StoreGlobalParameter, WrongType),
    (Command::RestoreGlobalParameter, WrongType),
    (Command::AccumulatorToGlobalParameter, WrongType),
    (Command::SetOutput, WrongType), // bank 0 is inputs
    (Command::FactoryReset, InvalidValue),
    (Command::SoftwareReset, InvalidValue),
];

fn status_of_zeros(number: u8) -> Status {
    let command = Command::ALL.iter().copied().find(|command| command.number() == number);
    let Some(command) = command.filter(|_| SPEC.command(number).is_some()) else { return InvalidCommand };
    if FLOW_CONTROL.contains(&command) {
        return NotAvailable;
    }
    match number {
        // User functions without a customer behind them (open point 212).
        64..=71 => InvalidCommand,
        _ => REFUSE_ZEROS.iter().find(|(refusing, _)| *refusing == command).map_or(Ok, |(_, status)| *status),
    }
}

#[test]
fn every_command_number_is_judged_as_the_tables_say() {
    for number in 0..=255 {
        let mut module = Module::new();
        let request = Request { command: number, ..Request::default() };
        if number == Command::FirmwareVersion.number() {
            let answer = module.exchange(&serial::encode_request(1, request));
            assert_eq!(answer, b"\x021311V111");
            continue;
        }
        if number == Command::ReadProgramMemory.number() {
            let answer = module.exchange(&serial::encode_request(1, request));
            // The host, an erased instruction, which is STOP, and the sum (decisions 1.7, 3.1).
            assert_eq!(answer, [2, 28, 0, 0, 0, 0, 0, 0, 30]);
            continue;
        }
        let first = module.replies(request)[0];
        assert_eq!((first.status, first.command), (status_of_zeros(number), number), "command {number}");
    }
}

#[test]
fn unknown_commands_are_refused_whatever_their_fields() {
    let mut module = Module::new();
    for number in [0, 16, 17, 18, 29, 40, 63, 72, 127, 140, 157, 254] {
        for (kind, motor, value) in [(0, 0, 0), (255, 255, -1), (4, 0, 1000), (66, 0, 5)] {
            let reply = module.request(Request { command: number, kind, motor, value });
            assert_eq!(reply.status, InvalidCommand, "command {number}");
        }
    }
}

#[test]
fn flow_control_is_not_available_in_direct_mode_whatever_its_fields() {
    let mut module = Module::new();
    for command in FLOW_CONTROL {
        for (kind, motor, value) in [(0, 0, 0), (255, 255, -1), (99, 7, 100_000)] {
            assert_eq!(module.status(command, kind, motor, value), NotAvailable, "{command:?}");
        }
    }
}

#[test]
fn user_functions_are_invalid_until_somebody_has_one() {
    for number in 64..=71 {
        let request = Request { command: number, kind: 1, motor: 2, value: 3 };
        assert_eq!(Module::new().request(request).status, InvalidCommand);
    }
}

#[test]
fn unknown_axis_parameters_are_wrong_types() {
    let commands = [
        Command::SetAxisParameter,
        Command::GetAxisParameter,
        Command::StoreAxisParameter,
        Command::RestoreAxisParameter,
        Command::AccumulatorToAxisParameter,
    ];
    let mut module = Module::new();
    for number in (0..=255).filter(|number| SPEC.axis_parameter(*number).is_none()) {
        for command in commands {
            assert_eq!(module.status(command, number, 0, 0), WrongType, "{command:?} {number}");
        }
    }
}

/// Bank 1 included: §10.2 says that it is normally not available (decisions 2a.9).
#[test]
fn unknown_global_parameters_and_banks_are_wrong_types() {
    let commands = [
        Command::SetGlobalParameter,
        Command::GetGlobalParameter,
        Command::StoreGlobalParameter,
        Command::RestoreGlobalParameter,
        Command::AccumulatorToGlobalParameter,
    ];
    let mut module = Module::new();
    for bank in [0, 1, 3, 4, 5, 128, 255] {
        for number in (0..=255).filter(|number| SPEC.global_parameter(bank, *number).is_none()) {
            for command in commands {
                assert_eq!(
                    module.status(command, number, bank, 0),
                    WrongType,
                    "{command:?} {number}, {bank}"
                );
            }
        }
    }
}

#[test]
fn unknown_types_are_wrong_types() {
    let mut module = Module::new();
    for kind in 0..=255 {
        let expected = |known: u8| if kind < known { Ok } else { WrongType };
        assert_eq!(module.status(Command::MoveToPosition, kind, 0, 0), expected(3), "MVP {kind}");
        assert_eq!(module.status(Command::Calculate, kind, 0, 0), expected(10), "CALC {kind}");
        assert_eq!(module.status(Command::CalculateX, kind, 0, 0), expected(11), "CALCX {kind}");
        assert_eq!(module.status(Command::ApplicationRun, kind, 0, 0), expected(2), "129, type {kind}");
        if kind > 0 {
            assert_eq!(module.status(Command::FirmwareVersion, kind, 0, 0), expected(2), "136, type {kind}");
        }
    }
}

/// §5.7.39 on command 136: motor and value are ignored. Of 138, 5.7.37 says so of the type.
#[test]
fn fields_that_mean_nothing_may_hold_anything() {
    let mut module = Module::new();
    assert_eq!(module.ok(Command::FirmwareVersion, 1, 77, -1), 0x051F_010B);
    let string = serial::encode_request(1, Request::new(Command::FirmwareVersion, 0, 77, -1));
    assert_eq!(module.exchange(&string), b"\x021311V111");
    for command in [Command::RotateRight, Command::RotateLeft, Command::MotorStop] {
        assert_eq!(module.status(command, 99, 0, 0), Ok);
    }
    assert_eq!(module.ok(Command::Calculate, 9, 99, 5), 5);
    assert_eq!(module.ok(Command::CalculateX, 9, 99, -1), 5);
    assert_eq!(module.ok(Command::GetAxisParameter, 4, 0, i32::MIN), 51_200);
    assert_eq!(module.ok(Command::GetGlobalParameter, 66, 0, -1), 1);
    assert_eq!(module.ok(Command::GetCoordinate, 5, 0, -1), 0);
    assert_eq!(module.ok(Command::ApplicationStatus, 3, 4, 5), 0);
    for command in
        [Command::ApplicationStop, Command::ApplicationStep, Command::ApplicationReset, Command::DownloadEnd]
    {
        assert_eq!(module.ok(command, 99, 7, -5), -5, "{command:?}");
    }
    assert_eq!(module.ok(Command::ApplicationRun, 0, 7, -5), -5, "from where it stands");
    assert_eq!(module.ok(Command::DownloadStart, 99, 7, 5), 5);
}

/// "Address outside program memory: status 4" (decisions §2).
#[test]
fn addresses_are_those_of_the_program_memory() {
    for (address, expected) in ADDRESSES {
        let mut module = Module::new();
        assert_eq!(module.status(Command::ApplicationRun, 1, 0, address), expected, "129, 1, {address}");
        let running = if expected == Ok { 1 << 24 | address } else { 0 };
        assert_eq!(module.ok(Command::ApplicationStatus, 0, 0, 0), running, "129, 1, {address}");
        assert_eq!(module.status(Command::ApplicationRun, 0, 0, address), Ok, "129, 0, {address}");
        if expected == InvalidValue {
            assert_eq!(module.status(Command::ReadProgramMemory, 0, 0, address), expected, "134 {address}");
        }
        assert_eq!(module.status(Command::DownloadStart, 0, 0, address), expected, "132 {address}");
        assert_eq!(module.ggp_while_downloading(GlobalParameter::DownloadMode), i32::from(expected == Ok));
    }
}

/// GP 81: 1 protects against reading back, 2 against overwriting, 3 against both (§10.1; decisions §2, 1.7). It is asked
/// before the value.
#[test]
fn a_protected_program_is_not_available() {
    for (protection, read, write) in [
        (0, InvalidValue, InvalidValue),
        (1, NotAvailable, InvalidValue),
        (2, InvalidValue, NotAvailable),
        (3, NotAvailable, NotAvailable),
    ] {
        let mut module = Module::new();
        module.sgp(GlobalParameter::CodeProtection, protection);
        assert_eq!(module.status(Command::ReadProgramMemory, 0, 0, 2048), read, "GP 81 = {protection}");
        assert_eq!(module.status(Command::DownloadStart, 0, 0, 2048), write, "GP 81 = {protection}");
    }
}

#[test]
fn there_is_no_motor_but_0() {
    let commands = [
        (Command::RotateRight, 0, 1000),
        (Command::RotateLeft, 0, 1000),
        (Command::MotorStop, 0, 0),
        (Command::MoveToPosition, 0, 1000),
        (Command::MoveToPosition, 1, 1000),
        (Command::MoveToPosition, 2, 5),
        (Command::SetAxisParameter, 4, 1000),
        (Command::GetAxisParameter, 4, 0),
        (Command::StoreAxisParameter, 4, 0),
        (Command::RestoreAxisParameter, 4, 0),
        (Command::SetCoordinate, 5, 1000),
        (Command::GetCoordinate, 5, 0),
        (Command::CaptureCoordinate, 5, 0),
        (Command::AccumulatorToAxisParameter, 1, 0),
        (Command::AccumulatorToCoordinate, 5, 0),
    ];
    let mut module = Module::new();
    for (command, kind, value) in commands {
        for motor in 1..=255 {
            let copies = matches!(command, Command::SetCoordinate | Command::GetCoordinate);
            if motor != EEPROM || !copies {
                assert_eq!(
                    module.status(command, kind, motor, value),
                    InvalidValue,
                    "{command:?}, motor {motor}"
                );
            }
        }
    }
    // Command 138 has the motor in its value (§5.7.37).
    for motor in [1, 2, 255, -1] {
        assert_eq!(module.status(Command::RequestPositionReachedEvent, 0, 0, motor), InvalidValue);
    }
    assert_eq!(module.gap(AxisParameter::RampMode), 0, "none of this was executed");
    assert_eq!(module.gap(AxisParameter::TargetPosition), 0);
}

#[test]
fn there_are_coordinates_0_to_20() {
    let mut module = Module::new();
    for number in 0..=255 {
        let expected = if number <= 20 { Ok } else { InvalidValue };
        for command in [
            Command::SetCoordinate,
            Command::GetCoordinate,
            Command::CaptureCoordinate,
            Command::AccumulatorToCoordinate,
        ] {
            assert_eq!(module.status(command, number, 0, 0), expected, "{command:?} {number}");
        }
        for command in [Command::SetCoordinate, Command::GetCoordinate] {
            assert_eq!(module.status(command, number, EEPROM, 0), expected, "{command:?} {number}, 255");
        }
    }
    for (number, expected) in [(-1, InvalidValue), (0, Ok), (20, Ok), (21, InvalidValue), (256, InvalidValue)]
    {
        assert_eq!(module.status(Command::MoveToPosition, 2, 0, number), expected, "MVP COORD, 0, {number}");
    }
}

/// Chapter 6 stands against the older range of §5.7.1; beyond axis parameter 4 is accepted (decisions 2a.5). The two ends
/// of the range differ, so what ROL makes of -327679999 is left open here.
#[test]
fn velocities_have_the_range_of_axis_parameter_2() {
    let mut module = Module::new();
    for (value, expected) in [
        (327_679_999, Ok),
        (327_680_000, InvalidValue),
        (i32::MAX, InvalidValue),
        (-327_678_000, Ok),
        (-327_680_000, InvalidValue),
        (i32::MIN, InvalidValue),
    ] {
        assert_eq!(module.status(Command::RotateRight, 0, 0, value), expected, "ROR {value}");
    }
    for (value, expected) in [
        (327_678_000, Ok),
        (327_680_000, InvalidValue),
        (-327_678_000, Ok),
        (-327_680_000, InvalidValue),
        (i32::MIN, InvalidValue),
    ] {
        assert_eq!(module.status(Command::RotateLeft, 0, 0, value), expected, "ROL {value}");
    }
}

/// 137 and 255 want the magic 1234 (decisions 1.6); without it they do nothing, but answer.
#[test]
fn resets_want_their_magic_value() {
    let mut module = Module::new();
    module.sap(AxisParameter::MaxVelocity, 777);
    for command in [Command::FactoryReset, Command::SoftwareReset] {
        for value in [0, 1, 1233, 1235, 4321, -1234, i32::MAX] {
            assert_eq!(module.status(command, 0, 0, value), InvalidValue, "{command:?} {value}");
        }
    }
    module.run_ms(10);
    assert_eq!(module.gap(AxisParameter::MaxVelocity), 777);
}

#[test]
fn setting_commands_reply_with_the_value_sent() {
    const ODD: i32 = 0x1234_5678;
    let mut module = Module::new();
    for (command, kind, motor, value) in [
        (Command::RotateRight, 0, 0, -12_345),
        (Command::RotateLeft, 0, 0, -12_345),
        (Command::MotorStop, 0, 0, ODD),
        (Command::MoveToPosition, 0, 0, -99_999),
        (Command::MoveToPosition, 1, 0, 5),
        (Command::MoveToPosition, 2, 0, 20),
        (Command::SetAxisParameter, 4, 0, 1234),
        (Command::StoreAxisParameter, 4, 0, ODD),
        (Command::RestoreAxisParameter, 4, 0, ODD),
        (Command::SetGlobalParameter, 7, VARIABLES, ODD),
        (Command::SetGlobalParameter, 73, 0, 1234),
        (Command::SetGlobalParameter, 73, 0, 4321),
        (Command::StoreGlobalParameter, 7, VARIABLES, ODD),
        (Command::RestoreGlobalParameter, 7, VARIABLES, ODD),
        (Command::SetOutput, 3, 2, 1),
        (Command::SetOutput, 255, 2, 0xA5),
        (Command::SetOutput, 255, 2, -1),
        (Command::SetCoordinate, 4, 0, ODD),
        (Command::CaptureCoordinate, 4, 0, ODD),
        (Command::ApplicationStop, 0, 0, ODD),
        (Command::ApplicationRun, 0, 0, ODD),
        (Command::ApplicationRun, 1, 0, 2047),
        (Command::ApplicationStep, 0, 0, ODD),
        (Command::ApplicationReset, 0, 0, ODD),
        (Command::DownloadStart, 0, 0, 2047),
        (Command::DownloadEnd, 0, 0, ODD),
    ] {
        assert_eq!(module.ok(command, kind, motor, value), value, "{command:?} {kind}, {motor}, {value}");
    }
}

/// "The first that applies in the order command, type, motor/bank, lock, value."
#[test]
fn of_two_statuses_the_earlier_field_decides() {
    let mut module = Module::new();
    for (command, kind, motor, value, expected) in [
        (Command::SetAxisParameter, 21, 1, 0, WrongType),
        (Command::SetAxisParameter, 8, 1, 0, WrongType), // read-only is a matter of the type
        (Command::GetAxisParameter, 29, 1, 0, WrongType), // write-only too
        (Command::StoreAxisParameter, 2, 1, 0, WrongType), // and no E
        (Command::SetAxisParameter, 6, 1, 256, InvalidValue),
        (Command::MoveToPosition, 3, 1, 0, WrongType),
        (Command::SetOutput, 8, 2, 2, WrongType),
        (Command::SetOutput, 0, 0, 2, WrongType),
        (Command::SetOutput, 0, 2, 2, InvalidValue),
        (Command::SetGlobalParameter, 66, 9, 256, WrongType),
        (Command::SetGlobalParameter, 128, 0, 9, WrongType),
        (Command::FactoryReset, 9, 9, 0, InvalidValue),
        (Command::ApplicationRun, 2, 0, 2048, WrongType),
    ] {
        assert_eq!(
            module.status(command, kind, motor, value),
            expected,
            "{command:?} {kind}, {motor}, {value}"
        );
    }
    module.sgp(GlobalParameter::EepromLock, 1234);
    for (command, kind, motor, value, expected) in [
        (Command::StoreAxisParameter, 21, 0, 0, WrongType),
        (Command::StoreAxisParameter, 2, 0, 0, WrongType),
        (Command::StoreAxisParameter, 4, 1, 0, InvalidValue),
        (Command::StoreAxisParameter, 4, 0, 0, EepromLocked),
        (Command::SetGlobalParameter, 66, 1, 5, WrongType),
        (Command::SetGlobalParameter, 77, 0, 2, EepromLocked),
        (Command::SetGlobalParameter, 77, 0, 1, EepromLocked),
        (Command::SetGlobalParameter, 73, 0, 2, InvalidValue),
        (Command::StoreGlobalParameter, 56, VARIABLES, 0, WrongType),
        (Command::StoreGlobalParameter, 55, VARIABLES, 0, EepromLocked),
        (Command::SetCoordinate, 21, EEPROM, 0, InvalidValue),
        (Command::SetCoordinate, 20, EEPROM, 0, EepromLocked),
        (Command::SetAxisParameter, 6, 0, 256, InvalidValue),
    ] {
        assert_eq!(
            module.status(command, kind, motor, value),
            expected,
            "locked: {command:?} {kind}, {motor}"
        );
    }
}

/// §6, AP 14 and AP 128: "this mode of operation cannot be used in open loop mode".
#[test]
fn torque_mode_is_not_available_in_open_loop() {
    let mut module = Module::new();
    for (parameter, value, expected) in [
        (AxisParameter::TorqueTargetCurrent, 100, NotAvailable),
        (AxisParameter::TorqueTargetCurrent, 0, NotAvailable),
        (AxisParameter::RampMode, 2, NotAvailable),
        (AxisParameter::RampMode, 3, InvalidValue),
        (AxisParameter::RampMode, 1, Ok),
    ] {
        let status = module.status(Command::SetAxisParameter, parameter.number(), 0, value);
        assert_eq!(status, expected, "SAP {parameter:?} {value}");
    }
}

mod position_reached_event {
    use super::*;

    const REQUEST: Request = Request::new(Command::RequestPositionReachedEvent, 0, 0, 0);

    /// §5.7.37: the motor bit mask of motor 0.
    const MASK: i32 = 1;

    fn event(module: &mut Module) -> Option<(Status, u8, i32)> {
        let events = module.unasked();
        assert!(events.len() <= 1, "{events:?}");
        events.first().map(|event| (event.status, event.command, event.value))
    }

    #[test]
    fn comes_once_when_the_target_is_reached() {
        let mut module = Module::new();
        module.ok(Command::MoveToPosition, 0, 0, 5000);
        let reply = module.request(REQUEST);
        assert_eq!((reply.status, reply.value), (Ok, MASK));
        let seen = loop {
            assert_eq!(module.gap(AxisParameter::PositionReached), 0, "reached, but no event");
            module.run_ticks(1);
            if let Some(seen) = event(&mut module) {
                break seen;
            }
        };
        assert_eq!(seen, (Status::Delayed, 138, MASK));
        assert_eq!(module.gap(AxisParameter::PositionReached), 1, "not before the target is reached");
        module.ok(Command::MoveToPosition, 0, 0, 0);
        module.run_ms(5000);
        assert_eq!(module.gap(AxisParameter::PositionReached), 1);
        assert_eq!(event(&mut module), None, "one request, one event");
    }

    #[test]
    fn follows_at_once_when_the_target_is_reached_already() {
        let mut module = Module::new();
        let mut replies = module.replies(REQUEST);
        module.run_ticks(2);
        replies.extend(module.unasked());
        let statuses: Vec<_> =
            replies.iter().map(|reply| (reply.status, reply.command, reply.value)).collect();
        assert_eq!(statuses, [(Ok, 138, MASK), (Status::Delayed, 138, MASK)]);
        module.run_ms(100);
        assert_eq!(event(&mut module), None);
    }

    #[test]
    fn goes_to_the_port_that_asked() {
        let mut module = Module::new();
        module.ok(Command::MoveToPosition, 0, 0, 500);
        module.request(REQUEST);
        module.run_ms(2000);
        let asked = module.port;
        for port in virtual_bench::PortId::ALL {
            module.port = port;
            assert_eq!(event(&mut module).is_some(), port == asked, "{port:?}");
        }
    }

    /// Decisions 1.10: each well-formed 138 gets two replies, even ten in a row, more than fit the way out at once.
    #[test]
    fn comes_for_each_of_several_requests() {
        let mut module = Module::new();
        module.ok(Command::MoveToPosition, 0, 0, 500);
        for _ in 0..10 {
            module.request(REQUEST);
        }
        module.run_ms(2000);
        assert_eq!(
            module.unasked(),
            [tmcl_wire::Reply { status: Status::Delayed, command: 138, value: MASK }; 10]
        );
    }

    /// Decisions 2a.11 and 2a.12: by the time of the event, the new host and address count, and silence is silence.
    #[test]
    fn obeys_the_settings_that_stand_when_it_is_sent() {
        let mut module = Module::new();
        module.ok(Command::MoveToPosition, 0, 0, 500);
        module.request(REQUEST);
        module.sgp(GlobalParameter::HostAddress, 20);
        module.host = 20;
        module.sgp(GlobalParameter::SerialAddress, 10);
        module.address = 10;
        let mut silent = module.clone();
        module.run_ms(2000);
        assert_eq!(event(&mut module), Some((Status::Delayed, 138, MASK)));

        silent.sgp(GlobalParameter::SuppressReply, 1);
        silent.run_ms(2000);
        assert_eq!(event(&mut silent), None);
    }
}
