//! Settings by name.

use super::super::{
    BenchConfig, Coil, Contact, EncoderLine, HallSensor, Part, Phase, Power, SETTINGS, Setting, SettingError,
    SwitchName, parse_setting,
};
use super::bench;

fn single() -> BenchConfig {
    bench(
        "[[module]]\nkind = \"tmcm-1311\"\n[module.switches]\nleft.at_turns = -1\nright.at_turns = 1\nhome.at_turns = 0\n",
    )
}

fn brushless() -> BenchConfig {
    bench(
        "[[module]]\nkind = \"tmcm-1640\"\n[module.switches]\nleft.at_turns = -1\n[[module]]\nkind = \"tmcm-1640\"\n",
    )
}

fn pair() -> BenchConfig {
    bench(
        "[[module]]\nkind = \"tmcm-1311\"\n[[module]]\nkind = \"tmcm-1311\"\n\
         [[wire]]\nfrom = \"m1.output.0\"\nto = \"m2.input.1\"\n",
    )
}

fn set(name: &str, value: &str) -> Setting {
    let settings = parse_setting(&single(), name, value.into()).expect("a setting");
    assert_eq!(settings.len(), 1);
    assert_eq!(settings[0].0, 0);
    settings[0].1.clone()
}

fn refused(bench: &BenchConfig, name: &str, value: &str) -> SettingError {
    parse_setting(bench, name, value.into()).expect_err("refused")
}

#[test]
fn every_setting_is_understood() {
    let cases = [
        ("load.torque_nm", "-0.4", Setting::LoadTorqueNm(-0.4)),
        ("load.inertia_kgm2", "1e-4", Setting::LoadInertiaKgm2(1e-4)),
        ("load.friction_nm", "0", Setting::LoadFrictionNm(0.0)),
        ("input.2", "1", Setting::Input { number: 2, high: true }),
        ("ain.4", "2048", Setting::AnalogInput { number: 4, reading: 2048 }),
        ("step_dir.frequency_hz", "-51200.5", Setting::StepFrequencyHz(-51_200.5)),
        ("step_dir.acceleration_hz_per_s", "1000", Setting::StepAccelerationHzPerS(1000.0)),
        ("step_dir.pulses", "51200", Setting::StepPulses(Some(51_200))),
        ("step_dir.enable", "1", Setting::StepEnable(true)),
        ("supply.voltage_v", "24", Setting::SupplyVoltageV(24.0)),
        ("temperature_c", "-20", Setting::AmbientC(-20.0)),
        ("fault.encoder_line", "index", Setting::EncoderLine(Some(EncoderLine::Index))),
        ("fault.coil_open", "a", Setting::CoilOpen(Some(Coil::A))),
        ("fault.coil_short", "none", Setting::CoilShort(None)),
        (
            "fault.switch_left",
            "open",
            Setting::SwitchContact { switch: SwitchName::Left, stuck: Some(Contact::Open) },
        ),
        ("fault.switch_right", "none", Setting::SwitchContact { switch: SwitchName::Right, stuck: None }),
        (
            "fault.switch_home",
            "closed",
            Setting::SwitchContact { switch: SwitchName::Home, stuck: Some(Contact::Closed) },
        ),
        ("fault.board_temperature_c", "110", Setting::BoardTemperatureC(Some(110.0))),
        ("fault.dropped_steps", "-4", Setting::DroppedSteps(-4)),
        ("fault.eeprom_cut", "12", Setting::EepromCut(Some(12))),
        ("power", "cycle", Setting::Power(Power::Cycle)),
    ];
    let listed = SETTINGS.into_iter().filter(|name| !BRUSHLESS_FAULTS.contains(name));
    assert_eq!(cases.len(), listed.clone().count());
    for ((name, value, expected), listed) in cases.into_iter().zip(listed) {
        assert_eq!(name.split('.').next(), listed.split('.').next());
        assert_eq!(set(name, value), expected, "{name}");
        assert_eq!(set(&format!("m1.{name}"), value), expected, "m1.{name}");
    }
    assert_eq!(set("fault.board_temperature_c", "none"), Setting::BoardTemperatureC(None));
    assert_eq!(set("step_dir.pulses", "endless"), Setting::StepPulses(None));
    assert_eq!(set("fault.eeprom_cut", "none"), Setting::EepromCut(None));
}

/// What can break around a brushless motor only.
const BRUSHLESS_FAULTS: [&str; 5] =
    ["fault.phase_open", "fault.phase_short", "fault.hall_1", "fault.hall_2", "fault.hall_3"];

#[test]
fn every_fault_of_a_brushless_motor_is_understood() {
    let hall = |sensor, stuck| Setting::HallLine { sensor, stuck };
    let cases = [
        ("fault.phase_open", "u", Setting::PhaseOpen(Some(Phase::U))),
        ("fault.phase_open", "v", Setting::PhaseOpen(Some(Phase::V))),
        ("fault.phase_short", "w", Setting::PhaseShort(Some(Phase::W))),
        ("fault.phase_short", "none", Setting::PhaseShort(None)),
        ("fault.hall_1", "low", hall(HallSensor::H1, Some(false))),
        ("fault.hall_2", "high", hall(HallSensor::H2, Some(true))),
        ("fault.hall_3", "none", hall(HallSensor::H3, None)),
    ];
    for (name, value, expected) in cases {
        assert!(SETTINGS.contains(&name) && BRUSHLESS_FAULTS.contains(&name));
        let settings = parse_setting(&brushless(), &format!("m2.{name}"), value.into());
        assert_eq!(settings, Ok(vec![(1, expected)]), "{name} = {value}");
    }
    let error = refused(&brushless(), "m1.fault.hall_1", "open");
    assert_eq!((error.part, error.message.as_str()), (Part::Value, "fault.hall_1 cannot be \"open\""));
    assert_eq!(error.help.as_deref(), Some("allowed here: none, low, high"));
}

#[test]
fn what_a_module_does_not_have_cannot_be_set() {
    let cases = [
        ("m1.fault.coil_open", "fault.coil_open is a fault of a stepper, which m1 does not drive"),
        ("m1.fault.dropped_steps", "fault.dropped_steps is a fault of a stepper, which m1 does not drive"),
        ("m1.step_dir.enable", "m1 has no step/direction connector"),
        ("m1.fault.switch_home", "fault.switch_home cannot be 1"),
        ("m1.fault.hall_4", "nothing called \"fault.hall_4\" can be set"),
        ("m1.input.2", "m1 has no input.2 to set"),
        ("m1.input.1", "input.1 of m1 is driven by its left switch"),
    ];
    for (name, message) in cases {
        assert_eq!(refused(&brushless(), name, "1").message, message, "{name}");
    }
    assert_eq!(refused(&brushless(), "m1.fault.switch_home", "open").message, "m1 has no home switch");
    assert!(parse_setting(&brushless(), "m1.input.0", "1".into()).is_ok());
    assert!(parse_setting(&brushless(), "m2.input.1", "1".into()).is_ok());
    for name in BRUSHLESS_FAULTS {
        let message = format!("{name} is a fault of a brushless motor, which m1 does not drive");
        assert_eq!(refused(&single(), name, "none").message, message);
    }
    let help = refused(&brushless(), "m1.fault.hall_4", "low").help.expect("help");
    assert!(help.starts_with("did you mean \"fault.hall_1\"?") || help.contains("fault.hall_3"), "{help}");
    assert!(!help.contains("coil") && !help.contains("step_dir"), "{help}");
}

#[test]
fn with_several_modules_a_name_says_which() {
    let bench = pair();
    assert_eq!(
        parse_setting(&bench, "m2.load.torque_nm", "1".into()),
        Ok(vec![(1, Setting::LoadTorqueNm(1.0))])
    );
    let both = [0, 1].map(|module| (module, Setting::SupplyVoltageV(12.0)));
    assert_eq!(parse_setting(&bench, "supply.voltage_v", "12".into()), Ok(both.to_vec()));
    assert_eq!(
        parse_setting(&bench, "m1.temperature_c", "60".into()),
        Ok(vec![(0, Setting::AmbientC(60.0))])
    );
    let error = refused(&bench, "load.torque_nm", "1");
    assert_eq!(error.message, "load.torque_nm must say of which module");
    assert_eq!(error.help.as_deref(), Some("for example m1.load.torque_nm; modules: m1, m2"));
    assert_eq!(refused(&bench, "m3.load.torque_nm", "1").message, "there is no module \"m3\"");
    assert_eq!(refused(&bench, "m1", "1").message, "nothing called \"\" can be set");
    assert_eq!(refused(&bench, "nonsense", "1").message, "nothing called \"nonsense\" can be set");
}

#[test]
fn what_drives_a_pin_already_is_named() {
    assert_eq!(refused(&pair(), "m2.input.1", "1").message, "input.1 of m2 is driven by a wire");
    assert!(parse_setting(&pair(), "m1.input.1", "1".into()).is_ok());
    assert_eq!(refused(&single(), "input.1", "1").message, "input.1 of m1 is driven by its home switch");
    assert_eq!(refused(&pair(), "m1.fault.switch_left", "open").message, "m1 has no left switch");
}

#[test]
fn values_must_fit() {
    let bench = single();
    let cases = [
        ("load.torque_nm", "heavy", "load.torque_nm must be a number, not \"heavy\""),
        ("load.torque_nm", "nan", "load.torque_nm must be from -100 to 100 Nm, not NaN"),
        ("load.inertia_kgm2", "-1", "load.inertia_kgm2 must be from 0 to 10 kgm², not -1"),
        ("input.2", "2", "input.2 must be a whole number from 0 to 1, not 2"),
        ("input.2", "0.5", "input.2 must be a whole number from 0 to 1, not 0.5"),
        ("ain.0", "inf", "ain.0 must be a whole number from 0 to 4095, not inf"),
        ("ain.0", "full", "ain.0 must be a whole number from 0 to 4095, not \"full\""),
        ("fault.coil_open", "c", "fault.coil_open cannot be \"c\""),
        ("fault.coil_open", "1", "fault.coil_open cannot be 1"),
        ("fault.board_temperature_c", "hot", "fault.board_temperature_c must be a number or \"none\""),
        (
            "fault.dropped_steps",
            "1e12",
            "fault.dropped_steps must be a whole number from -1000000 to 1000000, not 1000000000000",
        ),
        ("power", "toggle", "power cannot be \"toggle\""),
        (
            "step_dir.frequency_hz",
            "1000001",
            "step_dir.frequency_hz must be from -1000000 to 1000000 Hz, not 1000001",
        ),
        (
            "step_dir.frequency_hz",
            "nan",
            "step_dir.frequency_hz must be from -1000000 to 1000000 Hz, not NaN",
        ),
        ("step_dir.pulses", "-1", "step_dir.pulses must be a whole number from 0 to 4294967295, not -1"),
        (
            "step_dir.pulses",
            "none",
            "step_dir.pulses must be a whole number from 0 to 4294967295, not \"none\"",
        ),
        ("step_dir.enable", "2", "step_dir.enable must be a whole number from 0 to 1, not 2"),
    ];
    for (name, value, message) in cases {
        let error = refused(&bench, name, value);
        assert_eq!((error.part, error.message.as_str()), (Part::Value, message), "{name} = {value}");
    }
}

#[test]
fn names_must_exist() {
    let bench = single();
    for name in [
        "",
        "load",
        "load.",
        "load.torqe_nm",
        "fault.x",
        "step_dir",
        "step_dir.frequency",
        "input.0",
        "input.01",
        "ain.1",
        "output.0",
        "m1.m1.power",
    ] {
        assert_eq!(refused(&bench, name, "1").part, Part::Name, "{name}");
    }
    let help = refused(&bench, "load.torque", "1").help.expect("help");
    assert!(help.starts_with("did you mean \"load.torque_nm\"?"), "{help}");
}
