//! What a right file means.

use motor_physics::load::{LoadTorque, Profile};
use motor_physics::supply::SupplyParameters;
use motor_physics::switch::SwitchConfig;

use super::super::{
    BenchConfig, Coil, EncoderConfig, Event, HallsConfig, MotorConfig, Setting, StepDirConfig, Wire, WireEnd,
};
use super::bench;
use crate::ModuleKind;

const MODULE: &str = "[[module]]\nkind = \"tmcm-1311\"\n";

#[test]
fn a_module_and_nothing_else_is_the_default_bench() {
    let default = BenchConfig::default_for(ModuleKind::Tmcm1311);
    assert_eq!(bench(MODULE), default);
    let module = &default.modules[0];
    assert_eq!(module.motor, MotorConfig::Preset("QSH5718-51-28-101"));
    assert_eq!(module.encoder.counts, 40_000);
    let supply = SupplyParameters { voltage_v: 48.0, source_resistance_ohm: 0.1, capacitance_f: 2200e-6 };
    assert_eq!(module.supply, supply);
    assert_eq!(module.load.inertia_kgm2, 0.0);
}

#[test]
fn the_default_bench_of_a_module_for_brushless_motors() {
    let default = BenchConfig::default_for(ModuleKind::Tmcm1640);
    assert_eq!(bench("[[module]]\nkind = \"tmcm-1640\"\n[module.halls]\n"), default);
    let module = &default.modules[0];
    assert_eq!(module.motor, MotorConfig::Preset("QBL4208-61-04-013"));
    assert_eq!((module.encoder.counts, module.supply.voltage_v), (4096, 24.0));
    assert_eq!(module.halls, HallsConfig { offset_deg: 0.0, inverted: false });
}

#[test]
fn a_brushless_motor_by_its_figures_and_its_hall_sensors() {
    let bench = bench(
        "[[module]]\nkind = \"1640\"\n[module.motor]\npole_pairs = 4\ntorque_constant_nm_per_a = 0.036\n\
         line_resistance_ohm = 0.72\nline_inductance_h = 1.2e-3\nrated_current_a = 3.47\nrotor_inertia_kgm2 = 4.8e-6\n\
         [module.halls]\noffset_deg = -30\ninverted = true\n",
    );
    let module = &bench.modules[0];
    let motor = module.motor.brushless().expect("a brushless motor");
    let preset = motor_physics::presets::pmsm("QBL4208-61-04-013").expect("a preset");
    assert_eq!((motor.pole_pairs, motor.resistance_ohm), (preset.pole_pairs, preset.resistance_ohm));
    assert_eq!((motor.d_inductance_h, motor.q_inductance_h), (preset.d_inductance_h, preset.q_inductance_h));
    assert_eq!(motor.flux_linkage_wb, preset.flux_linkage_wb);
    assert_eq!(motor.winding_time_constant_s, preset.winding_time_constant_s);
    assert!((motor.rated_velocity_rad_s / preset.rated_velocity_rad_s - 1.0).abs() < 0.5);
    assert_eq!(module.motor.stepper(), None);
    assert_eq!(module.halls, HallsConfig { offset_deg: -30.0, inverted: true });
}

/// Empty sections say nothing either.
#[test]
fn empty_sections_change_nothing() {
    let sections = "[module.supply]\n[module.load]\n[module.encoder]\n[module.switches]\n[module.inputs]\n\
         [module.step_dir]\n[supply]\n";
    assert_eq!(bench(&format!("{MODULE}{sections}")), BenchConfig::default_for(ModuleKind::Tmcm1311));
}

#[test]
fn modules_take_the_figures_of_the_bench_unless_they_have_their_own() {
    let bench = bench(
        "temperature_c = 40\n[supply]\nvoltage_v = 24\ncapacitance_f = 1e-3\n\
         [[module]]\nkind = \"1311\"\n[module.supply]\nvoltage_v = 36.5\n\
         [[module]]\nkind = \"TMCM-1311\"\naddress = 7\ntemperature_c = -10\n",
    );
    let supplies = [36.5, 24.0].map(|voltage_v| SupplyParameters {
        voltage_v,
        source_resistance_ohm: 0.1,
        capacitance_f: 1e-3,
    });
    let [first, second] = bench.modules.as_slice() else { panic!("two modules") };
    assert_eq!([first.supply, second.supply], supplies);
    assert_eq!([first.temperature_c, second.temperature_c], [40.0, -10.0]);
    assert_eq!([first.address, second.address], [None, Some(7)]);
    assert_eq!([first.name.as_str(), second.name.as_str()], ["m1", "m2"]);
}

#[test]
fn a_motor_by_its_figures() {
    let bench = bench(&format!(
        "{MODULE}[module.motor]\nrated_current_a = 2.0\nresistance_ohm = 1.5\ninductance_h = 4e-3\n\
         holding_torque_nm = 0.8\nrotor_inertia_kgm2 = 2e-5\nfull_steps = 400\n"
    ));
    let motor = bench.modules[0].motor.stepper().expect("a stepper");
    assert_eq!((motor.rated_current_rms_a, motor.resistance_ohm, motor.inductance_h), (2.0, 1.5, 4e-3));
    assert_eq!((motor.holding_torque_nm, motor.detent_torque_nm, motor.rotor_inertia_kgm2), (0.8, 0.0, 2e-5));
    assert_eq!(motor.pole_pairs, 100.0);
}

#[test]
fn a_pulse_source() {
    let step_dir =
        |lines: &str| bench(&format!("{MODULE}[module.step_dir]\n{lines}")).modules[0].step_dir.clone();
    let given = StepDirConfig {
        frequency_hz: -1000.5,
        acceleration_hz_per_s: 2000.0,
        pulses: Some(51_200),
        enabled: true,
        edges: Vec::new(),
    };
    assert_eq!(
        step_dir("frequency_hz = -1000.5\nacceleration_hz_per_s = 2000\npulses = 51200\nenable = 1\n"),
        given
    );
    let silent = StepDirConfig::default();
    assert_eq!(step_dir("enable = 0\n"), silent);
    assert_eq!(step_dir("pulses = 0\n").pulses, Some(0));
}

#[test]
fn a_preset_in_any_case() {
    let bench = bench(&format!("{MODULE}[module.motor]\npreset = \"qsh4218-35-10-027\"\n"));
    assert_eq!(bench.modules[0].motor, MotorConfig::Preset("QSH4218-35-10-027"));
    assert_eq!(bench.modules[0].motor.stepper().map(|motor| motor.resistance_ohm), Some(5.3));
}

#[test]
fn torque_profiles() {
    let profile =
        |line: &str| bench(&format!("{MODULE}[module.load]\n{line}\n")).modules[0].load.torque.clone();
    let cam = Profile::new(&[(0.0, 0.1), (0.5, -0.2), (1.0, 0.1)], Some(1.0)).expect("a profile");
    let line = "torque = { by = \"position\", points = [[0, 0.1], [0.5, -0.2], [1, 0.1]], period = 1.0 }";
    assert_eq!(profile(line), LoadTorque::ByPosition(cam));
    let ramp = Profile::new(&[(1.0, 0.0), (2.0, 0.4)], None).expect("a profile");
    assert_eq!(profile("torque = { by = \"time\", points = [[1, 0], [2, 0.4]] }"), LoadTorque::ByTime(ramp));
    assert_eq!(profile("torque_nm = -1"), LoadTorque::Constant(-1.0));
}

#[test]
fn switches_are_pressed_on_their_side_or_within_their_window() {
    let bench = bench(&format!(
        "{MODULE}[module.switches]\nleft.at_turns = -2\nright = {{ at_turns = 5, side = \"below\", bounce_ms = 0.5 }}\n\
         home.at_turns = 1\n"
    ));
    let switches = &bench.modules[0].switches;
    let below = |to_turns, bounce_ns| SwitchConfig { from_turns: f64::NEG_INFINITY, to_turns, bounce_ns };
    assert_eq!(switches.left, Some(below(-2.0, 0)));
    assert_eq!(switches.right, Some(below(5.0, 500_000)));
    assert_eq!(switches.home, Some(SwitchConfig { from_turns: 0.975, to_turns: 1.025, bounce_ns: 0 }));
}

#[test]
fn encoder_and_inputs() {
    let bench = bench(&format!(
        "{MODULE}[module.encoder]\ncounts = 4096\noffset_turns = 0.25\ninverted = true\nindex = false\n\
         [module.inputs]\nin_1 = 1\nin_7 = 0\nain_4 = 0xFFF\n"
    ));
    let module = &bench.modules[0];
    assert_eq!(
        module.encoder,
        EncoderConfig { counts: 4096, offset_turns: 0.25, inverted: true, index: false }
    );
    assert_eq!(module.inputs.digital.iter().collect::<Vec<_>>(), [(&1, &true), (&7, &false)]);
    assert_eq!(module.inputs.analog.iter().collect::<Vec<_>>(), [(&4, &4095)]);
}

#[test]
fn modules_hear_replies_only_where_the_file_says_so() {
    let hears = |text: &str| bench(&format!("{text}{MODULE}")).bus.modules_hear_replies;
    assert!(hears("[bus]\nmodules_hear_replies = true\n"));
    assert!(!hears("[bus]\nmodules_hear_replies = false\n"));
    assert!(!hears("[bus]\n") && !hears(""));
}

#[test]
fn wires_find_their_modules() {
    let wires = "[[wire]]\nfrom = \"m2.output.7\"\nto = \"door.input.3\"\n";
    let bench = bench(&format!("{MODULE}name = \"door\"\n{MODULE}{wires}"));
    assert_eq!(bench.wires, [Wire { from_module: 1, output: 7, to_module: 0, to: WireEnd::Input(3) }]);
}

#[test]
fn a_single_module_needs_no_name_in_wires() {
    let bench = bench(&format!("{MODULE}[[wire]]\nfrom = \"output.0\"\nto = \"input.2\"\n"));
    assert_eq!(bench.wires, [Wire { from_module: 0, output: 0, to_module: 0, to: WireEnd::Input(2) }]);
}

#[test]
fn events_come_sorted_and_keep_their_order_within_an_instant() {
    let bench = bench(&format!(
        "{MODULE}\
         [[event]]\nat = 2\nset = {{ power = \"off\" }}\n\
         [[event]]\nat = \"50us\"\nset = {{ \"m1.input.2\" = 1, \"ain.0\" = 7 }}\n\
         [[event]]\nat = 2.0\nset = {{ power = \"on\" }}\n"
    ));
    let times: Vec<u64> = bench.events.iter().map(|event| event.at_ns).collect();
    assert_eq!(times, [50_000, 2_000_000_000, 2_000_000_000]);
    let inputs = [Setting::Input { number: 2, high: true }, Setting::AnalogInput { number: 0, reading: 7 }];
    assert_eq!(bench.events[0].settings, inputs.map(|setting| (0, setting)));
    assert_eq!(bench.events[1].settings, [(0, Setting::Power(super::super::Power::Off))]);
}

/// Names with dots, in quotes or not, and sections of their own mean the same.
#[test]
fn names_of_settings_may_be_tables() {
    let spellings = [
        "[[event]]\nat = 1\nset = { \"m1.fault.coil_open\" = \"b\" }\n",
        "[[event]]\nat = 1\nset = { m1.fault.coil_open = \"b\" }\n",
        "[[event]]\nat = 1\n[event.set]\nfault.coil_open = \"b\"\n",
        "[[event]]\nat = 1\n[event.set.m1.fault]\ncoil_open = \"b\"\n",
    ];
    for spelling in spellings {
        let bench = bench(&format!("{MODULE}{spelling}"));
        let settings = vec![(0, Setting::CoilOpen(Some(Coil::B)))];
        assert_eq!(bench.events, [Event { at_ns: 1_000_000_000, settings }]);
    }
}
