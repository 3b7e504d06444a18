//! A run is a pure function of its inputs: the same bench gives the same trace bytes, a snapshot goes on as the original
//! does, and idle time gone through at once is the same as idle time gone through period by period.

use crate::common::{Module, TURN};
use motor_physics::load::{LoadTorque, Profile};
use tmcl_tables::tmcm_1311::AxisParameter as Ap;
use tmcl_tables::{Command, GlobalParameter, ModuleSpec};
use virtual_bench::{Bench, ModuleId, Physical, TICK_NS, Trace};

const SECOND_NS: u64 = 1_000_000_000;

/// A bit of everything: switches that bounce, a jam, a dip, faults, power off and on.
const EVENTFUL: &str = r#"
[[module]]
kind = "tmcm-1311"

[module.load]
torque = { by = "position", points = [[0.0, 0.0], [0.3, -0.1], [0.7, 0.05]], period = 1.0 }

[module.switches]
home = { at_turns = 1.0, width_turns = 0.1, bounce_ms = 2.0 }

[[event]]
at = "700ms"
set = { "load.friction_nm" = 1.5, "temperature_c" = 40.0 }

[[event]]
at = "900.03ms"
set = { "load.friction_nm" = 0.02, "fault.encoder_line" = "b" }

[[event]]
at = "1.3s"
set = { "supply.voltage_v" = 12.0, "fault.encoder_line" = "none" }

[[event]]
at = "1.6s"
set = { "supply.voltage_v" = 48.0, "fault.dropped_steps" = -8 }

[[event]]
at = "2.5s"
set = { "power" = "off" }

[[event]]
at = "2.8s"
set = { "power" = "on", "input.3" = 1 }
"#;

fn started(text: &str) -> Module {
    let mut module = Module::on(text);
    module.sap(Ap::MaxVelocity, 3 * TURN);
    module.sap(Ap::MaxAcceleration, 10 * TURN);
    module.ok(Command::MoveToPosition, 0, 0, 4 * TURN);
    module
}

/// Everything there is to see: all parameters, ports, and the physics of this motor.
fn all_names(bench: &Bench, spec: &ModuleSpec) -> Vec<String> {
    let parameters = spec.axis_parameters.iter().filter(|parameter| parameter.access.read);
    let mut names: Vec<String> = parameters.map(|parameter| parameter.id.to_owned()).collect();
    names.extend((0..8).flat_map(|number| [format!("input.{number}"), format!("output.{number}")]));
    let physical = Physical::NAMES.iter().map(|(name, _)| format!("physical.{name}"));
    names.extend(physical.filter(|name| bench.probe(name).is_ok()));
    names.extend(["sensed.encoder_counts", "sensed.step_pulses"].map(str::to_owned));
    names
}

fn csv(module: &mut Module, until_ns: u64) -> String {
    let spec = module.bench.spec(ModuleId(0)).expect("a module");
    let mut trace =
        Trace::new(&module.bench, &all_names(&module.bench, spec), 1_000_000).expect("names of this bench");
    trace.advance_to(&mut module.bench, until_ns);
    trace.csv_header() + &trace.csv_rows(0)
}

#[test]
fn two_runs_give_the_same_trace_bytes() {
    let [first, second] = [(), ()].map(|()| csv(&mut started(EVENTFUL), 4 * SECOND_NS));
    assert_eq!(first.lines().count(), 4002, "a header and a row each millisecond from 0 to 4 s");
    assert!(first == second, "two runs differ");
}

#[test]
fn how_finely_a_run_is_sliced_does_not_matter() {
    let mut whole = started(EVENTFUL);
    whole.bench.advance_to(4 * SECOND_NS);
    for slice_ns in [TICK_NS, 3 * TICK_NS, 1_234_567, 70_000_000] {
        let mut sliced = started(EVENTFUL);
        while sliced.bench.time_ns() + slice_ns < 4 * SECOND_NS {
            sliced.bench.advance_by(slice_ns.next_multiple_of(TICK_NS));
        }
        sliced.bench.advance_to(4 * SECOND_NS);
        assert!(state(&sliced) == state(&whole), "in slices of {slice_ns} ns");
    }
}

#[test]
fn a_snapshot_taken_in_a_stall_goes_on_as_the_original() {
    let mut module = started(EVENTFUL);
    module.bench.advance_to(800_000_000);
    assert!(
        f64::from(module.gap(Ap::ActualPosition)) / f64::from(TURN) > module.turns() + 0.05,
        "it is stalled"
    );
    let mut snapshot = module.clone();
    assert_eq!(state(&snapshot), state(&module));
    let original = csv(&mut module, 4 * SECOND_NS);
    // Replayed any number of times, in any order with the original.
    for _ in 0..2 {
        let mut replay = snapshot.clone();
        assert!(csv(&mut replay, 4 * SECOND_NS) == original, "the replay differs");
        assert!(state(&replay) == state(&module));
    }
    snapshot.set("load.friction_nm", 0.5);
    assert!(csv(&mut snapshot, 4 * SECOND_NS) != original, "another input, another run");
}

/// All state there is, to the last bit: floating point prints so that it reads back the same.
fn state(module: &Module) -> String {
    format!("{:?}", module.bench)
}

/// Torque that never changes, said in a way that keeps the bench from resting: it might change with time.
fn restless() -> LoadTorque {
    LoadTorque::ByTime(Profile::new(&[(0.0, 0.0)], None).expect("a profile"))
}

/// Runs the same inputs on a bench that may rest and on one that may not. At the end, and at every instant in `at_ms`, all
/// state is the same but for how the load is said.
fn assert_resting_is_stepping(
    text: &str,
    until_ms: u64,
    mut act: impl FnMut(&mut Module, u64),
    at_ms: &[u64],
) {
    let load = "[module.load]\ntorque = { by = \"time\", points = [[0.0, 0.0]] }\n";
    let mut resting = Module::on(text);
    let kind = "kind = \"tmcm-1311\"\n";
    assert!(text.contains(kind) && !text.contains("[module.load]"));
    let mut stepping = Module::on(&text.replace(kind, &format!("{kind}{load}")));
    for &now_ms in at_ms.iter().chain([&until_ms]) {
        resting.bench.advance_to(now_ms * 1_000_000);
        stepping.bench.advance_to(now_ms * 1_000_000);
        let stepped = state(&stepping)
            .replace(&format!("{:?}", restless()), &format!("{:?}", LoadTorque::Constant(0.0)));
        assert!(
            stepped == state(&resting),
            "at {now_ms} ms: {:?} and {:?}",
            stepping.physical(),
            resting.physical()
        );
        act(&mut resting, now_ms);
        act(&mut stepping, now_ms);
    }
}

const PLAIN: &str = "[[module]]\nkind = \"tmcm-1311\"\n";

#[test]
fn resting_is_stepping_while_nothing_happens() {
    assert_resting_is_stepping(PLAIN, 20_000, |_, _| (), &[1, 50, 70, 1000, 1033, 5000]);
}

#[test]
fn resting_is_stepping_around_moves() {
    let act = |module: &mut Module, now_ms| match now_ms {
        500 => _ = module.ok(Command::MoveToPosition, 0, 0, TURN / 3),
        4000 => _ = module.ok(Command::RotateLeft, 0, 0, 2 * TURN),
        5000 => _ = module.ok(Command::MotorStop, 0, 0, 0),
        8017 => module.sap(Ap::MaxCurrent, 200),
        9000 => module.sap(Ap::ChopperOffTime, 0),
        9500 => module.sap(Ap::ChopperOffTime, 5),
        _ => (),
    };
    assert_resting_is_stepping(PLAIN, 15_000, act, &[500, 3000, 4000, 5000, 8017, 9000, 9500, 12_000]);
}

/// Idle periods with things that happen by themselves: events off the grid, a bouncing switch, heat, another module.
#[test]
fn resting_is_stepping_through_events_bounce_and_heat() {
    let text = format!(
        "{PLAIN}[module.switches]\nhome = {{ at_turns = 0.1, bounce_ms = 7.0 }}\n{}",
        r#"
[[module]]
kind = "tmcm-1311"
[[wire]]
from = "m2.output.0"
to = "m1.input.2"
[[event]]
at = "1.000013s"
set = { "m1.fault.dropped_steps" = 20 }
[[event]]
at = "2s"
set = { "m1.fault.dropped_steps" = -20, "m2.temperature_c" = 80.0 }
[[event]]
at = "3.99999s"
set = { "supply.voltage_v" = 20.0 }
[[event]]
at = "5s"
set = { "m1.fault.switch_home" = "open", "m2.power" = "off" }
[[event]]
at = "7s"
set = { "m1.fault.board_temperature_c" = 150.0, "m2.power" = "on" }
[[event]]
at = "8s"
set = { "m1.fault.board_temperature_c" = "none", "m1.fault.coil_short" = "a" }
"#
    );
    assert_resting_is_stepping(
        &text,
        12_000,
        |_, _| (),
        &[999, 1001, 1005, 1500, 2003, 4000, 4500, 6000, 7500, 8500],
    );
}

/// What a client sees of time does not depend on resting.
#[test]
fn the_clock_goes_on_while_the_bench_rests() {
    let mut module = Module::new();
    module.bench.advance_to(3600 * SECOND_NS);
    assert_eq!(module.bench.time_ns(), 3600 * SECOND_NS);
    assert_eq!(module.ggp(GlobalParameter::TickTimer), 3_600_000);
}
