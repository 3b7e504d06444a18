//! Global parameter 81: who may see and overwrite a program (TMCM-1311 §10.1; decisions §2, 1.7, 2a.10, 3.12).

use crate::common::program::*;
use crate::common::{Module, VARIABLES};
use tmcl_tables::{Command, GlobalParameter as Gp, Status};
use tmcl_wire::Request;
use virtual_bench::PortId;

const STOPPED: i32 = 0;

/// Sets user variable 7 to 77.
const MARK: [Request; 2] = [sgp(7, VARIABLES, 77), STOP];

fn marked(module: &mut Module) -> bool {
    module.variable(7) == 77
}

/// Loads [`MARK`] and protects it.
fn protected(protection: i32) -> Module {
    let mut module = Module::with_program(&MARK);
    module.sgp(Gp::CodeProtection, protection);
    module
}

fn runs(module: &mut Module) -> bool {
    module.set_variable(7, 0);
    module.run_from(0);
    module.run_to_stop(10);
    marked(module)
}

fn assert_protected(module: &mut Module, protection: i32) {
    assert_eq!(module.ggp(Gp::CodeProtection), protection);
    if protection & 1 != 0 {
        for address in [0, 1, 2047, 2048] {
            assert_eq!(module.status(Command::ReadProgramMemory, 0, 0, address), Status::NotAvailable);
        }
    } else {
        module.read_instruction(0);
    }
    let status = module.status(Command::DownloadStart, 0, 0, 1000);
    assert_eq!(status, if protection & 2 != 0 { Status::NotAvailable } else { Status::Ok });
    module.ok(Command::DownloadEnd, 0, 0, 0);
}

/// From 1 or 3 to 0 or 2 the program is erased, in RAM and for good; otherwise it stays (§10.1).
#[test]
fn every_change_erases_or_keeps_as_it_should() {
    for from in 0..=3 {
        for to in 0..=3 {
            let mut module = protected(from);
            assert_protected(&mut module, from);
            module.sgp(Gp::CodeProtection, to);
            let erased = from & 1 != 0 && to & 1 == 0;
            for _ in 0..2 {
                assert_protected(&mut module, to);
                assert_eq!(runs(&mut module), !erased, "{from} to {to}");
                if to & 1 == 0 {
                    let expected = if erased { STOP } else { MARK[0] };
                    assert_eq!(module.read_instruction(0), expected, "{from} to {to}");
                }
                module.power_cycle();
            }
        }
    }
}

#[test]
fn a_program_that_runs_while_it_is_erased_stops() {
    let mut module = Module::with_program(&program(&[&count(7), &[ja(0)]]));
    module.sgp(Gp::CodeProtection, 1);
    module.run_from(0);
    module.run_ms(10);
    module.sgp(Gp::CodeProtection, 0);
    let counted = module.variable(7);
    module.run_ms(10);
    assert_eq!((module.status_of_program().0, module.variable(7)), (STOPPED, counted));
}

/// A program can protect and erase itself.
#[test]
fn a_program_may_erase_itself() {
    let mut module = Module::with_program(&[sgp(81, 0, 1), sgp(81, 0, 0), sgp(7, VARIABLES, 77), STOP]);
    module.run_from(0);
    module.run_ms(1);
    assert_eq!(module.status_of_program().0, STOPPED);
    assert!(!marked(&mut module));
    module.power_cycle();
    assert_eq!(module.read_instruction(2), STOP);
}

/// What was protected from reading must not become readable by forgetting the protection.
#[test]
fn factory_settings_do_not_give_a_program_away() {
    for protection in [1, 3] {
        for forget in [
            |module: &mut Module| module.unanswered(Command::FactoryReset, 0, 0, 1234),
            |module: &mut Module| {
                module.sgp(Gp::EepromMagic, 0);
                module.power_cycle();
            },
        ] {
            let mut module = protected(protection);
            forget(&mut module);
            assert_eq!(module.ggp(Gp::CodeProtection), 0);
            for address in 0..3 {
                assert_eq!(module.read_instruction(address), STOP);
            }
            assert!(!runs(&mut module));
            module.power_cycle();
            assert_eq!(module.read_instruction(0), STOP);
        }
    }
}

/// A locked EEPROM ignores 137 (decisions 2a.10), and the lock covers parameter 81.
#[test]
fn the_lock_keeps_the_protection() {
    let mut module = protected(1);
    module.sgp(Gp::EepromLock, 1234);
    module.unanswered(Command::FactoryReset, 0, 0, 1234);
    module.run_ms(10);
    assert_eq!(module.status(Command::SetGlobalParameter, 81, 0, 0), Status::EepromLocked);
    assert_protected(&mut module, 1);
    assert!(runs(&mut module));
}

/// "Programs are protected by GP 81, not by the lock" (decisions 2a.10).
#[test]
fn the_lock_does_not_keep_programs_out() {
    let mut module = Module::new();
    module.sgp(Gp::EepromLock, 1234);
    module.download(&MARK);
    module.power_cycle();
    assert!(runs(&mut module));
}

/// Protection that comes in the middle of a download ends it.
#[test]
fn a_download_under_way_does_not_overwrite_what_is_protected_now() {
    let mut module = Module::with_program(&MARK);
    module.ok(Command::DownloadStart, 0, 0, 0);
    module.port = PortId::ALL[1];
    module.sgp(Gp::CodeProtection, 2);
    module.port = PortId::ALL[0];
    assert_eq!(module.request(sgp(8, VARIABLES, 88)).status, Status::NotAvailable);
    module.ok(Command::DownloadEnd, 0, 0, 0);
    assert_eq!(module.read_instruction(0), MARK[0]);
}
