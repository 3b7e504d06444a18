//! Command lines as people type them, against the tables of the modules (TMCM-1311 §4.4).

use proptest::prelude::*;
use tmcl_tables::{
    Command, MODULES, ModuleCommand, ModuleSpec, Operand, Status, TypeField, tmcm_1311, tmcm_1640,
};
use tmcl_wire::Request;
use tmcl_wire::ascii::{CommandLine, Input, LINE_LENGTH, Typed};

fn line(text: &str) -> CommandLine {
    let mut line = CommandLine::new();
    for byte in text.bytes() {
        line.push(byte);
    }
    line
}

fn input(text: &str) -> Result<Input, Status> {
    line(text).input(&tmcm_1311::SPEC)
}

fn request(command: Command, kind: u8, motor: u8, value: i32) -> Result<Input, Status> {
    Ok(Input::Request(Request::new(command, kind, motor, value)))
}

/// §4.4.1, and the line of §4.4.2.
#[test]
fn the_lines_that_the_manual_prints() {
    assert_eq!(input("AMVP ABS, 1, 50000"), request(Command::MoveToPosition, 0, 1, 50_000));
    assert_eq!(input("A MVP ABS, 1, 50000"), request(Command::MoveToPosition, 0, 1, 50_000));
    assert_eq!(input("AROL 2, 500"), request(Command::RotateLeft, 0, 2, 500));
    assert_eq!(input("A MST 1"), request(Command::MotorStop, 0, 1, 0));
    assert_eq!(input("ABIN"), Ok(Input::Binary));
    assert_eq!(input("AGAP 0, 1"), request(Command::GetAxisParameter, 0, 1, 0));
}

/// §4.4.3, with the operand forms of chapter 5.
#[test]
fn the_commands_that_the_manual_lists() {
    for (text, command, kind, motor, value) in [
        ("ROL 0, 500", Command::RotateLeft, 0, 0, 500),
        ("ROR 0, -500", Command::RotateRight, 0, 0, -500),
        ("MST 0", Command::MotorStop, 0, 0, 0),
        ("MVP ABS, 0, 90000", Command::MoveToPosition, 0, 0, 90_000),
        ("MVP REL, 0, -1000", Command::MoveToPosition, 1, 0, -1000),
        ("MVP COORD, 0, 8", Command::MoveToPosition, 2, 0, 8),
        ("SAP 6, 0, 200", Command::SetAxisParameter, 6, 0, 200),
        ("GAP 0, 0", Command::GetAxisParameter, 0, 0, 0),
        ("STAP 4, 0", Command::StoreAxisParameter, 4, 0, 0),
        ("RSAP 6, 0", Command::RestoreAxisParameter, 6, 0, 0),
        ("SGP 66, 0, 3", Command::SetGlobalParameter, 66, 0, 3),
        ("GGP 66, 0", Command::GetGlobalParameter, 66, 0, 0),
        ("STGP 42, 2", Command::StoreGlobalParameter, 42, 2, 0),
        ("RSGP 42, 2", Command::RestoreGlobalParameter, 42, 2, 0),
        ("RFS START, 0", Command::ReferenceSearch, 0, 0, 0),
        ("RFS STOP, 0", Command::ReferenceSearch, 1, 0, 0),
        ("RFS STATUS, 0", Command::ReferenceSearch, 2, 0, 0),
        ("SIO 7, 2, 1", Command::SetOutput, 7, 2, 1),
        ("GIO 0, 1", Command::GetInput, 0, 1, 0),
        ("SCO 1, 0, 1000", Command::SetCoordinate, 1, 0, 1000),
        ("SCO 0, 255, 0", Command::SetCoordinate, 0, 255, 0),
        ("GCO 0, 0", Command::GetCoordinate, 0, 0, 0),
        ("GCO 0, 255, 0", Command::GetCoordinate, 0, 255, 0),
        ("CCO 3, 0", Command::CaptureCoordinate, 3, 0, 0),
        ("UF0", Command::UserFunction0, 0, 0, 0),
        ("UF7 1, 2, 3", Command::UserFunction7, 1, 2, 3),
        ("RUN", Command::ApplicationRun, 0, 0, 0),
        ("RUN 10", Command::ApplicationRun, 1, 0, 10),
        ("STOP", Command::ApplicationStop, 0, 0, 0),
        ("CALC ADD, -5", Command::Calculate, 0, 0, -5),
        ("CALC NOT", Command::Calculate, 8, 0, 0),
        ("CALCX SWAP", Command::CalculateX, 10, 0, 0),
        ("AAP 4, 0", Command::AccumulatorToAxisParameter, 4, 0, 0),
        ("AGP 1, 2", Command::AccumulatorToGlobalParameter, 1, 2, 0),
        ("ACO 1, 0", Command::AccumulatorToCoordinate, 1, 0, 0),
    ] {
        assert_eq!(input(&format!("A{text}")), request(command, kind, motor, value), "{text}");
    }
}

#[test]
fn letters_blanks_and_commas_are_as_people_type_them() {
    let expected = request(Command::MoveToPosition, 0, 0, 1000);
    for text in [
        "amvp abs,0,1000",
        "A   Mvp   Abs ,  0 ,\t1000  ",
        "AMVP, ABS, 0, 1000",
        "AMVP ABS 0 1000",
        "AMVP 0, 0, 1000",
        "AMVP ABS, +0, $3E8",
        "AMVP ABS, 0x00, 0x3e8",
        "  \tAMVP ABS, 0, 001000",
    ] {
        assert_eq!(input(text), expected, "{text}");
    }
}

#[test]
fn what_is_no_command_is_said_to_be_none() {
    for text in [
        "A",
        "A ",
        "A,",
        "AMV",
        "AMVPX 1",
        "AMVP\u{1}ABS, 0, 0",
        "A5",
        "A-",
        "ABINARY",
        "AMSTO",
        "AVERSION",
        "ADATA 1",
    ] {
        assert_eq!(input(text), Err(Status::InvalidCommand), "{text:?}");
    }
    let long = format!("AMST 0{}", " ".repeat(LINE_LENGTH));
    assert_eq!(input(&long), Err(Status::InvalidCommand));
}

#[test]
fn a_first_operand_that_is_no_type_is_a_wrong_type() {
    for text in [
        "AMVP",
        "AMVP FOO, 0, 0",
        "AMVP ,, 0, 0",
        "AGAP",
        "AGAP x, 0",
        "AGAP 256, 0",
        "AGAP -1, 0",
        "ARFS 1.5, 0",
        "AGAP,",
        "ACALCX",
    ] {
        assert_eq!(input(text), Err(Status::WrongType), "{text}");
    }
}

#[test]
fn any_other_operand_that_is_wrong_missing_or_too_much_is_an_invalid_value() {
    for text in [
        "AMVP ABS",
        "AMVP ABS, 0",
        "AMVP ABS, 0,",
        "AMVP ABS,, 5",
        "AMVP ABS, 256, 5",
        "AMVP ABS, -1, 5",
        "AMVP ABS, 0, 2147483648",
        "AMVP ABS, 0, 50.000",
        "AMVP ABS, 0, 50 000",
        "AMVP ABS, 0, - 5",
        "AMVP ABS, 0, 5, 6",
        "AMST",
        "AMST x",
        "AMST 0, 0",
        "ASAP 4, 0, 5x",
        "AGAP 1",
        "AGAP 1, 0, 0, 0",
        "ARUN x",
        "ARUN 1, 2",
        "ASTOP 1",
        "ABIN 1",
        "AUF0 1, 2, 3, 4",
    ] {
        assert_eq!(input(text), Err(Status::InvalidValue), "{text}");
    }
}

#[test]
fn commands_of_programs_are_not_available_whatever_their_operands() {
    for text in [
        "AJA 5",
        "AJC ZE, 5",
        "ACOMP",
        "AWAIT POS, 0, 0",
        "AEI 255",
        "AVECT 0, 0",
        "ACLE ALL",
        "ARSUB",
        "ARETI",
    ] {
        assert_eq!(input(text), Err(Status::NotAvailable), "{text}");
    }
}

/// AP 29 of the TMCM-1311 is unsigned, AP 4 is not.
#[test]
fn unsigned_parameters_take_all_32_bits() {
    let unsigned = tmcm_1311::SPEC.axis_parameters.iter().find(|spec| spec.unsigned).expect("there is one");
    let text = format!("ASAP {}, 0, 4294967295", unsigned.number);
    assert_eq!(input(&text), request(Command::SetAxisParameter, unsigned.number, 0, -1));
    assert_eq!(input("ASAP 4, 0, 4294967295"), Err(Status::InvalidValue));
    assert_eq!(input("ASGP 0, 3, 4294967295"), request(Command::SetGlobalParameter, 0, 3, -1));
}

#[test]
fn a_module_has_the_commands_and_types_of_its_tables() {
    assert_eq!(line("ARFS START, 0").input(&tmcm_1640::SPEC), Err(Status::InvalidCommand));
    assert_eq!(line("AMVP COORD, 0, 1").input(&tmcm_1640::SPEC), Err(Status::WrongType));
}

/// Every command that a host may send and text can name.
fn commands() -> Vec<(&'static ModuleSpec, &'static ModuleCommand)> {
    let all = MODULES.iter().flat_map(|module| module.commands.iter().map(move |entry| (*module, entry)));
    all.filter(|(_, entry)| entry.modes.direct && !entry.spec.mnemonic.is_empty()).collect()
}

/// A request as a line, keywords where there are any.
fn write(request: Request, entry: &ModuleCommand, separator: &str) -> String {
    let named = entry.named_types().find(|named| named.value == request.kind);
    let operands = entry.spec.operands.iter().map(|operand| match operand {
        Operand::Type => named.map_or(request.kind.to_string(), |named| named.keyword.to_owned()),
        Operand::Motor => request.motor.to_string(),
        Operand::Value => request.value.to_string(),
    });
    format!("A{} {}", entry.spec.mnemonic, operands.collect::<Vec<_>>().join(separator))
}

proptest! {
    /// Whatever the binary form can say with a command's operands, a line can say.
    #[test]
    fn every_request_survives_being_typed(
        index in any::<prop::sample::Index>(), kind: u8, motor: u8, value: i32,
        separator in prop::sample::select(vec![",", ", ", " ,  ", " "]), lower: bool,
    ) {
        let all = commands();
        let (module, entry) = all[index.index(all.len())];
        let has = |operand| entry.spec.operands.contains(&operand);
        let kind = match entry.spec.type_field {
            TypeField::Named => entry.types[usize::from(kind) % entry.types.len()],
            _ => kind,
        };
        let request = Request::new(
            entry.spec.command,
            if has(Operand::Type) { kind } else { 0 },
            if has(Operand::Motor) { motor } else { 0 },
            if has(Operand::Value) { value } else { 0 },
        );
        let text = write(request, entry, separator);
        let text = if lower { text.to_lowercase() } else { text };
        prop_assert!(text.len() <= LINE_LENGTH);
        prop_assert_eq!(line(&text).input(module), Ok(Input::Request(request)), "{}", text);
    }

    /// Any bytes are a line, a shorter one, or nothing; and every line gets a request or a status that the manual has for it.
    #[test]
    fn any_bytes_are_judged(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
        let mut line = CommandLine::new();
        for byte in bytes {
            let before = line.text().to_vec();
            match line.push(byte) {
                Typed::Kept => prop_assert_eq!(line.text(), [before, vec![byte]].concat()),
                Typed::Erased => prop_assert_eq!(line.text(), &before[..before.len() - 1]),
                Typed::Nothing => prop_assert_eq!(line.text(), before),
                Typed::Ended => {
                    prop_assert!(!before.is_empty());
                    let judged = line.input(&tmcm_1311::SPEC);
                    let statuses =
                        [Status::InvalidCommand, Status::WrongType, Status::InvalidValue, Status::NotAvailable];
                    prop_assert!(judged.map_or_else(|status| statuses.contains(&status), |_| true));
                    line.clear();
                }
            }
        }
    }
}
