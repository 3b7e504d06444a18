//! The TMCM-1076 follows pulses: judged by the rotor and the coils.

use crate::common::step::{ENABLE, StepDriver};
use tmcl_tables::tmcm_1076::AxisParameter as Ap;

/// Friction holds the rotor back from where the standby current's field points: by less than a step of 1/16.
const SLACK_TURNS: f64 = 0.0003;

#[track_caller]
fn assert_turns(module: &StepDriver, expected: f64) {
    let turns = module.turns();
    assert!((turns - expected).abs() < SLACK_TURNS, "{turns} turns, not {expected}");
}

#[test]
fn sixteen_thousand_pulses_at_a_sixteenth_are_five_turns_there_and_back() {
    for interpolation in [1, 0] {
        let mut module = StepDriver::new();
        module.sap(Ap::MicrostepInterpolation, interpolation);
        module.run_ms(100);
        let from = module.turns();
        module.move_by(16_000, 16_000);
        assert!((module.turns() - from - 5.0).abs() < SLACK_TURNS, "{} turns", module.turns() - from);
        module.move_by(-16_000, 16_000);
        assert!((module.turns() - from).abs() < SLACK_TURNS, "{} turns", module.turns() - from);
    }
}

#[test]
fn directions_double_edges_and_resolutions_in_any_order_keep_count() {
    let mut module = StepDriver::new();
    // With the magnets' detent torque against it, the standby current would not point well enough between full steps.
    module.sap(Ap::StandbyCurrent, 24);
    let mut microsteps = 0;
    for (resolution, double_edge, pulses, frequency_hz) in [
        (4, 0, 3200, 8000),
        (4, 1, -1600, 4000),
        (8, 0, 51_200, 100_000),
        (8, 1, -12_800, 50_000),
        (1, 0, -100, 300),
        (6, 1, 1234, 3000),
        (3, 0, 777, 2000),
    ] {
        module.sap(Ap::MicrostepResolution, resolution);
        module.sap(Ap::DoubleEdgeSteps, double_edge);
        module.move_by(pulses, frequency_hz);
        microsteps += (pulses << (8 - resolution)) * (1 + double_edge);
        assert_turns(&module, f64::from(microsteps) / 51_200.0);
    }
}

#[test]
fn a_rate_beyond_pull_out_loses_steps_four_full_steps_at_a_time() {
    let mut module = StepDriver::new();
    module.run_ms(100);
    // 16 turns a second at once.
    module.set("step_dir.frequency_hz", 51_200);
    module.set("step_dir.pulses", 51_200);
    module.run_ms(1500);
    let turns = module.turns();
    assert!(turns < 12.0, "{turns} of 16 turns");
    assert!((turns * 50.0 - (turns * 50.0).round()).abs() < 0.05, "{turns} turns");
}

#[test]
fn pulses_are_counted_with_the_motor_off_and_do_not_turn_it() {
    let mut module = StepDriver::new();
    module.run_ms(50);
    module.set(ENABLE, 1);
    module.run_ms(50);
    assert!(module.rms_a() < 0.001, "{} A", module.rms_a());
    // A whole electrical period: the field is where it was.
    module.move_by(64, 1000);
    assert_turns(&module, 0.0);
    module.move_by(16, 1000);
    module.set(ENABLE, 0);
    module.run_ms(200);
    assert_turns(&module, 0.005);
}

#[test]
fn a_source_can_be_connected_from_the_start_and_by_events() {
    let mut module = StepDriver::with(
        "[module.step_dir]\nfrequency_hz = 6400\nacceleration_hz_per_s = 12800\npulses = 6400\n\
         [[event]]\nat = \"3s\"\nset = { \"step_dir.frequency_hz\" = -3200, \"step_dir.pulses\" = 3200 }\n",
    );
    module.run_ms(2900);
    assert_turns(&module, 2.0);
    module.run_ms(3000);
    assert_turns(&module, 1.0);
    assert_eq!(module.read("sensed.step_pulses"), 3200.0);
}

/// Resting, and every other way of cutting time, makes no difference.
#[test]
fn slow_pulses_come_to_the_same_however_time_is_cut() {
    let start = || {
        let mut module = StepDriver::new();
        module.set("step_dir.frequency_hz", 2.7);
        module
    };
    let (mut at_once, mut in_pieces) = (start(), start());
    at_once.run_ms(4000);
    for ticks in (0..).scan(0, |sum, piece| {
        *sum += piece % 91 + 1;
        (*sum <= 80_000).then_some(piece % 91 + 1)
    }) {
        in_pieces.run_ticks(ticks);
    }
    let left = 80_000 - (in_pieces.bench.time_ns() / virtual_bench::TICK_NS);
    in_pieces.run_ticks(left);
    assert_eq!(at_once.physical(), in_pieces.physical());
    assert_eq!(at_once.read("sensed.step_pulses"), 10.0);
    assert_eq!(in_pieces.read("sensed.step_pulses"), 10.0);
}

#[test]
fn without_power_nothing_flows_and_nobody_counts() {
    let mut module = StepDriver::new();
    module.run_ms(100);
    module.set("power", "off");
    module.set("step_dir.frequency_hz", 1000);
    module.run_ms(200);
    assert!(module.rms_a() < 1e-6);
    assert_turns(&module, 0.0);
    module.set("step_dir.frequency_hz", 0);
    module.set("power", "on");
    module.run_ms(200);
    assert_turns(&module, 0.0);
    assert!((module.rms_a() - 0.29).abs() < 0.005);
}

#[test]
fn a_recording_is_played_edge_by_edge() {
    // Twenty pulses of 1 ms to the right, each 37 µs long, then eight to the left.
    let edge = |pulse: u32, step: u32, dir: u32| {
        let us = 1000 * pulse + 123 + if step == 1 { 0 } else { 37 };
        format!("[{us}e-6, {step}, {dir}]")
    };
    let edges: Vec<_> =
        (0..28).flat_map(|pulse| [1, 0].map(|step| edge(pulse, step, u32::from(pulse >= 20)))).collect();
    let mut module = StepDriver::with(&format!("[module.step_dir]\nedges = [{}]\n", edges.join(", ")));
    module.sap(Ap::StandbyCurrent, 24);
    module.run_ms(15);
    assert_eq!(module.gap(Ap::Tstep), 12_000 / 16);
    module.run_ms(1000);
    assert_eq!(module.read("sensed.step_pulses"), 12.0);
    assert_turns(&module, 12.0 / 3200.0);
    // With double edges the same recording is worth twice as much.
    let mut module = StepDriver::with(&format!("[module.step_dir]\nedges = [{}]\n", edges.join(", ")));
    module.sap(Ap::StandbyCurrent, 24);
    module.sap(Ap::DoubleEdgeSteps, 1);
    module.run_ms(1000);
    assert_turns(&module, 24.0 / 3200.0);
}

#[test]
fn another_modules_outputs_can_pulse_it() {
    use tmcl_tables::Command;
    use virtual_bench::ModuleId;

    let mut module = StepDriver::with(
        "[[module]]\nkind = \"tmcm-1311\"\n[[wire]]\nfrom = \"m2.output.0\"\nto = \"m1.step\"\n\
         [[wire]]\nfrom = \"m2.output.1\"\nto = \"m1.dir\"\n",
    );
    module.sap(Ap::StandbyCurrent, 24);
    let port = module.port;
    let output = |module: &mut StepDriver, number: u8, level: i32| {
        let request = tmcl_wire::Request::new(Command::SetOutput, number, 2, level);
        let reply = module.bench.exchange(ModuleId(1), port, &tmcl_wire::serial::encode_request(1, request));
        assert_eq!(reply.get(2), Some(&100));
        module.run_ms(2);
    };
    for (dir, pulses) in [(0, 100), (1, 68)] {
        output(&mut module, 1, dir);
        for _ in 0..pulses {
            output(&mut module, 0, 1);
            output(&mut module, 0, 0);
        }
    }
    module.run_ms(1000);
    assert_eq!(module.read("m1.sensed.step_pulses"), 32.0);
    assert_turns(&module, 0.01);
}
