//! What is stored survives the module itself: another one that gets the image of its EEPROM goes on with it (TMCM-1311 §5.7.7,
//! §5.7.9, §5.7.11, §5.7.24 to §5.7.27, §10.1; TMCM-1640 §4.6.7, §6.1).

use crate::common::program::*;
use crate::common::{EEPROM, MODULE, Module, VARIABLES};
use tmcl_tables::{Access, Command, GlobalParameter as Gp, ParameterSpec};
use virtual_bench::{Bench, BenchConfig, Eeprom, ModuleKind, RecordKey};

/// The modules that have programs and global parameters.
const BOTH: [ModuleKind; 2] = [ModuleKind::Tmcm1311, ModuleKind::Tmcm1640];

fn new(kind: ModuleKind) -> Module {
    Module::with_image(kind, &Eeprom::new(kind).to_image())
}

/// The module with this one's image, after it has vanished.
#[track_caller]
fn again(kind: ModuleKind, module: &Module) -> Module {
    let image = module.image();
    let again = Module::with_image(kind, &image);
    assert_eq!(again.image(), image, "to be switched on writes nothing");
    again
}

/// A value that can be stored and is not the default.
fn another(spec: &ParameterSpec) -> Option<i64> {
    let candidates = [spec.default + 1, spec.default - 1, spec.default + spec.range.step, 1, 0, 2];
    candidates.into_iter().find(|value| {
        *value != spec.default && spec.range.contains(*value) && spec.write_range.contains(*value)
    })
}

fn is_stored(access: Access) -> bool {
    access.read && access.write && access.store
}

/// STAP: every axis parameter with an E that takes another value.
#[test]
fn axis_parameters() {
    for kind in BOTH {
        let mut stored = 0;
        for spec in kind.spec().axis_parameters.iter().filter(|spec| is_stored(spec.access)) {
            let mut module = new(kind);
            let Some(value) = another(spec) else { continue };
            let value = i32::try_from(value).expect("32 bits");
            let set = module.status(Command::SetAxisParameter, spec.number, 0, value);
            if set != tmcl_tables::Status::Ok {
                continue;
            }
            let held = module.ok(Command::GetAxisParameter, spec.number, 0, 0);
            let mut forgetful = again(kind, &module);
            module.ok(Command::StoreAxisParameter, spec.number, 0, 0);
            let mut module = again(kind, &module);
            let is = module.ok(Command::GetAxisParameter, spec.number, 0, 0);
            assert_eq!(is, held, "{kind:?} {}", spec.id);
            if is != forgetful.ok(Command::GetAxisParameter, spec.number, 0, 0) {
                stored += 1;
            }
            let record = module.bench.eeprom(MODULE).expect("an EEPROM").records().next();
            assert_eq!(record, Some((RecordKey::Axis(spec.number), held)), "{kind:?} {}", spec.id);
        }
        assert!(stored > 15, "{kind:?}: {stored}");
    }
}

/// RSAP reads what another process stored.
#[test]
fn restoring_an_axis_parameter() {
    for kind in BOTH {
        let mut module = new(kind);
        module.ok(Command::SetAxisParameter, 4, 0, 1234);
        module.ok(Command::StoreAxisParameter, 4, 0, 0);
        let mut module = again(kind, &module);
        module.ok(Command::SetAxisParameter, 4, 0, 999);
        module.ok(Command::RestoreAxisParameter, 4, 0, 0);
        assert_eq!(module.ok(Command::GetAxisParameter, 4, 0, 0), 1234, "{kind:?}");
    }
}

/// SGP in bank 0 stores at once; the lock (73) comes back as 1, and does not let go (decisions 2a.10).
#[test]
fn global_parameters() {
    for kind in BOTH {
        let spec = kind.spec();
        let bank_0 = spec.global_parameters.iter().filter(|entry| entry.bank == 0);
        for entry in bank_0.filter(|entry| is_stored(entry.parameter.access)) {
            let number = entry.parameter.number;
            // The addresses say where the host has to look, 67 makes the port speak ASCII, and 64 forgets everything.
            if [64, 66, 67, 73, 76].contains(&number) {
                continue;
            }
            let Some(value) = another(&entry.parameter) else { continue };
            let value = i32::try_from(value).expect("32 bits");
            let mut module = new(kind);
            module.ok(Command::SetGlobalParameter, number, 0, value);
            let mut module = again(kind, &module);
            let is = module.ok(Command::GetGlobalParameter, number, 0, 0);
            assert_eq!(is, value, "{kind:?} {}", entry.parameter.id);
        }
        let mut module = new(kind);
        module.sgp(Gp::SerialAddress, 7);
        module.address = 7;
        module.sgp(Gp::HostAddress, 9);
        module.host = 9;
        module.sgp(Gp::EepromLock, 1234);
        let mut module = again(kind, &module);
        (module.address, module.host) = (7, 9);
        assert_eq!((module.ggp(Gp::EepromLock), module.ggp(Gp::EepromMagic)), (1, 228));
        module.unanswered(Command::FactoryReset, 0, 0, 1234);
        assert_eq!(module.ggp(Gp::SerialAddress), 7, "locked");
    }
}

/// STGP and RSGP; GP 85 lets them start at 0, and RSGP bring them back (§10.1).
#[test]
fn user_variables() {
    for kind in BOTH {
        let mut module = new(kind);
        for (number, value) in [(0, i32::MIN), (55, i32::MAX), (7, -1)] {
            module.set_variable(number, value);
            module.ok(Command::StoreGlobalParameter, number, VARIABLES, 0);
        }
        module.set_variable(8, 8);
        let mut module = again(kind, &module);
        assert_eq!([0, 7, 8, 55].map(|number| module.variable(number)), [i32::MIN, -1, 0, i32::MAX]);
        module.sgp(Gp::DoNotRestoreVariables, 1);
        let mut module = again(kind, &module);
        assert_eq!([0, 7, 55].map(|number| module.variable(number)), [0; 3]);
        module.ok(Command::RestoreGlobalParameter, 55, VARIABLES, 0);
        assert_eq!(module.variable(55), i32::MAX);
    }
}

/// SCO n, 255 and GP 84 (§5.7.24, §5.7.25); the TMCM-1640 has no coordinates.
#[test]
fn coordinates() {
    let kind = ModuleKind::Tmcm1311;
    let mut module = new(kind);
    for number in 0..=20 {
        module.ok(Command::SetCoordinate, number, 0, i32::from(number) * 1000);
    }
    module.ok(Command::SetCoordinate, 0, EEPROM, 0);
    let mut module = again(kind, &module);
    assert_eq!(module.coordinate(20), 0, "GP 84 is 0");
    module.ok(Command::GetCoordinate, 0, EEPROM, 0);
    assert_eq!([0, 1, 20].map(|number| module.coordinate(number)), [0, 1000, 20_000]);
    module.sgp(Gp::CoordinateStorage, 1);
    module.ok(Command::SetCoordinate, 5, 0, -5);
    let mut module = again(kind, &module);
    assert_eq!([0, 1, 5, 20].map(|number| module.coordinate(number)), [0, 1000, -5, 20_000]);
}

/// A program, its protection (81) and its start at power-on (77).
#[test]
fn programs() {
    for kind in BOTH {
        let mut module = new(kind);
        module.download(&[sgp(7, VARIABLES, 77), STOP]);
        module.download_at(2047, &[sgp(8, VARIABLES, 88)]);
        let mut module = again(kind, &module);
        assert_eq!(module.read_instruction(0), sgp(7, VARIABLES, 77));
        assert_eq!(module.read_instruction(2046), STOP, "never written");
        assert_eq!(module.read_instruction(2047), sgp(8, VARIABLES, 88));
        module.sgp(Gp::CodeProtection, 3);
        module.sgp(Gp::AutoStart, 1);
        let mut module = again(kind, &module);
        module.run_ms(1);
        assert_eq!(module.variable(7), 77, "{kind:?}");
        assert_eq!(
            module.status(Command::ReadProgramMemory, 0, 0, 0),
            tmcl_tables::Status::NotAvailable,
            "{kind:?}"
        );
        module.sgp(Gp::CodeProtection, 0);
        let mut module = again(kind, &module);
        assert_eq!(module.read_instruction(0), STOP);
        assert_eq!(module.read_instruction(2047), STOP);
    }
}

/// 137, and GP 64 whose effect waits for a power-on that another process brings (§5.7.39, §10.1).
#[test]
fn factory_settings() {
    for kind in BOTH {
        for by_magic in [false, true] {
            let mut module = new(kind);
            module.ok(Command::SetAxisParameter, 4, 0, 1234);
            module.ok(Command::StoreAxisParameter, 4, 0, 0);
            module.download(&[sgp(7, VARIABLES, 77), STOP]);
            if by_magic {
                module.sgp(Gp::EepromMagic, 5);
                assert_eq!(module.ok(Command::GetAxisParameter, 4, 0, 0), 1234);
            } else {
                module.unanswered(Command::FactoryReset, 0, 0, 1234);
            }
            let mut module = Module::with_image(kind, &module.image());
            let spec = kind.spec().axis_parameter(4).expect("a parameter");
            assert_eq!(module.ok(Command::GetAxisParameter, 4, 0, 0), spec.default_bits());
            assert_eq!(module.ggp(Gp::EepromMagic), 228);
            assert_eq!(module.read_instruction(0), sgp(7, VARIABLES, 77), "it was not protected");
        }
    }
}

/// An address that the bench gives beats the stored one, and is written only where it differs.
#[test]
fn an_address_of_the_bench_wears_nothing_the_second_time() {
    for kind in BOTH {
        let mut config = BenchConfig::default_for(kind);
        let mut eeprom = Eeprom::new(kind);
        let mut writes = Vec::new();
        for address in [1, 5, 5, 1, 1] {
            config.modules[0].address = Some(address);
            let bench = Bench::with_eeproms(&config, |_| Some(eeprom.clone()));
            let read = bench.read(bench.probe("serial_address").expect("a probe"));
            assert_eq!(read, f64::from(address));
            eeprom = bench.eeprom(MODULE).expect("an EEPROM").clone();
            writes.push(eeprom.writes());
            assert_eq!(bench.read(bench.probe("eeprom.writes").expect("a probe")), eeprom.writes() as f64);
        }
        assert_eq!(writes[0], 0, "the factory's address is 1");
        assert!(writes[1] > 0 && writes[1] == writes[2] && writes[3] == writes[4], "{writes:?}");
        // One that stands while the settings are to be forgotten is not forgotten with them.
        let mut module = Module::with_image(kind, &eeprom.to_image());
        module.sgp(Gp::EepromMagic, 0);
        config.modules[0].address = Some(9);
        let image = module.image();
        let bench = Bench::with_eeproms(&config, |_| Eeprom::from_image(&image).ok());
        assert_eq!(bench.read(bench.probe("serial_address").expect("a probe")), 9.0);
    }
}

/// An EEPROM of the other module is no use.
#[test]
fn another_modules_eeprom_is_left_out() {
    let mut module = new(ModuleKind::Tmcm1311);
    module.set_variable(7, 77);
    module.ok(Command::StoreGlobalParameter, 7, VARIABLES, 0);
    let mut other = Module::with_image(ModuleKind::Tmcm1640, &module.image());
    assert_eq!(other.variable(7), 0);
    assert_eq!(other.image(), Eeprom::new(ModuleKind::Tmcm1640).to_image());
}
