//! Into closed loop and out of it: AP 129, 133, the alignment and the position counter, judged by where the rotor stands
//! (TMCM-1311 §8.1, §8.3; decisions §2, 2a.8, 5.4).

use crate::common::closed_loop::{
    Axis, MOTOR, MOTORS, amplitude_a, bench, bit, electrical_deg, full_torque_nm, rms_a, try_initialize,
};
use crate::common::motion::{SLACK, finish, move_to};
use crate::common::{Module, TICKS_PER_MS, TURN};
use tmcl_tables::tmcm_1311::AxisParameter as Ap;
use tmcl_tables::{Command, Status};

/// What friction and detent torque leave between field and rotor at rest, in encoder steps of 40 000.
const FIELD_STEPS: f64 = 8.0;

fn close(module: &mut Module) -> Status {
    module.status(Command::SetAxisParameter, Ap::ClosedLoopMode.number(), 0, 1)
}

/// Neither initialised nor in closed loop, and the open loop works: a turn is a turn.
#[track_caller]
fn assert_open(module: &mut Module, what: &str) {
    let readings = [Ap::ClosedLoopMode, Ap::ClosedLoopInitialized].map(|parameter| module.gap(parameter));
    assert_eq!(readings, [0, 0], "{what}: AP 129 and 133");
    assert_eq!(module.gap(Ap::StatusWord) >> bit::CLOSED_LOOP & 1, 0, "{what}: bit 2 of AP 18");
    module.run_ms(300);
    let before = module.turns();
    module.ok(Command::MoveToPosition, 1, 0, TURN);
    finish(module);
    module.run_ms(300);
    let turned = module.turns() - before;
    assert!((turned - 1.0).abs() < 2.0 * SLACK, "{what}: open loop turned {turned} turns, not 1");
}

#[test]
fn it_aligns_the_rotor_within_the_time() {
    for (motor, max_current) in MOTORS {
        let mut module = Module::on(&bench(motor, 40_000, ""));
        module.sap(Ap::MaxCurrent, max_current);
        module.sap(Ap::EncoderOffset, 0);
        module.run_ms(50);
        assert_eq!(close(&mut module), Status::Ok);
        assert_eq!(module.gap(Ap::ClosedLoopInitialized), 0, "{motor}: not at once");
        assert_eq!(module.gap(Ap::ClosedLoopMode), 1, "{motor}: under way");
        module.run_ms(300);
        let (flows, wanted) = (amplitude_a(&module), std::f64::consts::SQRT_2 * rms_a(max_current));
        assert!((flows / wanted - 1.0).abs() < 0.03, "{motor}: aligns with {flows} A, AP 6 is {wanted} A");
        let mut ticks = 300 * TICKS_PER_MS;
        while module.gap(Ap::ClosedLoopInitialized) == 0 {
            assert!(
                ticks < 26_000,
                "{motor}: AP 133 still 0 after 1.3 s; AP 129 = {}",
                module.gap(Ap::ClosedLoopMode)
            );
            module.run_ticks(1);
            ticks += 1;
        }
        let [target, position, counter] = [Ap::TargetPosition, Ap::ActualPosition, Ap::EncoderCounter]
            .map(|parameter| module.gap(parameter));
        assert_eq!(position, counter, "{motor}: AP 1 is AP 209");
        assert!((target - position).abs() <= 1, "{motor}: AP 0 = {target}, AP 1 = {position}");
        assert!(position.abs() <= 1, "{motor}: nothing was moved before, AP 1 = {position}");
        let off_deg = electrical_deg(&module);
        assert!(off_deg.abs() < 6.0, "{motor}: the rotor is {off_deg:.1}° electrical from the field at 0°");
        assert_eq!(module.gap(Ap::EncoderOffset), 0, "{motor}: AP 112 is the user's");
        let status = module.gap(Ap::StatusWord);
        assert_eq!(status >> bit::CLOSED_LOOP & 1, 1, "{motor}: bit 2 of AP 18 = {status:#b}");
        assert_eq!(status >> bit::POSITION & 1, 1, "{motor}: bit 3 of AP 18 = {status:#b}");
    }
}

#[test]
fn it_succeeds_for_every_motor_and_resolution() {
    for (motor, max_current) in MOTORS {
        for counts in [1000, 4000, 10_000, 16_384, 40_000] {
            let mut axis = Axis::on(&bench(motor, counts, ""), counts, &[(Ap::MaxCurrent, max_current)]);
            let off_deg = electrical_deg(&axis);
            assert!(off_deg.abs() < 6.0, "{motor}, {counts}: {off_deg:.1}° electrical off");
            // A tenth of a second later it still stands there: nothing runs away.
            axis.run_ms(100);
            let turned = axis.turns() - axis.zero_turns;
            assert!(turned.abs() < 2.5 / 200.0, "{motor}, {counts}: {turned} turns from AP 1 = 0");
            axis.assert_agrees();
        }
    }
}

/// The rotor may stand anywhere relative to the field: it was turned by hand while the driver was off. Exactly opposite to
/// the first field there is no torque, and the rotor may come from the wrong side: that must be seen, and work the second
/// time.
#[test]
fn the_rotor_may_stand_anywhere_in_the_electrical_period() {
    for sixteenth in 0..16 {
        let what = format!("rotor at {sixteenth}/16 of the period");
        let load = "friction_nm = 0.05\n[module.encoder]\noffset_turns = 0.003";
        let mut module = Module::on(&format!("[[module]]\nkind = \"tmcm-1311\"\n[module.load]\n{load}"));
        module.run_ms(50);
        move_to(&mut module, sixteenth * 64);
        finish(&mut module);
        module.run_ms(100);
        module.sap(Ap::ChopperOffTime, 0);
        move_to(&mut module, 0);
        finish(&mut module);
        module.run_ms(20);
        module.set("load.friction_nm", 0.01);
        module.sap(Ap::ChopperOffTime, 5);
        if try_initialize(&mut module).is_none() {
            assert!((11..=13).contains(&sixteenth), "{what}: the initialisation failed");
            let again = try_initialize(&mut module);
            assert!(again.is_some(), "{what}: it failed the second time too");
        }
        let off_deg = electrical_deg(&module);
        assert!(off_deg.abs() < 6.0, "{what}: {off_deg:.1}° electrical off afterwards");
        let counter = module.gap(Ap::ActualPosition);
        let zero_turns = module.turns() - f64::from(counter) / 40_000.0;
        let mut axis = Axis { module, zero_turns, counts: 40_000.0 };
        axis.set_all(&[(Ap::MaxVelocity, 2 * TURN), (Ap::MaxAcceleration, 10 * TURN)]);
        axis.land(counter + 30_000);
        axis.land(counter - 10_000);
    }
}

/// The index means nothing to it.
#[test]
fn it_does_not_need_the_index() {
    for encoder in ["index = false", "offset_turns = 0.002", "offset_turns = -0.4"] {
        let mut axis =
            Axis::on(&format!("[[module]]\nkind = \"tmcm-1311\"\n[module.encoder]\n{encoder}"), 40_000, &[]);
        axis.land(20_000);
    }
}

#[test]
fn an_encoder_too_coarse_is_refused() {
    for (resolution, full_steps, status) in [
        (400, 200, Status::InvalidValue),
        (399, 200, Status::InvalidValue),
        (0, 200, Status::InvalidValue),
        (800, 400, Status::InvalidValue),
        (401, 200, Status::Ok),
    ] {
        let mut module = Module::new();
        module.sap(Ap::EncoderResolution, resolution);
        module.sap(Ap::MotorFullSteps, full_steps);
        assert_eq!(close(&mut module), status, "AP 210 = {resolution}, AP 202 = {full_steps}");
        assert_eq!(module.gap(Ap::ClosedLoopMode), i32::from(status == Status::Ok));
    }
}

#[test]
fn it_is_refused_while_the_motor_moves() {
    let mut module = Module::new();
    module.ok(Command::RotateRight, 0, 0, TURN);
    module.run_ms(500);
    assert_eq!(close(&mut module), Status::InvalidValue, "turning");
    assert_eq!(module.gap(Ap::ClosedLoopMode), 0);
    module.ok(Command::MotorStop, 0, 0, 0);
    module.run_ms(100);
    assert_eq!(close(&mut module), Status::InvalidValue, "slowing down");
    module.run_ms(1500);
    assert_eq!(close(&mut module), Status::Ok, "at rest");
}

#[test]
fn torque_mode_needs_it() {
    let mut module = Module::new();
    let torque = |module: &mut Module| {
        [(Ap::TorqueTargetCurrent, 100), (Ap::RampMode, 2)]
            .map(|(parameter, value)| module.status(Command::SetAxisParameter, parameter.number(), 0, value))
    };
    assert_eq!(torque(&mut module), [Status::NotAvailable; 2], "in open loop");
    assert_eq!(close(&mut module), Status::Ok);
    module.run_ms(200);
    assert_eq!(torque(&mut module), [Status::NotAvailable; 2], "before AP 133 is set");
    module.run_ms(1200);
    assert_eq!(torque(&mut module), [Status::Ok; 2], "afterwards");
    module.ok(Command::MotorStop, 0, 0, 0);
    module.run_ms(5000);
    module.sap(Ap::ClosedLoopMode, 0);
    assert_eq!(torque(&mut module), [Status::NotAvailable; 2], "in open loop again");
}

#[test]
fn it_fails_where_the_encoder_does_not_follow() {
    for line in ["a", "b"] {
        let mut module = Module::new();
        module.set("fault.encoder_line", line);
        assert_eq!(try_initialize(&mut module), None, "line {line} is dead, yet AP 133 is set");
        assert_open(&mut module, &format!("line {line} dead"));
    }
}

#[test]
fn it_fails_where_the_channels_are_swapped() {
    let mut module = Module::on("[[module]]\nkind = \"tmcm-1311\"\n[module.encoder]\ninverted = true\n");
    assert_eq!(try_initialize(&mut module), None, "the encoder counts down, yet AP 133 is set");
    assert_open(&mut module, "swapped channels");
}

#[test]
fn it_fails_where_the_rotor_is_blocked() {
    let mut module = Module::new();
    module.run_ms(10);
    module.set("load.friction_nm", 5);
    assert_eq!(try_initialize(&mut module), None, "the rotor is stuck, yet AP 133 is set");
    module.set("load.friction_nm", 0.01);
    assert_open(&mut module, "was blocked");
    assert!(try_initialize(&mut module).is_some(), "free again, it fails still");
}

/// A resolution that is wrong by half or double moves by too many or too few counts.
#[test]
fn it_fails_where_the_resolution_is_wrong() {
    for (counts, resolution) in [(40_000, 20_000), (4000, 8000), (4000, 40_000)] {
        let mut module = Module::on(&bench(MOTOR, counts, ""));
        module.sap(Ap::EncoderResolution, resolution);
        let done = try_initialize(&mut module);
        assert_eq!(done, None, "{counts} counts are taken for {resolution}");
        assert_open(&mut module, &format!("{counts} taken for {resolution}"));
    }
}

/// A turn is still a turn: µsteps become encoder steps, and back.
#[test]
fn the_position_is_converted_both_ways() {
    for counts in [4000, 16_384, 40_000] {
        let per_step = f64::from(counts) / 40_000.0;
        for turns in [0, 1, -3] {
            let what = format!("{counts} counts, {turns} turns");
            let mut module = Module::on(&bench(MOTOR, counts, ""));
            module.set_speed();
            module.sap(Ap::EncoderResolution, counts);
            move_to(&mut module, turns * TURN);
            finish(&mut module);
            module.run_ms(200);
            // In open loop the encoder's counter is independent.
            module.sap(Ap::EncoderCounter, 777);
            assert!(try_initialize(&mut module).is_some(), "{what}: failed");
            let [target, position, counter] = [Ap::TargetPosition, Ap::ActualPosition, Ap::EncoderCounter]
                .map(|parameter| module.gap(parameter));
            assert_eq!(position, counter, "{what}: AP 1 is AP 209");
            let tolerance = (FIELD_STEPS * per_step).max(1.0) as i32;
            assert!((target - turns * counts).abs() <= tolerance, "{what}: AP 0 = {target}");
            assert!((position - turns * counts).abs() <= tolerance, "{what}: AP 1 = {position}");
            let virtual_position = module.gap(Ap::VirtualPosition);
            let off = f64::from(virtual_position) - f64::from(position) * f64::from(TURN) / f64::from(counts);
            assert!(off.abs() <= 20.0, "{what}: AP 233 = {virtual_position}, AP 1 = {position}");
            assert_true(&mut module, counts, &what);

            let elsewhere = turns * counts + counts * 3 / 2;
            module.ok(Command::MoveToPosition, 0, 0, elsewhere);
            module.run_ms(2500);
            assert_eq!(
                module.gap(Ap::PositionReached),
                1,
                "{what}: AP 1 = {}",
                module.gap(Ap::ActualPosition)
            );
            assert_true(&mut module, counts, &what);
            let (before, shaft) = (module.gap(Ap::ActualPosition), module.turns());
            module.sap(Ap::ClosedLoopMode, 0);
            assert_eq!(module.gap(Ap::ClosedLoopInitialized), 0, "{what}: AP 133");
            let position = module.gap(Ap::ActualPosition);
            let expected = f64::from(before) * f64::from(TURN) / f64::from(counts);
            // Within a full step: the open loop's field may have to take over where the rotor is.
            assert!(
                (f64::from(position) - expected).abs() <= 20.0,
                "{what}: AP 1 = {position}, not {expected}"
            );
            assert_eq!(module.gap(Ap::TargetPosition), position, "{what}: nothing shall move");
            module.run_ms(300);
            let moved = module.turns() - shaft;
            assert!(moved.abs() < 1.0 / 400.0, "{what}: opening the loop moved the rotor by {moved} turns");
            move_to(&mut module, 0);
            finish(&mut module);
            module.run_ms(300);
            let left = module.turns();
            assert!(left.abs() < SLACK, "{what}: back at µstep 0 the rotor is at {left} turns");
        }
    }
}

/// The alignment turns the rotor from wherever it stands to a field of 0°, and the counter goes with it.
#[test]
fn the_position_stays_true_through_the_alignment() {
    for position in
        [100, 256, 300, 511, 513, 700, 900, 1023, TURN + 300, TURN + 800, -300, -800, -5 * TURN - 1]
    {
        let mut module = Module::new();
        module.set_speed();
        move_to(&mut module, position);
        finish(&mut module);
        module.run_ms(300);
        let done = try_initialize(&mut module);
        assert!(done.is_some(), "after MVP ABS {position} the initialisation failed");
        let off_deg = electrical_deg(&module);
        assert!(off_deg.abs() < 6.0, "after {position}: {off_deg:.1}° electrical off");
        assert_true(&mut module, 40_000, &format!("after {position} µsteps"));
        let [target, reading] =
            [Ap::TargetPosition, Ap::ActualPosition].map(|parameter| module.gap(parameter));
        assert!((target - reading).abs() <= 1, "after {position}: AP 0 = {target}, AP 1 = {reading}");
    }
}

/// Opposite to the first field, at 270°, too: in open loop the module knows where the rotor stands.
#[test]
fn no_position_is_bad_for_the_alignment() {
    for position in [764, 767, 768, 769, 772, 768 - 1024] {
        let mut module = Module::new();
        module.set_speed();
        move_to(&mut module, position);
        finish(&mut module);
        module.run_ms(300);
        assert!(try_initialize(&mut module).is_some(), "after MVP ABS {position} the initialisation failed");
        assert_true(&mut module, 40_000, &format!("after {position} µsteps"));
    }
}

/// A weight that the open loop holds does not fall while the field is aligned.
#[test]
fn a_weight_is_held_through_the_alignment() {
    for load_nm in [0.1, -0.1] {
        let mut module = Module::on(&bench(MOTOR, 40_000, &format!("torque_nm = {load_nm:.2}")));
        module.run_ms(100);
        let before = module.turns();
        let done = try_initialize(&mut module);
        let moved = module.turns() - before;
        assert!(
            done.is_some() && moved.abs() < 0.01,
            "{load_nm} Nm, a sixth of what AP 6 holds: done after {done:?} ticks, the shaft moved by {moved} turns"
        );
        // Known to the load angle.
        let position = f64::from(module.gap(Ap::ActualPosition)) / 40_000.0;
        let off = position - module.turns();
        assert!(off.abs() < 0.001, "{load_nm} Nm: AP 1 is {position} turns, {off} off");
    }
}

/// Out and in again, as often as one likes: no drift, and no step lost.
#[test]
fn it_can_be_repeated() {
    let mut module = Module::new();
    module.set_speed();
    for round in 1..=4 {
        assert!(try_initialize(&mut module).is_some(), "round {round} failed");
        module.ok(Command::MoveToPosition, 0, 0, round * 7777);
        module.run_ms(1500);
        assert_eq!(module.gap(Ap::PositionReached), 1, "round {round}");
        assert_true(&mut module, 40_000, &format!("round {round}, closed"));
        module.sap(Ap::ClosedLoopMode, 0);
        module.run_ms(200);
        move_to(&mut module, round * 9999);
        finish(&mut module);
        module.run_ms(200);
        let off = f64::from(module.gap(Ap::ActualPosition)) / f64::from(TURN) - module.turns();
        assert!(off.abs() < SLACK, "round {round}, open: {off} turns off");
    }
}

/// What closed loop holds, it holds with the torque of AP 6: a rotor that is aligned well.
#[test]
fn the_alignment_is_good_for_the_full_torque() {
    for (sign, motor, max_current) in [(1.0, MOTOR, 231), (-1.0, MOTOR, 231), (1.0, "QSH4218-51-10-049", 79)]
    {
        let mut axis = Axis::on(
            &bench(motor, 40_000, ""),
            40_000,
            &[(Ap::MaxCurrent, max_current), (Ap::CurrentScaleEnable, 0)],
        );
        let load_nm = sign * 0.8 * full_torque_nm(motor, rms_a(max_current));
        // Slowly, lest the swing adds to it.
        for percent in 1..=100 {
            axis.set("load.torque_nm", load_nm * f64::from(percent) / 100.0);
            axis.run_ms(10);
        }
        axis.run_ms(500);
        let figures = axis.figures();
        let slipped = (axis.shaft() / 40_000.0).abs();
        assert!(
            slipped < 0.01,
            "{load_nm:.3} Nm, 80 % of what it can, turned the shaft by {slipped} turns; {figures}"
        );
        axis.set("load.torque_nm", 0);
        axis.run_ms(1000);
        axis.assert_at(0);
    }
}

/// AP 1 and the shaft agree, the shaft counting from power-on.
#[track_caller]
fn assert_true(module: &mut Module, counts: i32, what: &str) {
    let position = f64::from(module.gap(Ap::ActualPosition));
    let shaft = module.turns() * f64::from(counts);
    let tolerance = (FIELD_STEPS * f64::from(counts) / 40_000.0).max(2.0);
    assert!((position - shaft).abs() <= tolerance, "{what}: AP 1 = {position}, the shaft is at {shaft:.1}");
}

impl Module {
    fn set_speed(&mut self) {
        self.sap(Ap::MaxVelocity, 2 * TURN);
        self.sap(Ap::MaxAcceleration, 10 * TURN);
    }
}
