//! Expectations about real runs: decided at exact times, with what the values were instead.

use crate::common::motion::{finish, move_to};
use crate::common::{Module, TICKS_PER_MS, TURN};
use insta::assert_snapshot;
use proptest::prelude::*;
use tmcl_tables::tmcm_1311::AxisParameter as Ap;
use tmcl_tables::{Command, GlobalParameter};
use virtual_bench::expect::{Expectation, Monitor, Outcome};
use virtual_bench::{Bench, ModuleId, TICK_NS};

const MS: u64 = 1_000_000;

fn expectation(bench: &Bench, text: &str) -> Expectation {
    Expectation::parse(text, bench).unwrap_or_else(|error| panic!("{}", error.report(text)))
}

fn monitor(module: &Module, texts: &[&str]) -> Monitor {
    let expectations = texts.iter().map(|text| expectation(&module.bench, text)).collect();
    Monitor::new(expectations, &module.bench)
}

fn outcomes(monitor: &Monitor) -> Vec<Outcome> {
    monitor.verdicts().iter().map(|verdict| verdict.outcome.clone()).collect()
}

fn report(monitor: &Monitor) -> String {
    monitor.verdicts().iter().map(|verdict| format!("{verdict}\n")).collect()
}

/// SIO.
fn set_output(module: &mut Module, output: u8, level: i32) {
    module.ok(Command::SetOutput, output, 2, level);
}

/// On its way to 10000 µsteps, and the ticks it will take.
fn moving() -> (Module, u64) {
    let mut module = Module::new();
    module.sap(Ap::MaxVelocity, TURN);
    module.sap(Ap::MaxAcceleration, 4 * TURN);
    move_to(&mut module, 10_000);
    let ticks = finish(&mut module.clone());
    (module, ticks)
}

#[test]
fn a_move_arrives_when_it_arrives() {
    let (mut module, ticks) = moving();
    let arrival_ns = ticks * TICK_NS;
    let texts = [
        "actual_position == 10000 within 2s",
        "position_reached rises",
        "position_reached == 1 and actual_velocity == 0",
        "actual_position == 10000 for 100ms within 3s",
    ];
    let mut monitor = monitor(&module, &texts);
    monitor.advance_to(&mut module.bench, 10_000 * MS);
    let arrived = Outcome::Held { at_ns: arrival_ns };
    let rested = Outcome::Held { at_ns: arrival_ns + 100 * MS };
    assert_eq!(outcomes(&monitor), [arrived.clone(), arrived.clone(), arrived, rested]);
    assert_eq!(
        module.bench.time_ns(),
        arrival_ns + 100 * MS,
        "the last one was decided: nothing more to see"
    );
    // With nothing to decide the bench just runs on.
    monitor.advance_to(&mut module.bench, 10_000 * MS);
    assert_eq!(module.bench.time_ns(), 10_000 * MS);
}

/// The module has sensed nothing yet when it is switched on: it takes the voltage for too low.
#[test]
fn what_is_the_case_before_the_first_control_period_does_not_count() {
    let mut module = Module::new();
    assert_eq!(module.read("status_word") as u32 & 0x200, 0x200);
    let texts = [
        "never status_word & 0x200",
        "status_word & 0x200 == 0",
        "status_word & 0x200 at 0s",
        "status_word & 0x200 falls",
    ];
    let mut monitor = monitor(&module, &texts);
    monitor.observe(&module.bench);
    assert!(outcomes(&monitor).iter().all(|outcome| !outcome.is_decided()));
    monitor.advance_to(&mut module.bench, MS);
    monitor.finish(&module.bench);
    assert_snapshot!(report(&monitor), @r"
    never status_word & 0x200: held at 0.001 s
    status_word & 0x200 == 0: held at 0.00005 s
    status_word & 0x200 at 0s: failed: status_word & 0x200 was 0x0 at 0.00005 s
    status_word & 0x200 falls: held at 0.00005 s
    ");
}

/// Nothing was run.
#[test]
fn a_run_of_no_time_decides_nothing_but_its_end() {
    let mut module = Module::new();
    let texts = ["actual_position == 0", "never output.3 == 1", "output.3 == 0 at end"];
    let mut monitor = monitor(&module, &texts);
    monitor.advance_to(&mut module.bench, TICK_NS - 1);
    monitor.finish(&module.bench);
    assert_snapshot!(report(&monitor), @r"
    actual_position == 0: undecided: the run ended at 0.000 s, before 0.00005 s
    never output.3 == 1: undecided: the run ended at 0.000 s, before 0.00005 s
    output.3 == 0 at end: held at 0.000 s
    ");
}

/// The very tick before, it is too early.
#[test]
fn within_includes_its_end_and_nothing_later() {
    let (module, ticks) = moving();
    let arrival_us = ticks * TICK_NS / 1000;
    for (us, held) in [(arrival_us, true), (arrival_us - 50, false)] {
        let mut module = module.clone();
        let texts = [
            format!("actual_position == 10000 within {us}us"),
            format!("position_reached rises within {us}us"),
            format!("actual_position == 10000 at {us}us"),
            format!("actual_position != 10000 at {us}us"),
            format!("never position_reached == 1 within {us}us"),
            format!("always position_reached == 0 within {us}us"),
        ];
        let mut monitor = monitor(&module, &texts.each_ref().map(String::as_str));
        monitor.advance_to(&mut module.bench, 10_000 * MS);
        assert!(monitor.is_decided());
        let is_held = |verdict: &Outcome| matches!(verdict, Outcome::Held { at_ns } if *at_ns == us * 1000);
        let held_ones: Vec<_> = outcomes(&monitor).iter().map(is_held).collect();
        assert_eq!(held_ones, [held, held, held, !held, !held, !held], "{}", report(&monitor));
    }
}

#[test]
fn outputs_rise_and_fall_at_the_tick_they_are_set() {
    let mut module = Module::new();
    let texts = [
        "output.3 rises",
        "output.3 rises within 500ms",
        "output.3 rises within 10.05ms",
        "output.3 rises within 10ms",
        "output.3 falls",
        "output.3 changes after 15ms",
        "output.4 rises within 30ms",
        "never output.3 falls within 20ms",
        "never output.3 falls",
        "never output.3 rises after 11ms",
    ];
    let mut monitor = monitor(&module, &texts);
    monitor.advance_to(&mut module.bench, 10 * MS + TICK_NS);
    // What is set after the look at a deadline is too late for it.
    set_output(&mut module, 3, 1);
    monitor.advance_to(&mut module.bench, 20 * MS);
    set_output(&mut module, 3, 0);
    monitor.advance_to(&mut module.bench, 40 * MS);
    monitor.finish(&module.bench);
    assert_snapshot!(report(&monitor), @r"
    output.3 rises: held at 0.01005 s
    output.3 rises within 500ms: held at 0.01005 s
    output.3 rises within 10.05ms: failed: output.3 was 0 at 0.01005 s and never rose
    output.3 rises within 10ms: failed: output.3 was 0 at 0.010 s and never rose
    output.3 falls: held at 0.020 s
    output.3 changes after 15ms: held at 0.020 s
    output.4 rises within 30ms: failed: output.4 was 0 at 0.030 s and never rose
    never output.3 falls within 20ms: held at 0.020 s
    never output.3 falls: failed: output.3 fell from 1 to 0 at 0.020 s
    never output.3 rises after 11ms: held at 0.040 s
    ");
}

/// A pulse within one control period happened in no time: there is nothing to see.
#[test]
fn edges_have_the_resolution_of_control_periods() {
    let mut module = Module::new();
    let mut monitor = monitor(&module, &["output.3 changes"]);
    monitor.advance_to(&mut module.bench, MS);
    set_output(&mut module, 3, 1);
    set_output(&mut module, 3, 0);
    monitor.advance_to(&mut module.bench, 2 * MS);
    assert!(!monitor.is_decided());
    set_output(&mut module, 3, 1);
    module.run_ticks(1);
    monitor.observe(&module.bench);
    assert_eq!(outcomes(&monitor), [Outcome::Held { at_ns: 2 * MS + TICK_NS }]);
}

#[test]
fn what_the_values_were_instead() {
    let (mut module, _) = moving();
    let texts = [
        "actual_position == 10001 within 1s",
        "actual_position == 10001 at 0.1s",
        "actual_velocity > 60000 within 1s",
        "actual_position == 10000 and actual_velocity == 5 within 1s",
        "actual_velocity > 40000 for 1s within 1.5s",
        "actual_velocity == 51200 for 10ms after 1s within 1.5s",
        "never status_word & 0x200",
        "never position_reached & 1",
        "never actual_velocity == 0 for 100ms after 100ms",
        "always physical.torque_nm < 0.1",
        "always virtual_position == actual_position +- 1",
        "virtual_position > actual_position within 1s",
        "never actual_velocity == 0 after 50ms",
        "physical.rotor_turns > 4.9 at end",
        "physical.rotor_turns == 0.195 +- 0.01 at end",
        "tick_timer == 1234",
        "output.3 rises",
        "actual_position == 10001",
        "actual_position == 10000 for 3s",
        "actual_position == 10000 at 5s",
        "never output.3 == 1 within 5s",
        "output.2 == 1 after 5s",
    ];
    let mut monitor = monitor(&module, &texts);
    monitor.advance_to(&mut module.bench, 2000 * MS);
    monitor.finish(&module.bench);
    assert_eq!(module.bench.time_ns(), 2000 * MS);
    assert_snapshot!(report(&monitor), @r"
    actual_position == 10001 within 1s: failed: actual_position was 10000 at 1.000 s
    actual_position == 10001 at 0.1s: failed: actual_position was 1024 at 0.100 s
    actual_velocity > 60000 within 1s: failed: actual_velocity was 0 at 1.000 s; nearest 45250 at 0.22095 s
    actual_position == 10000 and actual_velocity == 5 within 1s: failed: actual_velocity was 0 at 1.000 s
    actual_velocity > 40000 for 1s within 1.5s: failed: actual_velocity was 0 at 1.500 s; it held for 0.05125 s at the longest, from 0.19535 s
    actual_velocity == 51200 for 10ms after 1s within 1.5s: failed: actual_velocity was 0 at 1.500 s
    never status_word & 0x200: held at 2.000 s
    never position_reached & 1: failed: position_reached & 0x1 was 0x1 at 0.44195 s
    never actual_velocity == 0 for 100ms after 100ms: failed: actual_velocity was 0 from 0.44195 s to 0.54195 s
    always physical.torque_nm < 0.1: failed: physical.torque_nm was 0.101378117 at 0.1819 s
    always virtual_position == actual_position +- 1: held at 2.000 s
    virtual_position > actual_position within 1s: failed: virtual_position was 10000 and actual_position 10000 at 1.000 s; nearest 0 against 0 at 0.00005 s
    never actual_velocity == 0 after 50ms: failed: actual_velocity was 0 at 0.44195 s
    physical.rotor_turns > 4.9 at end: failed: physical.rotor_turns was 0.195213468 at 2.000 s
    physical.rotor_turns == 0.195 +- 0.01 at end: held at 2.000 s
    tick_timer == 1234: held at 1.234 s
    output.3 rises: undecided: the run ended first; output.3 was 0 at 2.000 s and never rose
    actual_position == 10001: undecided: the run ended first; actual_position was 10000 at 2.000 s
    actual_position == 10000 for 3s: undecided: the run ended first; actual_position was 10000 at 2.000 s; it held for 1.55805 s at the longest, from 0.44195 s
    actual_position == 10000 at 5s: undecided: the run ended at 2.000 s, before 5.000 s
    never output.3 == 1 within 5s: undecided: the run ended at 2.000 s, before 5.000 s
    output.2 == 1 after 5s: undecided: the run ended at 2.000 s, before 5.000 s
    ");
}

#[test]
fn deadlines_are_met_while_the_bench_rests() {
    let mut module = Module::new();
    module.run_ms(500);
    let texts = [
        "actual_position == 0 for 61.3ms",
        "output.3 rises within 123.45ms",
        "tick_timer == 570",
        "output.0 == 0 at 777ms",
    ];
    let mut monitor = monitor(&module, &texts);
    assert_eq!(monitor.next_deadline_ns(), 500 * MS + TICK_NS, "the tick timer rests never");
    monitor.advance_to(&mut module.bench, 10_000 * MS);
    let start_ns = 500 * MS;
    let missed = "output.3 was 0 at 0.62345 s and never rose".to_owned();
    let expected = [
        Outcome::Held { at_ns: start_ns + TICK_NS + 61_300_000 },
        Outcome::Failed { at_ns: start_ns + 123_450_000, reason: missed },
        Outcome::Held { at_ns: 570 * MS },
        Outcome::Held { at_ns: start_ns + 777 * MS },
    ];
    assert_eq!(outcomes(&monitor), expected);
    assert_eq!(module.bench.time_ns(), start_ns + 777 * MS);
}

#[test]
fn an_event_is_seen_after_the_control_period_it_acts_on() {
    let file = "[[module]]\nkind = \"tmcm-1311\"\n[[event]]\nat = \"100ms\"\nset = { \"input.3\" = 0, \"input.2\" = 0 }\n\
        [[event]]\nat = \"200ms\"\nset = { \"input.3\" = 1 }\n";
    let mut module = Module::on(file);
    let mut monitor =
        monitor(&module, &["input.3 rises", "input.3 falls after 101ms within 300ms", "always input.2 == 1"]);
    monitor.advance_to(&mut module.bench, 1000 * MS);
    assert_snapshot!(report(&monitor), @r"
    input.3 rises: held at 0.20005 s
    input.3 falls after 101ms within 300ms: failed: input.3 was 1 at 0.300 s and never fell
    always input.2 == 1: failed: input.2 was 0 at 0.00005 s
    ");
}

#[test]
fn variables_coordinates_and_settings_can_be_expected() {
    let mut module = Module::new();
    let texts =
        ["variable.7 == -5", "coordinate.20 == 1234", "timer_0_period == 100", "suppress_reply == no_reply"];
    let mut monitor = monitor(&module, &texts);
    monitor.advance_to(&mut module.bench, MS);
    module.ok(Command::SetGlobalParameter, 7, 2, -5);
    module.ok(Command::SetCoordinate, 20, 0, 1234);
    module.sgp(GlobalParameter::Timer0Period, 100);
    monitor.advance_to(&mut module.bench, 2 * MS);
    let held = Outcome::Held { at_ns: MS };
    let undecided = Outcome::Undecided { reason: String::new() };
    assert_eq!(outcomes(&monitor), [held.clone(), held.clone(), held, undecided]);
}

/// To look at the random number draws none: the one that is drawn next is the same.
#[test]
fn looking_changes_nothing() {
    let mut looked_at = Module::new();
    let mut left_alone = looked_at.clone();
    for _ in 0..3 {
        let before = looked_at.read("random_number");
        assert_eq!(looked_at.read("random_number"), before);
        let drawn = looked_at.ggp(GlobalParameter::RandomNumber);
        assert_eq!(drawn, left_alone.ggp(GlobalParameter::RandomNumber));
        assert_eq!(looked_at.read("random_number"), f64::from(drawn));
    }
}

/// Something that moves, rests, and is disturbed, for half a second.
fn eventful() -> Module {
    let file = "[[module]]\nkind = \"tmcm-1311\"\n[[event]]\nat = \"30.02ms\"\nset = { \"input.3\" = 0 }\n\
        [[event]]\nat = \"31ms\"\nset = { \"input.3\" = 1 }\n\
        [[event]]\nat = \"420ms\"\nset = { power = \"off\" }\n[[event]]\nat = \"440ms\"\nset = { power = \"on\" }\n";
    let mut module = Module::on(file);
    module.run_ms(10);
    module.sap(Ap::MaxVelocity, TURN);
    module.sap(Ap::MaxAcceleration, 20 * TURN);
    move_to(&mut module, 5_000);
    module
}

const END_TICKS: u64 = 500 * TICKS_PER_MS;

/// Conditions in words, and whether they are met, given what a control period before and now is.
type Met = fn(&Bench, &Bench) -> bool;
const CONDITIONS: [(&str, Met); 11] = [
    ("actual_position > 2500", |_, now| read(now, "actual_position") > 2500.0),
    ("actual_position == 5000", |_, now| read(now, "actual_position") == 5000.0),
    ("actual_velocity == 0", |_, now| read(now, "actual_velocity") == 0.0),
    ("input.3 rises", |before, now| read(before, "input.3") == 0.0 && read(now, "input.3") == 1.0),
    ("input.3 falls", |before, now| read(before, "input.3") == 1.0 && read(now, "input.3") == 0.0),
    ("tick_timer == 77", |_, now| read(now, "tick_timer") == 77.0),
    ("tick_timer & 0x10", |_, now| read(now, "tick_timer") as u32 & 16 != 0),
    ("physical.rotor_turns < 0.05", |_, now| now.physical(ModuleId(0)).rotor_turns < 0.05),
    ("position_reached changes", |before, now| {
        read(before, "position_reached") != read(now, "position_reached")
    }),
    ("actual_velocity > 0 and actual_position < 4000", |_, now| {
        read(now, "actual_velocity") > 0.0 && read(now, "actual_position") < 4000.0
    }),
    ("actual_position == target_position +- 700", |_, now| {
        (read(now, "actual_position") - read(now, "target_position")).abs() <= 700.0
    }),
];

fn read(bench: &Bench, name: &str) -> f64 {
    bench.read(bench.probe(name).expect("a quantity of this bench"))
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum When {
    End,
    At(u64),
    During { after: u64, hold: u64, within: Option<u64> },
}

/// An expectation: a rule, the place of a condition, and times in ms.
type Expected = (&'static str, usize, When);

fn expectations() -> impl Strategy<Value = Expected> {
    let during = |(after, hold, more): (u64, u64, Option<u64>)| When::During {
        after,
        hold,
        within: more.map(|more| after + hold + more),
    };
    let when = prop_oneof![
        1 => Just(When::End),
        2 => (0..700_u64).prop_map(When::At),
        3 => (Just(0), Just(0), proptest::option::of(0..700_u64)).prop_map(during),
        3 => (0..300_u64, Just(0), proptest::option::of(0..300_u64)).prop_map(during),
        3 => (0..300_u64, 0..120_u64, proptest::option::of(0..300_u64)).prop_map(during),
    ];
    (proptest::sample::select(&["", "never ", "always "][..]), 0..CONDITIONS.len(), when)
}

fn text((rule, condition, when): Expected) -> String {
    let (condition, _) = CONDITIONS[condition];
    let clauses = match when {
        When::End => " at end".to_owned(),
        When::At(ms) => format!(" at {ms}ms"),
        When::During { after, hold, within } => {
            let part = |word: &str, ms: u64| if ms > 0 { format!(" {word} {ms}ms") } else { String::new() };
            let within = within.map_or_else(String::new, |ms| format!(" within {ms}ms"));
            part("for", hold) + &part("after", after) + &within
        }
    };
    format!("{rule}{condition}{clauses}")
}

/// What must come of an expectation whose condition is met at these ticks: whether it holds, and the tick at which that is
/// certain.
fn outcome((rule, _, when): Expected, met: &[bool]) -> Option<(bool, u64)> {
    let ticks = |ms: u64| ms * TICKS_PER_MS;
    let met_at = |tick: u64| met[usize::try_from(tick).expect("a tick")];
    // There is nothing to see before the end of the first control period.
    let from = |ms: u64| ticks(ms).max(1);
    let (after, hold, until) = match when {
        When::End => return Some((met_at(END_TICKS), END_TICKS)),
        When::At(ms) => return (from(ms) <= END_TICKS).then(|| (met_at(from(ms)), from(ms))),
        When::During { after, hold, within } => (from(after), ticks(hold), within.map(from)),
    };
    let last = until.unwrap_or(u64::MAX).min(END_TICKS);
    let decisive = (after..=last).find(|&tick| match rule {
        "always " => !met_at(tick),
        _ => tick >= after + hold && (tick - hold..=tick).all(met_at),
    });
    match (decisive, until) {
        (Some(tick), _) => Some((rule.is_empty(), tick)),
        (None, Some(until)) => (until <= END_TICKS).then_some((!rule.is_empty(), until)),
        (None, None) => (!rule.is_empty() && after <= END_TICKS).then_some((true, END_TICKS)),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// What is decided, and when, is what a look at every control period says; to rest, to stop for deadlines and to come
    /// back early makes no difference.
    #[test]
    fn every_verdict_is_right(
        expected in proptest::collection::vec(expectations(), 1..6),
        stops in proptest::collection::btree_set(0..END_TICKS, 0..4),
    ) {
        let start = eventful().bench;
        // Some words do not go together.
        let is_one = |expected: &Expected| Expectation::parse(&text(*expected), &start).is_ok();
        let expected: Vec<_> = expected.into_iter().filter(is_one).collect();
        let parsed = expected.iter().map(|expected| expectation(&start, &text(*expected)));
        let mut patient = Monitor::new(parsed.collect(), &start);
        let mut quick = patient.clone();

        let mut bench = start.clone();
        let mut met = vec![Vec::new(); expected.len()];
        let mut before = bench.clone();
        loop {
            patient.observe(&bench);
            for ((_, condition, _), met) in expected.iter().zip(&mut met) {
                met.push(CONDITIONS[*condition].1(&before, &bench));
            }
            if bench.time_ns() == start.time_ns() + END_TICKS * TICK_NS {
                break;
            }
            before.clone_from(&bench);
            bench.advance_by(TICK_NS);
        }
        patient.finish(&bench);

        for ((expected, met), verdict) in expected.iter().zip(&met).zip(patient.verdicts()) {
            let decided = match verdict.outcome {
                Outcome::Held { at_ns } => Some((true, at_ns)),
                Outcome::Failed { at_ns, .. } => Some((false, at_ns)),
                Outcome::Undecided { .. } => None,
            };
            let wanted = outcome(*expected, met);
            let wanted = wanted.map(|(held, tick)| (held, start.time_ns() + tick * TICK_NS));
            prop_assert_eq!(decided, wanted, "{}", verdict);
        }

        let mut rested = start.clone();
        let stops_ns = stops.iter().chain([&END_TICKS]).map(|ticks| start.time_ns() + ticks * TICK_NS);
        for stop_ns in stops_ns {
            while rested.time_ns() < stop_ns {
                quick.advance_to(&mut rested, stop_ns);
            }
        }
        quick.finish(&rested);
        prop_assert_eq!(patient.verdicts(), quick.verdicts());
        prop_assert_eq!(bench.physical(ModuleId(0)), rested.physical(ModuleId(0)));
    }
}
