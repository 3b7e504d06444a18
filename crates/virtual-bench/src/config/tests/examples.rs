//! The files and blocks that people copy from.

use super::super::{Contact, Event, Setting, SwitchName};
use super::bench;

macro_rules! example {
    ($name:literal) => {
        include_str!(concat!("../../../../../examples/benches/", $name))
    };
}

#[test]
fn the_lift_hangs_on_its_motor() {
    let bench = bench(example!("lift.toml"));
    let load = &bench.modules[0].load;
    assert_eq!(load.torque.at(3.0, 1.0), -0.196);
    assert_eq!(load.hard_stops.map(|stops| (stops.low_turns, stops.high_turns)), Some((-0.1, f64::INFINITY)));
    assert!(bench.events.is_empty());
}

#[test]
fn the_overload_comes_and_goes() {
    let bench = bench(example!("overload.toml"));
    let expected = [(1_500_000_000, 1.5), (2_000_000_000, 0.01)].map(|(at_ns, friction_nm)| Event {
        at_ns,
        settings: vec![(0, Setting::LoadFrictionNm(friction_nm))],
    });
    assert_eq!(bench.events, expected);
}

#[test]
fn the_encoder_fault_names_its_module() {
    let bench = bench(example!("encoder-fault.toml"));
    assert_eq!(bench.modules[0].name, "axis");
    assert_eq!(bench.events[2].settings, [(0, Setting::DroppedSteps(-4))]);
    assert_eq!(bench.events[2].at_ns, 2_500_000_000);
}

#[test]
fn the_stop_switches_stand_before_the_hard_stops() {
    let bench = bench(example!("stop-switches.toml"));
    let module = &bench.modules[0];
    let stops = module.load.hard_stops.expect("hard stops");
    let (left, right) = (module.switches.left.expect("left"), module.switches.right.expect("right"));
    assert!(stops.low_turns < left.to_turns && right.from_turns < stops.high_turns);
    assert_eq!(module.switches.home.expect("home").bounce_ns, 1_000_000);
    let stuck = Setting::SwitchContact { switch: SwitchName::Right, stuck: Some(Contact::Open) };
    assert_eq!(bench.events[0].settings, [(0, stuck)]);
}

#[test]
fn the_pulses_come_back_by_a_turn() {
    let bench = bench(example!("step-direction.toml"));
    assert_eq!(bench.modules[0].step_dir.frequency_hz, 25_600.0);
    let back = [(0, Setting::StepFrequencyHz(-25_600.0)), (0, Setting::StepPulses(Some(51_200)))];
    assert_eq!(bench.events[0].settings, back);
    assert_eq!(bench.events[1].settings, [(0, Setting::StepEnable(false))]);
}

#[test]
fn the_bus_has_no_module_at_its_hosts_address() {
    let bench = bench(example!("bus.toml"));
    let modules = bench.modules.iter().map(|module| (module.name.as_str(), module.address));
    assert_eq!(modules.collect::<Vec<_>>(), [("lift", Some(1)), ("fan", Some(3))]);
    assert!(!bench.bus.modules_hear_replies);
}

/// Every block of TOML on the reference page that begins with a comment is a whole file.
#[test]
fn the_reference_page_shows_files_that_work() {
    let page = include_str!("../../../../../docs/bench-file.md");
    let blocks: Vec<&str> =
        page.split("```toml\n").skip(1).filter_map(|rest| rest.split("```").next()).collect();
    let files: Vec<&&str> = blocks.iter().filter(|block| block.starts_with('#')).collect();
    assert!(files.len() >= 2, "{} files among {} blocks", files.len(), blocks.len());
    for file in files {
        bench(file);
    }
}

/// Every key and every setting that the reader knows is on the reference page.
#[test]
fn the_reference_page_names_every_setting() {
    let page = include_str!("../../../../../docs/bench-file.md");
    for setting in super::super::SETTINGS {
        assert!(page.contains(&format!("`{setting}`")), "{setting}");
    }
}
