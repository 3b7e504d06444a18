//! Every parameter of the tables (§6, §10): default, access letters, range, what it reads back, what survives power-off.

use crate::common::{Module, VARIABLES};
use tmcl_tables::tmcm_1311::SPEC;
use tmcl_tables::{Command, GlobalParameter, ParameterSpec, Status, ValueSet};

use Status::{InvalidValue, NotAvailable, Ok, WrongType};

/// A parameter with where it lives: the axis, or a bank.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Place {
    bank: Option<u8>,
    number: u8,
}

/// The commands on it: set, get, store, restore.
const AXIS: [Command; 4] = [
    Command::SetAxisParameter,
    Command::GetAxisParameter,
    Command::StoreAxisParameter,
    Command::RestoreAxisParameter,
];
const GLOBAL: [Command; 4] = [
    Command::SetGlobalParameter,
    Command::GetGlobalParameter,
    Command::StoreGlobalParameter,
    Command::RestoreGlobalParameter,
];

impl Place {
    const fn axis(number: u8) -> Self {
        Self { bank: None, number }
    }

    const fn global(parameter: GlobalParameter) -> Self {
        let (bank, number) = parameter.address();
        Self { bank: Some(bank), number }
    }

    fn commands(self) -> [Command; 4] {
        if self.bank.is_some() { GLOBAL } else { AXIS }
    }

    fn set(self, module: &mut Module, value: i32) -> Status {
        module.status(self.commands()[0], self.number, self.bank.unwrap_or(0), value)
    }

    fn get(self, module: &mut Module) -> (Status, i32) {
        let reply = module.send(self.commands()[1], self.number, self.bank.unwrap_or(0), 0);
        (reply.status, reply.value)
    }

    fn store(self, module: &mut Module) -> Status {
        module.status(self.commands()[2], self.number, self.bank.unwrap_or(0), 0)
    }

    fn restore(self, module: &mut Module) -> Status {
        module.status(self.commands()[3], self.number, self.bank.unwrap_or(0), 0)
    }
}

/// Every axis parameter, every global parameter of bank 0 and 3, every user variable.
fn parameters() -> impl Iterator<Item = (Place, &'static ParameterSpec)> {
    let axis = SPEC.axis_parameters.iter().map(|spec| (Place::axis(spec.number), spec));
    let globals = SPEC.global_parameters.iter().flat_map(|entry| {
        (entry.parameter.number..=entry.last)
            .map(|number| (Place { bank: Some(entry.bank), number }, &entry.parameter))
    });
    axis.chain(globals)
}

/// What reads otherwise than the table's default, and why.
const DEFAULT_EXCEPTIONS: &[(Place, &str)] = &[
    (Place::axis(27), "the coils carried the default current"),
    (Place::axis(150), "the coils carry the default current"),
    (Place::axis(151), "the coils carry the default current"),
    (Place::axis(152), "the coils carry the default current"),
    (Place::axis(154), "the coils draw their current from the supply"),
    (Place::axis(180), "the run current flows until axis parameter 214 has elapsed"),
    (
        Place::axis(208),
        "the driver's: bit 7 rises 65 ms after the last step, and 0 goes with a stallGuard2 reading of 0",
    ),
    (Place::global(GlobalParameter::TickTimer), "counts from power-on"),
    (Place::global(GlobalParameter::RandomNumber), "is random"),
];

/// Values in range that open loop refuses as not available: torque (§6, AP 14 and AP 128; decisions 5.13).
fn refused_in_open_loop(place: Place, value: i64) -> bool {
    match (place.bank, place.number) {
        (None, 14) => true,
        (None, 128) => value == 2,
        _ => false,
    }
}

/// What does not read back as written, and why.
const READ_BACK_EXCEPTIONS: &[(Place, &str)] = &[
    (Place::axis(3), "a reading: writes are accepted and change nothing"),
    (Place::axis(180), "a reading: writes are accepted and change nothing"),
    (
        Place::global(GlobalParameter::EepromLock),
        "takes 1234 and 4321, reads 1 and 0 (tested in settings.rs)",
    ),
    (Place::global(GlobalParameter::SuppressReply), "1 silences the reading (tested in settings.rs)"),
];

fn is_listed(list: &[(Place, &str)], place: Place) -> bool {
    list.iter().any(|(listed, _)| *listed == place)
}

/// After the reply to the setting, the module has a new address or expects a new host (decisions 2a.11).
fn follow(module: &mut Module, place: Place, value: i64) {
    if place == Place::global(GlobalParameter::SerialAddress) {
        module.address = value as u8;
    } else if place == Place::global(GlobalParameter::HostAddress) {
        module.host = value as u8;
    }
}

/// Both ends of each interval.
fn edges(set: &ValueSet) -> impl Iterator<Item = i64> {
    set.intervals.iter().flat_map(|(low, high)| [*low, *high])
}

/// The neighbours of the set: just outside the intervals, and between the steps.
fn just_outside(set: &ValueSet) -> impl Iterator<Item = i64> {
    let around = set.intervals.iter().flat_map(|(low, high)| [low - 1, low + 1, high - 1, high + 1]);
    around.filter(|value| !set.contains(*value))
}

#[test]
fn factory_defaults_are_read_after_power_on() {
    let mut module = Module::new();
    for wait_ms in [1, 3000] {
        module.run_ms(wait_ms);
        let mut others = Vec::new();
        for (place, spec) in parameters().filter(|(_, spec)| spec.access.read) {
            let (status, value) = place.get(&mut module);
            assert_eq!(status, Ok, "{place:?}");
            assert!(spec.range.contains(spec.from_wire(value)), "{place:?} {} reads {value}", spec.id);
            if value != spec.default_bits() && !is_listed(DEFAULT_EXCEPTIONS, place) {
                others.push((place, spec.id, value));
            }
        }
        assert_eq!(others, [], "after {wait_ms} ms");
    }
}

/// Decisions 5.7: 3 A RMS in 32 steps of axis parameter 6, halved by axis parameter 179; 15 reports what is allowed, 150 the
/// peak of what flows, of 151 and 152 (5.1), and 180 the step.
#[test]
fn the_coils_carry_the_current_of_axis_parameter_6() {
    let mut module = Module::new();
    for (current, half_scale) in [(128, 0), (255, 0), (0, 0), (7, 0), (8, 0), (200, 1), (255, 1)] {
        assert_eq!(Place::axis(6).set(&mut module, current), Ok);
        assert_eq!(Place::axis(179).set(&mut module, half_scale), Ok);
        module.run_ms(1);
        let steps = f64::from(current / 8 + 1);
        let rms_ma = 3000.0 * steps / 32.0 / f64::from(1 + half_scale);
        let [allowed, peak, a, b] =
            [15, 150, 151, 152].map(|number| f64::from(Place::axis(number).get(&mut module).1));
        assert!((allowed - rms_ma).abs() <= 1.0, "AP 15 = {allowed} mA for {rms_ma}");
        assert!(
            (peak - rms_ma * std::f64::consts::SQRT_2).abs() <= 2.0,
            "AP 150 = {peak} mA for {rms_ma} RMS"
        );
        assert!((peak - a.hypot(b)).abs() <= 1.5, "{peak} of {a} and {b}");
        assert_eq!(Place::axis(180).get(&mut module), (Ok, current / 8));
    }
}

#[test]
fn what_has_no_r_cannot_be_read_and_what_has_no_w_cannot_be_written() {
    for (place, spec) in parameters() {
        let mut module = Module::new();
        if !spec.access.read {
            assert_eq!(place.get(&mut module).0, WrongType, "{place:?} {}", spec.id);
        }
        if !spec.access.write {
            for value in edges(&spec.range).chain([0, 1234]) {
                assert_eq!(place.set(&mut module, spec.to_wire(value)), WrongType, "{place:?} {}", spec.id);
            }
        }
    }
}

#[test]
fn writes_are_accepted_up_to_the_edges_of_the_range_and_read_back() {
    for (place, spec) in parameters().filter(|(_, spec)| spec.access.write) {
        for value in edges(&spec.write_range).chain([spec.default]) {
            if !spec.write_range.contains(value) {
                continue; // the default of parameter 73 is a reading
            }
            let mut module = Module::new();
            let bits = spec.to_wire(value);
            if refused_in_open_loop(place, value) {
                assert_eq!(place.set(&mut module, bits), NotAvailable, "{place:?} {} = {value}", spec.id);
                continue;
            }
            assert_eq!(place.set(&mut module, bits), Ok, "{place:?} {} = {value}", spec.id);
            follow(&mut module, place, value);
            if spec.access.read && !is_listed(READ_BACK_EXCEPTIONS, place) {
                assert_eq!(place.get(&mut module), (Ok, bits), "{place:?} {} = {value}", spec.id);
            }
        }
    }
}

#[test]
fn writes_outside_the_range_are_refused_and_change_nothing() {
    for (place, spec) in parameters().filter(|(_, spec)| spec.access.write) {
        for value in just_outside(&spec.write_range) {
            let bits = spec.to_wire(value);
            // Torque outside its range is wrong in two ways at once.
            if spec.from_wire(bits) != value || place == Place::axis(14) {
                continue; // what 32 bits cannot say cannot be refused
            }
            let mut module = Module::new();
            let before = place.get(&mut module);
            assert_eq!(place.set(&mut module, bits), InvalidValue, "{place:?} {} = {value}", spec.id);
            if place != Place::global(GlobalParameter::RandomNumber) {
                assert_eq!(place.get(&mut module), before, "{place:?} {} = {value}", spec.id);
            }
        }
    }
}

#[test]
fn readings_that_are_printed_as_writable_ignore_what_is_written() {
    let mut module = Module::new();
    module.run_ms(3000);
    for place in [Place::axis(3), Place::axis(180)] {
        let before = place.get(&mut module);
        assert_eq!(place.set(&mut module, 17), Ok);
        assert_eq!(place.get(&mut module), before, "{place:?}");
        module.run_ms(1);
        assert_eq!(place.get(&mut module), before, "{place:?}");
    }
}

/// Decisions 2a.7: AP 198 is bit 2 of AP 201, seen from the other side.
#[test]
fn clear_on_null_is_bit_2_of_the_encoder_mode() {
    let mut module = Module::new();
    let (mirror, mode) = (Place::axis(198), Place::axis(201));
    for (mode_before, bit, mode_after) in [(0, 1, 4), (24, 1, 28), (28, 0, 24), (4, 0, 0), (4, 1, 4)] {
        assert_eq!(mode.set(&mut module, mode_before), Ok);
        assert_eq!(mirror.get(&mut module), (Ok, mode_before >> 2 & 1));
        assert_eq!(mirror.set(&mut module, bit), Ok);
        assert_eq!(mode.get(&mut module), (Ok, mode_after));
    }
}

/// Closed loop comes with a later issue: until then its switches keep what is written, and it is never ready.
/// A value to tell from the default, and one that does no harm on a module that stands.
fn another_value(place: Place, spec: &ParameterSpec) -> i64 {
    // Bit 0 would have the next power-on in ASCII; 16 sets up its echo only (§4.4.4).
    if place == Place::global(GlobalParameter::AsciiMode) {
        return 16;
    }
    let candidates = [spec.default + 1, spec.default + 4, spec.default - 1];
    let found = candidates.into_iter().chain(edges(&spec.write_range)).find(|value| {
        *value != spec.default
            && spec.write_range.contains(*value)
            && !refused_in_open_loop(place, *value)
            && *value != i64::from(i32::MIN)
    });
    found.expect("a parameter has more than one value")
}

/// §5.7.7, §5.7.8.
#[test]
fn axis_parameters_with_an_e_are_stored_and_restored() {
    for (place, spec) in parameters().filter(|(place, spec)| place.bank.is_none() && spec.access.store) {
        let mut module = Module::new();
        let default = spec.default_bits();
        let value = spec.to_wire(another_value(place, spec));
        assert_eq!(place.set(&mut module, value), Ok, "{}", spec.id);
        assert_eq!(place.store(&mut module), Ok, "STAP {}", spec.id);
        assert_eq!(place.set(&mut module, default), Ok, "{}", spec.id);
        assert_eq!(place.restore(&mut module), Ok, "RSAP {}", spec.id);
        assert_eq!(place.get(&mut module), (Ok, value), "RSAP {}", spec.id);
        assert_eq!(place.set(&mut module, default), Ok, "{}", spec.id);
        module.power_cycle();
        assert_eq!(place.get(&mut module), (Ok, value), "{} after power-on", spec.id);
    }
}

#[test]
fn axis_parameters_that_were_not_stored_are_back_at_their_defaults_after_power_on() {
    for (place, spec) in parameters().filter(|(place, spec)| place.bank.is_none() && spec.access.write) {
        let value = another_value_or_none(place, spec);
        let mut module = Module::new();
        let Some(value) = value else { continue };
        assert_eq!(place.set(&mut module, value), Ok, "{}", spec.id);
        if !spec.access.store {
            assert_eq!(place.store(&mut module), WrongType, "STAP {}", spec.id);
            assert_eq!(place.restore(&mut module), WrongType, "RSAP {}", spec.id);
        }
        module.power_cycle();
        module.run_ms(1);
        if spec.access.read && !is_listed(DEFAULT_EXCEPTIONS, place) {
            assert_eq!(place.get(&mut module), (Ok, spec.default_bits()), "{} after power-on", spec.id);
        }
    }
}

/// [`another_value`], where open loop accepts any.
fn another_value_or_none(place: Place, spec: &ParameterSpec) -> Option<i32> {
    (place != Place::axis(14)).then(|| spec.to_wire(another_value(place, spec)))
}

#[test]
fn axis_parameters_without_an_e_can_neither_be_stored_nor_restored() {
    let mut module = Module::new();
    for (place, spec) in parameters().filter(|(place, spec)| place.bank.is_none() && !spec.access.store) {
        assert_eq!(place.store(&mut module), WrongType, "STAP {}", spec.id);
        assert_eq!(place.restore(&mut module), WrongType, "RSAP {}", spec.id);
    }
}

/// "A single parameter that has been changed before can be reset by this instruction" (§5.7.8).
#[test]
fn restoring_what_was_never_stored_brings_the_factory_default_back() {
    let mut module = Module::new();
    for (place, spec) in parameters().filter(|(place, spec)| place.bank.is_none() && spec.access.store) {
        assert_eq!(place.set(&mut module, spec.to_wire(another_value(place, spec))), Ok, "{}", spec.id);
        assert_eq!(place.restore(&mut module), Ok, "RSAP {}", spec.id);
        assert_eq!(place.get(&mut module), (Ok, spec.default_bits()), "RSAP {}", spec.id);
    }
}

/// "An SGP command on such a parameter will always store it permanently and no extra STGP command is needed" (§10.1).
#[test]
fn global_parameters_of_bank_0_are_stored_by_setting_them() {
    let excluded = [GlobalParameter::EepromMagic, GlobalParameter::EepromLock].map(Place::global);
    for (place, spec) in parameters().filter(|(place, spec)| place.bank == Some(0) && spec.access.store) {
        if excluded.contains(&place) {
            continue; // both have tests of their own in settings.rs
        }
        let mut module = Module::new();
        let value = another_value(place, spec);
        assert_eq!(place.set(&mut module, spec.to_wire(value)), Ok, "{}", spec.id);
        follow(&mut module, place, value);
        // Accepted, but there is nothing more to do (decisions 2a.9).
        assert_eq!(place.store(&mut module), Ok, "STGP {}", spec.id);
        assert_eq!(place.restore(&mut module), Ok, "RSGP {}", spec.id);
        assert_eq!(place.get(&mut module), (Ok, spec.to_wire(value)), "{}", spec.id);
        module.power_cycle();
        assert_eq!(place.get(&mut module), (Ok, spec.to_wire(value)), "{} after power-on", spec.id);
    }
}

#[test]
fn settings_without_an_e_are_volatile() {
    let silence = Place::global(GlobalParameter::SuppressReply);
    for (place, spec) in parameters().filter(|(place, _)| place.bank == Some(3) || *place == silence) {
        let mut module = Module::new();
        let value = spec.to_wire(another_value(place, spec));
        assert_eq!(place.set(&mut module, value), Ok, "{}", spec.id);
        module.power_cycle();
        assert_eq!(place.get(&mut module), (Ok, spec.default_bits()), "{} after power-on", spec.id);
    }
}

#[test]
fn interrupt_parameters_cannot_be_stored() {
    let mut module = Module::new();
    for (place, spec) in parameters().filter(|(place, _)| place.bank == Some(3)) {
        assert_eq!(place.store(&mut module), WrongType, "STGP {}", spec.id);
        assert_eq!(place.restore(&mut module), WrongType, "RSGP {}", spec.id);
    }
}

/// §10.3: 56 variables can be stored, all 256 can be used; §5.7.11: storing takes an STGP.
#[test]
fn user_variables_0_to_55_are_stored_on_demand_and_the_others_never() {
    let mut module = Module::new();
    let place = |number| Place { bank: Some(VARIABLES), number };
    let value = |number: u8| i32::from(number) * 1_000_003 - 77_777_777;
    for number in 0..=255 {
        assert_eq!(place(number).set(&mut module, value(number)), Ok);
    }
    for number in 0..=255 {
        assert_eq!(place(number).get(&mut module), (Ok, value(number)), "each has a place of its own");
    }
    for number in 0..=255 {
        let expected = if number < 56 { Ok } else { WrongType };
        if number % 2 == 0 {
            assert_eq!(place(number).store(&mut module), expected, "STGP {number}, 2");
        }
        if number >= 56 {
            assert_eq!(place(number).restore(&mut module), expected, "RSGP {number}, 2");
        }
    }
    for number in (0..56).step_by(2) {
        assert_eq!(place(number).set(&mut module, -1), Ok);
        assert_eq!(place(number).restore(&mut module), Ok);
        assert_eq!(place(number).get(&mut module), (Ok, value(number)), "RSGP {number}, 2");
    }
    module.power_cycle();
    for number in 0..=255 {
        let expected = if number < 56 && number % 2 == 0 { value(number) } else { 0 };
        assert_eq!(place(number).get(&mut module), (Ok, expected), "variable {number} after power-on");
    }
}
