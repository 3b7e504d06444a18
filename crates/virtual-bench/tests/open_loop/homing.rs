//! Reference search: RFS, AP 193 to 196, WAIT RFS, judged by where the shaft really is (TMCM-1311 §5.7.13, §9; decisions 5.9).

use crate::common::motion::{assert_agree, move_to};
use crate::common::program::{STOP, WAIT_TICK, keep, kind, op, sio, wait};
use crate::common::{Module, TURN};
use tmcl_tables::tmcm_1311::AxisParameter as Ap;
use tmcl_tables::{Command, GlobalParameter as Gp};

/// The left stop switch is a cam with two edges, as modes 3 and 4 need it.
const LEFT: (f64, f64) = (-0.55, -0.5);
const RIGHT: f64 = 0.5;
const HOME: (f64, f64) = (0.1, 0.15);

/// How far the shaft may stand from the truth, in turns: two µsteps from an edge; from a middle what friction (0.01 Nm hold it
/// two µsteps off its field) and the detent torque make of it, which pulls differently at the edges and between them.
fn tolerance(mode: i32) -> f64 {
    let microsteps = if [1, 2].contains(&(mode & !128)) { 2.0 } else { 8.0 };
    microsteps / f64::from(TURN)
}

fn bench(bounce_ms: f64) -> String {
    let (left, home) = ((LEFT.0 + LEFT.1) / 2.0, (HOME.0 + HOME.1) / 2.0);
    format!(
        "[[module]]\nkind = \"tmcm-1311\"\n[module.switches]\n\
         left = {{ at_turns = {left}, width_turns = 0.05, bounce_ms = {bounce_ms:.1} }}\n\
         right = {{ at_turns = {RIGHT}, bounce_ms = {bounce_ms:.1} }}\n\
         home = {{ at_turns = {home}, width_turns = 0.05, bounce_ms = {bounce_ms:.1} }}\n"
    )
}

const START: u8 = 0;
const ABORT: u8 = 1;
const STATUS: u8 = 2;

fn rfs(module: &mut Module, kind: u8) -> i32 {
    module.ok(Command::ReferenceSearch, kind, 0, 0)
}

/// A module whose shaft stands at so many turns; the stop switches stop nothing.
fn at(turns: f64, bounce_ms: f64) -> Module {
    let mut module = Module::on(&bench(bounce_ms));
    module.sap(Ap::LeftLimitSwitchDisable, 1);
    module.sap(Ap::RightLimitSwitchDisable, 1);
    module.sap(Ap::MaxAcceleration, 4 * TURN);
    move_to(&mut module, (turns * f64::from(TURN)) as i32);
    module.arrive();
    module
}

impl Module {
    /// A turn a second to the switch, and from there on a turn in so many seconds.
    fn set_speeds(&mut self, turn: i32, per_turn_s: i32) {
        self.sap(Ap::MaxVelocity, turn);
        self.sap(Ap::MaxAcceleration, 4 * turn);
        self.sap(Ap::ReferenceSwitchVelocity, (turn / per_turn_s).max(1));
    }
}

/// Polls RFS STATUS as a host does, until the search is over.
#[track_caller]
fn search(module: &mut Module, mode: i32) {
    module.sap(Ap::ReferenceSearchMode, mode);
    rfs(module, START);
    for _ in 0..30_000 {
        if rfs(module, STATUS) == 0 {
            return;
        }
        assert_eq!(module.gap(Ap::PositionReached), 0, "not while it searches");
        module.run_ms(1);
    }
    panic!("mode {mode} never ends; {} turns, AP 1 = {}", module.turns(), module.gap(Ap::ActualPosition));
}

/// Where the zero is, and what AP 196 says, in turns.
fn truth(mode: i32) -> (f64, f64) {
    let left_middle = (LEFT.0 + LEFT.1) / 2.0;
    match mode & !128 {
        1 => (LEFT.1, 0.0),
        2 => (LEFT.1, RIGHT - LEFT.1),
        3 => (left_middle, RIGHT - left_middle),
        4 => (left_middle, 0.0),
        _ => ((HOME.0 + HOME.1) / 2.0, 0.0),
    }
}

/// Stands on the new zero at the instant the search ends, and the shaft settles on what mode and switches mean.
#[track_caller]
fn assert_found(module: &mut Module, mode: i32, what: &str) {
    let here = [Ap::ActualPosition, Ap::TargetPosition, Ap::ActualVelocity, Ap::TargetVelocity, Ap::RampMode];
    assert_eq!(here.map(|parameter| module.gap(parameter)), [0; 5], "mode {mode}, {what}");
    assert_eq!(module.gap(Ap::PositionReached), 1);
    module.run_ms(300);
    let (zero, distance) = truth(mode);
    let off = module.turns() - zero;
    assert!(off.abs() <= tolerance(mode), "mode {mode}, {what}: {} µsteps off", off * f64::from(TURN));
    let measured = f64::from(module.gap(Ap::EndSwitchDistance)) / f64::from(TURN);
    assert!(
        (measured - distance).abs() <= 8.0 / f64::from(TURN),
        "mode {mode}, {what}: AP 196 says {measured} turns"
    );
    let sensed = f64::from(module.gap(Ap::EncoderCounter)) / 40_000.0;
    assert!((sensed - module.turns()).abs() <= 1.0 / 40_000.0, "the encoder counts on from where it was");
}

#[test]
fn every_mode_finds_its_zero_from_everywhere() {
    for bounce_ms in [0.0, 3.0] {
        // Between the switches, on each of them, and beside the home switch.
        for start in [0.0, -0.52, 0.53, 0.12, 0.3] {
            for mode in 1..=8 {
                // Modes 7 and 8 do not turn round.
                let home_is_behind = (mode == 7 && start > HOME.1) || (mode == 8 && start < HOME.0);
                if !home_is_behind {
                    let mut module = at(start, bounce_ms);
                    search(&mut module, mode);
                    assert_found(&mut module, mode, &format!("from {start}, bounce {bounce_ms} ms"));
                }
            }
        }
    }
}
/// Where it stops to turn round, a search is not at rest: neither delay runs, and the coils keep their current.
#[test]
fn a_search_is_no_standstill() {
    let mut module = at(0.0, 3.0);
    module.sap(Ap::PowerDownDelay, 1);
    module.sap(Ap::StandbyCurrent, 0);
    module.sap(Ap::FreewheelingDelay, 20);
    search(&mut module, 1);
    assert_found(&mut module, 1, "with short delays");
    let physical = module.physical();
    assert_eq!([physical.coil_a_a, physical.coil_b_a], [0.0; 2], "afterwards they run");
}

/// As bench files have stop switches unless they say otherwise: pressed from an edge on; and nothing set but the mode.
#[test]
fn a_switch_without_a_far_edge_has_an_edge_to_find() {
    for mode in [1, 2] {
        let left = format!("left = {{ at_turns = {}, bounce_ms = 5 }}", LEFT.1);
        let right = format!("right = {{ at_turns = {RIGHT}, bounce_ms = 5 }}");
        let mut module =
            Module::on(&format!("[[module]]\nkind = \"tmcm-1311\"\n[module.switches]\n{left}\n{right}\n"));
        search(&mut module, mode);
        assert_found(&mut module, mode, "by default");
        // From beyond the edge, on the switch.
        module.sap(Ap::LeftLimitSwitchDisable, 1);
        move_to(&mut module, -TURN / 4);
        module.arrive();
        search(&mut module, mode);
        assert_found(&mut module, mode, "from beyond");
    }
}

/// + 128: the contact of the home switch is closed where it is pressed. GP 79 reverses them all.
#[test]
fn an_inverted_home_switch_is_found_too() {
    for (mode, start) in [(133, 0.3), (134, 0.0), (135, 0.12), (136, 0.3), (133, 0.12)] {
        let mut module = at(start, 3.0);
        // A contact that opens everywhere but at the switch: what GP 79 makes of the other kind, without the stop switches.
        module.sgp(Gp::EndSwitchPolarity, 1);
        module.set("fault.switch_left", "open");
        module.set("fault.switch_right", "open");
        assert_eq!(module.gap(Ap::HomeSwitch), i32::from(start != 0.12));
        search(&mut module, mode);
        assert_found(&mut module, mode, &format!("inverted, from {start}"));
    }
}

/// In modes 1 to 4 there is no home switch to invert.
#[test]
fn the_stop_switches_are_not_inverted() {
    for mode in [129, 130, 131, 132] {
        let mut module = at(0.1, 1.0);
        search(&mut module, mode);
        assert_found(&mut module, mode, "from 0.1");
    }
}

/// AP 194 until the switch is found, AP 195 from then on; their signs do not matter, 0 means AP 4 and a quarter of it.
#[test]
fn the_speeds_are_those_of_194_and_195() {
    for (search_pps, switch_pps, fast, slow) in
        [(0, 0, TURN, TURN / 4), (-20_000, 3000, 20_000, 3000), (90_000, -9000, 90_000, 9000)]
    {
        let mut module = at(0.0, 0.0);
        module.sap(Ap::MaxAcceleration, 20 * TURN);
        module.sap(Ap::ReferenceSearchVelocity, search_pps);
        module.sap(Ap::ReferenceSwitchVelocity, switch_pps);
        module.sap(Ap::ReferenceSearchMode, 4);
        rfs(&mut module, START);
        let (mut fastest, mut slowest) = (0, 0);
        while rfs(&mut module, STATUS) != 0 {
            let speed = module.gap(Ap::ActualVelocity).abs();
            if rfs(&mut module, STATUS) == 1 {
                fastest = fastest.max(speed);
            } else {
                slowest = slowest.max(speed);
            }
            module.run_ticks(1);
        }
        // At the instant that the switch is found the motor stops at once, from search speed.
        assert_eq!((fastest, slowest), (fast, slow));
        assert_found(&mut module, 4, "at other speeds");
    }
}

/// The zero is on the µstep of AP 140 that is nearest, and that is as near as it gets; at a crawl and at full speed.
#[test]
fn at_other_resolutions_and_speeds() {
    for (resolution, bounce_ms) in [(4, 0.0), (4, 3.0), (8, 3.0)] {
        for per_turn_s in [40, 4, 1] {
            let mut module = at(0.0, bounce_ms);
            let turn = TURN >> (8 - resolution);
            module.sap(Ap::MicrostepResolution, resolution);
            module.set_speeds(turn, per_turn_s);
            for mode in [1, 2, 4, 6] {
                search(&mut module, mode);
                module.run_ms(300);
                let microstep = 1.0 / f64::from(turn);
                // What bounces is a coin toss in every control period.
                let bouncing = if bounce_ms > 0.0 { 8.0 } else { 1.0 };
                let sampling = 50e-6 * bouncing / f64::from(per_turn_s) / 2.0;
                // At a turn a second the detent torque shakes the motor near its resonance.
                let swinging = if per_turn_s == 1 { 24.0 / f64::from(TURN) } else { 0.0 };
                let allowed = tolerance(mode) + microstep + sampling + swinging;
                let zero = module.turns() - f64::from(module.gap(Ap::ActualPosition)) * microstep;
                let off = (zero - truth(mode).0) * f64::from(TURN);
                let what = format!("mode {mode}, AP 140 = {resolution}, a turn in {per_turn_s} s");
                assert!(
                    off.abs() <= allowed * f64::from(TURN),
                    "{what}: {off} µsteps off, {allowed} turns allowed"
                );
            }
        }
    }
}

/// AP 149 counts for the search as well: with it the ramp slows down where the switch is found.
#[test]
fn a_soft_stop_overruns_the_switch_and_finds_it_nevertheless() {
    for (soft, overrun) in [(0, 0.0), (1, 0.125)] {
        for mode in 1..=6 {
            let mut module = at(0.2, 2.0);
            module.sap(Ap::SoftStop, soft);
            let mut lowest = module.turns();
            module.sap(Ap::ReferenceSearchMode, mode);
            rfs(&mut module, START);
            while rfs(&mut module, STATUS) != 0 {
                lowest = lowest.min(module.turns());
                module.run_ticks(1);
            }
            assert_found(&mut module, mode, "from 0.2");
            // To cross the switch it goes beyond LEFT.0; at once or not, the slow ramp takes less than 0.01 turns.
            if mode == 1 {
                assert!(
                    (LEFT.1 - overrun - lowest - 0.005).abs() < 0.012,
                    "{lowest} turns, soft stop {soft}"
                );
            }
        }
    }
}

/// RFS STOP and MST slow down with the ramp; whatever else moves the motor takes over.
#[test]
fn stop_and_every_motion_command_abort_it() {
    let commands: [(Command, u8, i32, [i32; 3]); 8] = [
        (Command::ReferenceSearch, ABORT, 0, [1, 0, 0]),
        (Command::MotorStop, 0, 0, [1, 0, 0]),
        (Command::MoveToPosition, 0, 7000, [0, 0, 7000]),
        (Command::RotateRight, 0, 1000, [1, 1000, 0]),
        (Command::RotateLeft, 0, 1000, [1, -1000, 0]),
        (Command::SetAxisParameter, 0, -500, [0, 0, -500]),
        (Command::SetAxisParameter, 2, 100, [1, 100, 0]),
        (Command::SetAxisParameter, 128, 1, [1, 0, 0]),
    ];
    for (command, kind, value, [ramp_mode, velocity, target]) in commands {
        let mut module = at(0.0, 0.0);
        module.sap(Ap::ReferenceSearchMode, 1);
        rfs(&mut module, START);
        module.run_ms(300);
        assert_eq!(rfs(&mut module, STATUS), 1);
        let before = module.gap(Ap::ActualVelocity);
        assert!(before < -TURN / 2, "{before}");
        module.ok(command, kind, 0, value);
        assert_eq!(rfs(&mut module, STATUS), 0, "{command:?} {kind}");
        module.run_ticks(1);
        let change = module.gap(Ap::ActualVelocity) - before;
        assert!((0..=4 * TURN / 20_000 + 1).contains(&change), "with the ramp, not {change} pps in a tick");
        module.run_ms(1500);
        assert_eq!(module.gap(Ap::RampMode), ramp_mode, "{command:?} {kind}");
        if ramp_mode == 1 {
            assert_eq!(module.gap(Ap::ActualVelocity), velocity, "{command:?} {kind}");
        } else {
            assert_eq!(module.gap(Ap::ActualPosition), target, "{command:?} {kind}");
        }
    }
}

#[test]
fn stop_without_a_search_leaves_a_motion_alone() {
    let mut module = at(0.0, 0.0);
    move_to(&mut module, 9000);
    rfs(&mut module, ABORT);
    assert_eq!((rfs(&mut module, STATUS), module.gap(Ap::TargetPosition)), (0, 9000));
    module.arrive();
    assert_agree(&mut module, 0.0);
}

/// START while one runs begins anew, with the mode that AP 193 has by then.
#[test]
fn start_restarts_a_search() {
    let mut module = at(0.2, 0.0);
    module.sap(Ap::ReferenceSearchMode, 2);
    rfs(&mut module, START);
    module.run_ms(1500);
    assert_ne!(rfs(&mut module, STATUS), 0);
    search(&mut module, 5);
    assert_found(&mut module, 5, "restarted");
}

/// What the position is called meanwhile does not matter.
#[test]
fn writing_the_position_does_not_disturb_it() {
    let mut module = at(0.2, 0.0);
    module.sap(Ap::ReferenceSearchMode, 3);
    rfs(&mut module, START);
    while rfs(&mut module, STATUS) != 0 {
        module.sap(Ap::ActualPosition, 123_456);
        module.run_ms(77);
    }
    assert_found(&mut module, 3, "with SAP 1 all the time");
}

#[test]
fn in_a_program_it_is_started_waited_for_and_asked() {
    let mut module = at(0.0, 1.0);
    module.sap(Ap::ReferenceSearchMode, 1);
    module.download(&[
        op(Command::ReferenceSearch, START, 0, 0),
        op(Command::ReferenceSearch, STATUS, 0, 0),
        keep(0),
        wait(kind::RFS, 0),
        op(Command::ReferenceSearch, STATUS, 0, 0),
        keep(1),
        sio(0, 1),
        STOP,
    ]);
    module.set_variable(1, 99);
    module.run_from(0);
    module.run_to_stop(200_000);
    assert_eq!(module.refused(), []);
    assert_eq!((module.variable(0), module.variable(1)), (1, 0));
    assert_found(&mut module, 1, "in a program");
}

/// An aborted search is over too; one that takes too long is a timeout.
#[test]
fn wait_rfs_ends_with_an_abort_and_with_its_timeout() {
    let waiting = [op(Command::ReferenceSearch, START, 0, 0), wait(kind::RFS, 0), STOP];
    let mut module = at(0.0, 0.0);
    module.download(&waiting);
    module.run_from(0);
    module.run_ms(200);
    assert_eq!(module.status_of_program().0, 1);
    rfs(&mut module, ABORT);
    assert!(module.run_to_stop(10) <= 3);

    let mut module = at(0.0, 0.0);
    module.download(&[op(Command::ReferenceSearch, START, 0, 0), wait(kind::RFS, 20), STOP]);
    module.run_from(0);
    let ticks = module.run_to_stop(100_000);
    assert!(ticks.abs_diff(20 * WAIT_TICK) <= 4, "{ticks} ticks");
    assert_ne!(rfs(&mut module, STATUS), 0, "it searches on");
}

/// 138 is answered when the new zero is reached, not at a standstill on the way.
#[test]
fn the_position_reached_event_waits_for_the_end() {
    let mut module = at(0.0, 0.0);
    module.sap(Ap::ReferenceSearchMode, 1);
    rfs(&mut module, START);
    module.ok(Command::RequestPositionReachedEvent, 0, 0, 0);
    let mut standing = 0;
    let events = loop {
        let events = module.unasked();
        if !events.is_empty() {
            break events;
        }
        standing += i32::from(module.read("actual_velocity") == 0.0);
        module.run_ticks(1);
    };
    assert!(standing > 2000, "it stood on the way, for {standing} ticks");
    assert_eq!(events.len(), 1);
    assert_eq!(rfs(&mut module, STATUS), 0);
    assert_found(&mut module, 1, "reported");
}

/// Modes 5 and 6 run to and fro between the stop switches as long as no home switch is there.
#[test]
fn a_dead_home_switch_does_not_make_it_run_away() {
    for mode in [5, 6] {
        let mut module = at(0.0, 1.0);
        module.set("fault.switch_home", "closed");
        module.sap(Ap::ReferenceSearchMode, mode);
        rfs(&mut module, START);
        for _ in 0..10_000 {
            module.run_ms(1);
            assert!((-0.56..0.51).contains(&module.turns()), "mode {mode}: {} turns", module.turns());
        }
        assert_ne!(rfs(&mut module, STATUS), 0);
        module.set("fault.switch_home", "none");
        while rfs(&mut module, STATUS) != 0 {
            module.run_ms(1);
        }
        assert_found(&mut module, mode, "repaired");
    }
}

/// A cut wire is a switch that is pressed wherever the axis is. A search that would run into the other stop switch for that
/// gives up before the hard stop; looking for the home switch regardless of the stop switches is another matter.
#[test]
fn a_cut_wire_does_not_drive_the_axis_into_its_end() {
    for (mode, wire) in [(1, "switch_left"), (4, "switch_left"), (5, "switch_home"), (6, "switch_home")] {
        let mut module = at(0.0, 0.0);
        module.set(&format!("fault.{wire}"), "open");
        search(&mut module, mode);
        module.run_ms(300);
        let beyond = module.turns() - RIGHT;
        let before = module.turns() - LEFT.0;
        assert!(beyond < 0.01 && before > -0.01, "mode {mode}: {} turns", module.turns());
        assert_eq!(module.gap(Ap::ActualVelocity), 0);
    }
}

/// AP 18 shows the switches too.
#[test]
fn the_status_word_has_a_bit_for_each_switch() {
    for (turns, bit) in [(-0.52, 7), (0.12, 6), (0.52, 8)] {
        let mut module = at(turns, 0.0);
        assert_eq!((module.gap(Ap::StatusWord) >> 6) & 7, 1 << (bit - 6), "{turns} turns");
    }
}
