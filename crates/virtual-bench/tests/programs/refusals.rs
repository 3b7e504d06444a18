//! What programs store, and what happens to instructions that fail: they are skipped, listed, and the program goes on
//! (TMCM-1311 §10; decisions §2, 2a.10, 2a.13, 3.11).

use crate::common::program::*;
use crate::common::{EEPROM, Module, VARIABLES};
use tmcl_tables::tmcm_1311::AxisParameter as Ap;
use tmcl_tables::{Command, GlobalParameter as Gp, Status};
use tmcl_wire::Request;
use virtual_bench::TICK_NS;

const FAST: &str = "[[module]]\nkind = \"tmcm-1311\"\ninstructions_per_tick = ";

/// §10.3: in RAM, stored by STGP, restored at power-on unless GP 85 says not to (decisions 2a.13).
#[test]
fn variables_are_stored_by_stgp_in_a_program() {
    let store = [
        sgp(3, VARIABLES, 33),
        op(Command::StoreGlobalParameter, 3, VARIABLES, 0),
        sgp(3, VARIABLES, 44),
        sgp(4, VARIABLES, 55),
        op(Command::StoreGlobalParameter, 56, VARIABLES, 0), // refused: no E
        STOP,
        op(Command::RestoreGlobalParameter, 3, VARIABLES, 0),
        STOP,
    ];
    let mut module = Module::with_program(&store);
    module.run_from(0);
    module.run_to_stop(20);
    assert_eq!((module.variable(3), module.variable(4)), (44, 55));
    assert_eq!(module.refused(), [(4, Status::WrongType, 1)]);
    module.run_from(6);
    module.run_to_stop(20);
    assert_eq!(module.variable(3), 33);
    module.set_variable(3, 99);
    module.power_cycle();
    assert_eq!((module.variable(3), module.variable(4)), (33, 0));
    module.sgp(Gp::DoNotRestoreVariables, 1);
    module.power_cycle();
    assert_eq!(module.variable(3), 0);
    module.sgp(Gp::DoNotRestoreVariables, 0);
    module.power_cycle();
    assert_eq!(module.variable(3), 33);
}

/// STAP, SGP in bank 0 and the coordinates' EEPROM, from a program.
fn storing() -> Vec<Request> {
    vec![
        sap(4, 4444),
        op(Command::StoreAxisParameter, 4, 0, 0),
        sgp(84, 0, 0),
        sgp(75, 0, 15),
        op(Command::SetCoordinate, 5, 0, 5555),
        op(Command::SetCoordinate, 6, 0, 6666),
        op(Command::SetCoordinate, 5, EEPROM, 0),
        op(Command::SetCoordinate, 6, EEPROM, 0),
        sgp(7, VARIABLES, 77),
        STOP,
        op(Command::GetCoordinate, 0, EEPROM, 0),
        op(Command::GetCoordinate, 5, 0, 0),
        keep(8),
        STOP,
    ]
}

#[test]
fn a_program_writes_the_eeprom() {
    let mut module = Module::with_program(&storing());
    module.run_from(0);
    module.run_to_stop(100);
    assert_eq!((module.refused(), module.variable(7)), (vec![], 77));
    module.power_cycle();
    assert_eq!(module.gap(Ap::MaxVelocity), 4444);
    assert_eq!(module.ggp(Gp::TelegramPause), 15);
    assert_eq!(module.coordinate(5), 0, "in RAM it was lost");
    module.run_from(10);
    module.run_to_stop(20);
    assert_eq!((module.variable(8), module.coordinate(6)), (5555, 6666));
}

/// Skipped, and the program goes on (decisions 3.11).
#[test]
fn a_locked_eeprom_refuses_a_program_too() {
    for instructions_per_tick in [1, 20] {
        let mut module = Module::on(&format!("{FAST}{instructions_per_tick}"));
        module.download(&storing());
        module.sgp(Gp::EepromLock, 1234);
        let writes = module.bench.eeprom(crate::common::MODULE).expect("an EEPROM").writes();
        module.run_from(0);
        module.run_to_stop(100);
        let locked = Status::EepromLocked;
        let refused = [(1, locked, 1), (2, locked, 1), (3, locked, 1), (6, locked, 1), (7, locked, 1)];
        assert_eq!(module.refused(), refused, "{instructions_per_tick} a tick");
        assert_eq!((module.variable(7), module.gap(Ap::MaxVelocity)), (77, 4444));
        assert_eq!(module.bench.eeprom(crate::common::MODULE).expect("an EEPROM").writes(), writes);
    }
}

/// GP 84 = 1: every way to write a coordinate writes it through.
#[test]
fn coordinates_are_written_through_from_a_program() {
    let writes = [
        op(Command::SetCoordinate, 1, 0, 11),
        calc(kind::LOAD, 22),
        op(Command::AccumulatorToCoordinate, 2, 0, 0),
        sap(1, 33),
        op(Command::CaptureCoordinate, 3, 0, 0),
        op(Command::SetCoordinate, 0, 0, 99),
        STOP,
    ];
    let mut module = Module::with_program(&writes);
    module.sgp(Gp::CoordinateStorage, 1);
    module.run_from(0);
    module.run_to_stop(100);
    module.power_cycle();
    let coordinates: Vec<_> = (0..5).map(|number| module.coordinate(number)).collect();
    assert_eq!(coordinates, [0, 11, 22, 33, 0]);
}

/// One of each kind of refusal, with the status of decisions §2; each is skipped and leaves A alone.
fn refusable() -> (Vec<Request>, Vec<(u16, Status)>) {
    use Status::{InvalidCommand, InvalidValue, NotAvailable, WrongType};
    let instructions = [
        (Request { command: 200, ..Request::default() }, InvalidCommand),
        (Request { command: 29, ..Request::default() }, InvalidCommand),
        (op(Command::UserFunction0, 0, 0, 0), InvalidCommand),
        (op(Command::SoftwareReset, 0, 0, 1234), NotAvailable),
        (sap(21, 0), WrongType),
        (sap(8, 0), WrongType),
        (sap(6, 256), InvalidValue),
        (op(Command::GetAxisParameter, 1, 1, 0), InvalidValue),
        (op(Command::GetAxisParameter, 29, 0, 0), WrongType),
        (ggp(1, 1), WrongType),
        (sgp(133, 0, 1), WrongType),
        (op(Command::MoveToPosition, 3, 0, 0), WrongType),
        (sio(8, 1), WrongType),
        (sio(0, 2), InvalidValue),
        (gio(3, 1), WrongType),
        (calc(10, 0), WrongType),
        (op(Command::CalculateX, 11, 0, 0), WrongType),
        (op(Command::GetCoordinate, 21, 0, 0), InvalidValue),
        (jc(13, 0), WrongType),
        (ja(2048), InvalidValue),
        (csub(-1), InvalidValue),
        (wait(5, 1), WrongType),
        (op(Command::Wait, kind::POS, 1, 1), InvalidValue),
        (vect(4, 0), WrongType),
        (vect(3, 2048), InvalidValue),
        (ei(14), WrongType),
        (di(47), WrongType),
        (op(Command::ClearErrorFlags, 6, 0, 0), WrongType),
        (sap(14, 100), NotAvailable),
    ];
    let statuses = instructions.iter().enumerate().map(|(address, (_, status))| (address as u16, *status));
    (instructions.iter().map(|(instruction, _)| *instruction).collect(), statuses.collect())
}

#[test]
fn refused_instructions_are_skipped_and_listed() {
    let (mut instructions, statuses) = refusable();
    let end = instructions.len();
    instructions.extend([keep(7), STOP]);
    for instructions_per_tick in [1, 3, 1000] {
        let mut module = Module::on(&format!("{FAST}{instructions_per_tick}"));
        module.download(&instructions);
        assert_eq!(module.refused(), []);
        for times in 1..=2 {
            module.set_variable(7, 0);
            module.ok(Command::Calculate, kind::LOAD, 0, 4711);
            module.run_from(0);
            module.run_to_stop(100);
            assert_eq!(module.ggp(Gp::ProgramCounter), end as i32 + 1);
            assert_eq!(module.variable(7), 4711, "A is left alone");
            let expected: Vec<_> =
                statuses.iter().map(|(address, status)| (*address, *status, times)).collect();
            assert_eq!(module.refused(), expected, "{instructions_per_tick} a tick");
        }
        let before = module.refused();
        module.power_cycle();
        assert_eq!(module.refused(), before, "a power cycle does not make them undone");
    }
}

#[test]
fn refusals_say_when_first() {
    let mut module = Module::with_program(&[sap(21, 0), wait(kind::TICKS, 1), ja(0)]);
    module.run_ms(10);
    let from_ns = module.bench.time_ns();
    module.run_from(0);
    module.run_ms(100);
    let refused: Vec<_> = module.bench.refused_instructions(crate::common::MODULE).collect();
    let [refused] = refused[..] else { panic!("{refused:?}") };
    assert_eq!((refused.address, refused.status), (0, Status::WrongType));
    assert_eq!(refused.first_ns, from_ns + TICK_NS);
    assert_eq!(refused.count, 10, "once each 10 ms and two instructions");
}

/// Steps in no time lose no refusal either.
#[test]
fn steps_list_what_was_refused() {
    let (instructions, statuses) = refusable();
    let mut module = Module::with_program(&instructions);
    for _ in &instructions {
        module.step();
    }
    module.run_ticks(2);
    let expected: Vec<_> = statuses.iter().map(|(address, status)| (*address, *status, 1)).collect();
    assert_eq!(module.refused(), expected);
}
