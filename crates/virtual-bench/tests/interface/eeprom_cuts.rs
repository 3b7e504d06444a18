//! The power fails at every single byte write of everything that writes: afterwards each record has its old or its new value,
//! nothing else has changed, and what was acknowledged stands.

use std::collections::BTreeMap;

use crate::common::program::*;
use crate::common::{EEPROM, MODULE, Module, VARIABLES};
use proptest::prelude::*;
use tmcl_tables::{Command, GlobalParameter as Gp, Status};
use tmcl_wire::Request;
use virtual_bench::{Eeprom, Instruction, ModuleKind, RecordKey};

fn new(kind: ModuleKind) -> Module {
    Module::with_image(kind, &Eeprom::new(kind).to_image())
}

fn eeprom(module: &mut Module) -> &mut Eeprom {
    module.bench.eeprom_mut(MODULE).expect("an EEPROM")
}

/// What is stored.
#[derive(Clone, Debug, PartialEq)]
struct Stored {
    records: BTreeMap<u16, i32>,
    program: Vec<Instruction>,
}

fn stored(module: &mut Module) -> Stored {
    let eeprom = eeprom(module);
    let records = eeprom.records().map(|(key, value)| (key.to_u16(), value)).collect();
    Stored { records, program: eeprom.program() }
}

/// Sends requests until one is not answered; returns how many were. A module without power answers nothing.
fn acknowledged(module: &mut Module, requests: &[Request]) -> usize {
    let answered = requests.iter().take_while(|request| {
        let replies = module.replies(**request);
        replies.iter().any(|reply| matches!(reply.status, Status::Ok | Status::Loaded))
    });
    answered.count()
}

/// Cuts at every byte write of a scenario whose every request writes one record at most. Returns how many there were.
#[track_caller]
fn at_every_byte_write(begin: &Module, requests: &[Request]) -> u64 {
    let mut states = vec![stored(&mut begin.clone())];
    let mut undisturbed = begin.clone();
    for request in requests {
        assert_eq!(acknowledged(&mut undisturbed, &[*request]), 1, "{request:?}");
        states.push(stored(&mut undisturbed));
    }
    for writes in 0.. {
        let mut module = begin.clone();
        eeprom(&mut module).cut_after(writes);
        let done = acknowledged(&mut module, requests);
        if done == requests.len() {
            return writes;
        }
        assert!(eeprom(&mut module).is_cut());
        let time_ns = module.bench.time_ns();
        module.run_ms(1);
        assert_eq!(module.bench.time_ns(), time_ns + 1_000_000);
        assert_eq!(module.replies(requests[0]), [], "it is off");
        module.power_cycle();
        let found = stored(&mut module);
        let allowed = [&states[done], &states[done + 1]];
        assert!(allowed.contains(&&found), "{writes}: {:?} left {found:?}", requests[done]);
        // The image is in order, and the module goes on where it was.
        let mut module = Module::with_image(eeprom(&mut module).kind(), &module.image());
        // What was set before it was to be stored is gone, and has to be set again.
        let rest = &requests[done.saturating_sub(1)..];
        assert_eq!(acknowledged(&mut module, rest), rest.len());
        assert_eq!(stored(&mut module), states[requests.len()], "{writes}");
    }
    unreachable!("the scenario ends")
}

fn store_axis(number: u8, value: i32) -> [Request; 2] {
    [op(Command::SetAxisParameter, number, 0, value), op(Command::StoreAxisParameter, number, 0, 0)]
}

fn store_variable(number: u8, value: i32) -> [Request; 2] {
    [sgp(number, VARIABLES, value), op(Command::StoreGlobalParameter, number, VARIABLES, 0)]
}

#[test]
fn stores_of_every_kind() {
    for (kind, acceleration) in [(ModuleKind::Tmcm1311, 5), (ModuleKind::Tmcm1640, 11)] {
        let mut requests = Vec::new();
        for value in [1000, 2000, 3000, 1000] {
            requests.extend(store_axis(4, value));
            requests.extend(store_axis(acceleration, value + 1));
            requests.extend(store_variable(7, -value));
            requests.push(sgp(77, 0, (value / 1000) & 1));
        }
        requests.push(sgp(73, 0, 1234));
        requests.push(sgp(73, 0, 4321));
        assert!(at_every_byte_write(&new(kind), &requests) > 100);
    }
}

#[test]
fn coordinates_that_are_written_through() {
    let mut requests = vec![sgp(84, 0, 1)];
    for value in 1..4 {
        requests.extend([1, 2, 20].map(|number| op(Command::SetCoordinate, number, 0, -value)));
    }
    assert!(at_every_byte_write(&new(ModuleKind::Tmcm1311), &requests) > 30);
}

#[test]
fn a_download_over_a_download() {
    for kind in [ModuleKind::Tmcm1311, ModuleKind::Tmcm1640] {
        let mut module = new(kind);
        module.download(&[sgp(7, VARIABLES, 1), sgp(8, VARIABLES, 2), sgp(9, VARIABLES, 3), STOP]);
        let instructions = [sgp(7, VARIABLES, 4), sgp(8, VARIABLES, 2), STOP, sgp(10, VARIABLES, -1)];
        let begin = op(Command::DownloadStart, 0, 0, 0);
        let requests: Vec<_> = [begin].into_iter().chain(instructions).collect();
        let mut states = vec![stored(&mut module)];
        let mut undisturbed = module.clone();
        for request in &requests {
            acknowledged(&mut undisturbed, &[*request]);
            states.push(stored(&mut undisturbed));
        }
        for writes in 0.. {
            let mut module = module.clone();
            eeprom(&mut module).cut_after(writes);
            let done = acknowledged(&mut module, &requests);
            if done == requests.len() {
                assert!(writes > 15, "{writes}");
                break;
            }
            module.power_cycle();
            let found = stored(&mut module);
            assert!([&states[done], &states[done + 1]].contains(&&found), "{writes}");
            assert_eq!(module.ggp(Gp::DownloadMode), 0);
        }
    }
}

/// SCO 0, 255 copies one coordinate after the other: each is old or new, and those behind a new one are new.
#[test]
fn coordinates_that_are_copied_together() {
    let mut module = new(ModuleKind::Tmcm1311);
    module.ok(Command::SetCoordinate, 0, EEPROM, 0);
    for number in 1..=20 {
        module.ok(Command::SetCoordinate, number, 0, 100 + i32::from(number));
    }
    for writes in 0.. {
        let mut module = module.clone();
        eeprom(&mut module).cut_after(writes);
        if acknowledged(&mut module, &[op(Command::SetCoordinate, 0, EEPROM, 0)]) == 1 {
            assert!(writes > 80, "{writes}");
            return;
        }
        module.power_cycle();
        module.ok(Command::GetCoordinate, 0, EEPROM, 0);
        let coordinates: Vec<_> = (1..=20).map(|number| module.coordinate(number)).collect();
        let copied = coordinates.iter().take_while(|coordinate| **coordinate != 0).count();
        let expected = (1..=20).map(|number| if number <= copied { 100 + number as i32 } else { 0 });
        assert_eq!(coordinates, expected.collect::<Vec<_>>(), "{writes}");
    }
}

const SECRET: Request = sgp(7, VARIABLES, 0x5EC2E7);

/// A module with settings and a program that must not be read back.
fn protected(kind: ModuleKind, protection: i32) -> Module {
    let mut module = new(kind);
    for request in store_axis(4, 1234).into_iter().chain(store_variable(9, 99)) {
        module.request(request);
    }
    module.download(&[SECRET, STOP, SECRET]);
    module.sgp(Gp::CodeProtection, protection);
    module
}

/// The program is there and cannot be read, or it can be read and is gone. True when it is gone.
#[track_caller]
fn assert_secret(module: &mut Module) -> bool {
    if module.ggp(Gp::CodeProtection) & 1 != 0 {
        assert_eq!(module.status(Command::ReadProgramMemory, 0, 0, 0), Status::NotAvailable);
        return false;
    }
    for address in 0..4 {
        assert_eq!(module.read_instruction(address), STOP);
    }
    assert!(eeprom(module).program().is_empty());
    true
}

/// GP 81 from 1 or 3 to 0 or 2: it is erased as a whole before the protection goes (§10.1).
#[test]
fn a_protection_that_is_taken_off_never_gives_the_program_away() {
    for (kind, from, to) in [(ModuleKind::Tmcm1311, 1, 0), (ModuleKind::Tmcm1640, 3, 2)] {
        let module = protected(kind, from);
        let program = eeprom(&mut module.clone()).program();
        for writes in 0.. {
            let mut module = module.clone();
            eeprom(&mut module).cut_after(writes);
            if acknowledged(&mut module, &[sgp(81, 0, to)]) == 1 {
                assert!(assert_secret(&mut module) && writes > 30, "{writes}");
                break;
            }
            module.power_cycle();
            let found = eeprom(&mut module).program();
            assert!(found == program || found.is_empty(), "{writes}: half of it is left");
            assert_secret(&mut module);
            // It can be taken off again.
            module.sgp(Gp::CodeProtection, to);
            assert!(assert_secret(&mut module));
            assert_eq!(module.ok(Command::GetAxisParameter, 4, 0, 0), 1234, "{writes}");
        }
    }
}

/// 137 is cut, and so is the power-on after it: it has not begun, or it is completed at the next power-on.
#[test]
fn a_factory_reset_is_completed() {
    for kind in [ModuleKind::Tmcm1311, ModuleKind::Tmcm1640] {
        let begin = protected(kind, 1);
        let before = stored(&mut begin.clone());
        let magic = RecordKey::Global(0, 64).to_u16();
        let mut completed = 0;
        for (writes, later) in (0..).flat_map(|writes| (0..90).step_by(7).map(move |later| (writes, later))) {
            let mut module = begin.clone();
            eeprom(&mut module).cut_after(writes);
            module.exchange(&tmcl_wire::serial::encode_request(1, op(Command::FactoryReset, 0, 0, 1234)));
            let undisturbed = !eeprom(&mut module).is_cut();
            eeprom(&mut module).cut_after(later);
            module.power_cycle();
            if !eeprom(&mut module).is_cut() {
                assert_secret(&mut module);
            }
            eeprom(&mut module).cut_after(u64::MAX);
            module.power_cycle();
            let gone = assert_secret(&mut module);
            let found = stored(&mut module);
            if gone {
                assert!(found.records.is_empty() || found.records == BTreeMap::from([(magic, 228)]));
                completed += 1;
            } else {
                assert_eq!(found, before, "{writes}, {later}");
            }
            assert_eq!(module.ggp(Gp::EepromMagic), 228);
            if undisturbed {
                assert!(gone);
                break;
            }
        }
        assert!(completed > 50, "{completed}");
    }
}

/// A program that stores is cut like a host that does: nothing else is disturbed.
#[test]
fn a_program_that_counts_in_the_eeprom() {
    let mut module = new(ModuleKind::Tmcm1311);
    // Adds 1 to variable 0 and stores it, again and again.
    let store = op(Command::StoreGlobalParameter, 0, VARIABLES, 0);
    let count = [op(Command::GetGlobalParameter, 0, VARIABLES, 0), calc(kind::ADD, 1)];
    let keep = [op(Command::AccumulatorToGlobalParameter, 0, VARIABLES, 0), store];
    module.download(&program(&[&count, &keep, &[ja(0)]]));
    module.set_variable(1, 11);
    module.ok(Command::StoreGlobalParameter, 1, VARIABLES, 0);
    module.run_from(0);
    let mut last = 0;
    for writes in 0..200 {
        eeprom(&mut module).cut_after(writes);
        module.run_ms(20);
        assert!(eeprom(&mut module).is_cut(), "it stores all the time");
        module.power_cycle();
        let counted = module.variable(0);
        assert!(counted >= last, "{counted} after {last}");
        assert_eq!(module.variable(1), 11);
        last = counted;
        module.run_from(0);
    }
    assert!(last > 1000, "{last}");
}

/// The same by a bench file's event: the module falls silent, and `power` brings it back.
#[test]
fn a_bench_file_cuts_the_power() {
    let mut module = Module::on(
        "[[module]]\nkind = \"tmcm-1311\"\n[[event]]\nat = \"1ms\"\nset = { \"fault.eeprom_cut\" = 10 }\n\
         [[event]]\nat = \"3ms\"\nset = { power = \"on\" }\n",
    );
    module.run_ms(2);
    let requests: Vec<_> = [store_variable(7, 7), store_variable(8, 8)].concat();
    assert_eq!(acknowledged(&mut module, &requests), 3, "the tenth byte write is in the second record");
    assert_eq!(module.read("eeprom.writes"), 10.0);
    module.run_ms(2);
    assert_eq!((module.variable(7), module.variable(8)), (7, 0));
    module.set("fault.eeprom_cut", 1);
    module.set("fault.eeprom_cut", "none");
    assert_eq!(acknowledged(&mut module, &requests), 4);
}

/// What a host may do to a record.
fn request() -> impl Strategy<Value = Vec<Request>> {
    prop_oneof![
        (4..6_u8, 1..2000_i32).prop_map(|(number, value)| store_axis(number, value).to_vec()),
        (0..4_u8, any::<i32>()).prop_map(|(number, value)| store_variable(number, value).to_vec()),
        (0..2_i32).prop_map(|value| vec![sgp(77, 0, value)]),
        (1..4_u8, any::<i32>()).prop_map(|(number, value)| vec![op(
            Command::SetCoordinate,
            number,
            0,
            value
        )]),
        (0..4_i32, any::<i32>()).prop_map(|(address, value)| vec![
            op(Command::DownloadStart, 0, 0, address),
            sgp(7, VARIABLES, value),
            op(Command::DownloadEnd, 0, 0, 0),
        ]),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 50, ..ProptestConfig::default() })]

    /// Any requests, any cuts: what is stored is what was acknowledged, or what was under way as well.
    #[test]
    fn acknowledged_is_kept_and_no_other_record_is_disturbed(
        steps in prop::collection::vec((request(), prop::option::of(0..25_u64)), 1..40)
    ) {
        let mut module = new(ModuleKind::Tmcm1311);
        module.sgp(Gp::CoordinateStorage, 1);
        for (requests, cut) in steps {
            let mut undisturbed = module.clone();
            let old = stored(&mut module);
            acknowledged(&mut undisturbed, &requests);
            let new = stored(&mut undisturbed);
            eeprom(&mut module).cut_after(cut.unwrap_or(u64::MAX));
            let done = acknowledged(&mut module, &requests);
            let failed = eeprom(&mut module).is_cut();
            prop_assert!(failed || done == requests.len());
            eeprom(&mut module).cut_after(u64::MAX);
            module.power_cycle();
            let found = stored(&mut module);
            prop_assert!(found == new || (failed && found == old), "{:?} left {:?}", requests, found);
        }
    }
}
