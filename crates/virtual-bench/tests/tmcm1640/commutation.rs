//! Where the TMCM-1640's commutation angle comes from (§5.1; decisions 6.3, 6.12): halls, encoder, initialisation, and what
//! happens when any of it is wrong. Judged by the rotor's true angle.

use crate::common::bldc::{Bldc, ELECTRICAL_TURN, apart_deg, bench, fault, flag};
use tmcl_tables::tmcm_1640::AxisParameter as Ap;

/// An electrical turn in turns of the rotor.
const PERIOD: f64 = 0.25;

/// Places in an electrical turn to begin from.
const STARTS: i32 = 12;

fn start(place: i32) -> f64 {
    PERIOD * (f64::from(place) + 0.4) / f64::from(STARTS)
}

/// The electrical angle of a parameter less the rotor's true one.
fn off_deg(axis: &mut Bldc, parameter: Ap) -> f64 {
    let read = f64::from(axis.gap(parameter));
    apart_deg(read, axis.electrical())
}

/// The largest error of an angle over so many control periods.
fn worst_deg(axis: &mut Bldc, parameter: Ap, ticks: u64) -> f64 {
    let (low, high) = axis.range(ticks, |axis| off_deg(axis, parameter));
    low.abs().max(high.abs())
}

/// Whether it turns as it was told, in the mean of half a second, when the regulator had its time.
fn turns_at(axis: &mut Bldc, rpm: i32) -> bool {
    axis.rotate(rpm);
    axis.run_ms(2500);
    let from = axis.turns();
    axis.run_ms(500);
    let mean = (axis.turns() - from) * 120.0;
    (mean / f64::from(rpm) - 1.0).abs() < 0.05
}

#[test]
fn hall_commutation_starts_from_any_angle_in_the_right_direction() {
    for place in 0..STARTS {
        for rpm in [500_i32, -500] {
            let mut axis = Bldc::strong();
            axis.place(start(place));
            let from = axis.turns();
            let sign = f64::from(rpm.signum());
            axis.rotate(rpm);
            let (farthest_back, _) = axis.range(10_000, |axis| (axis.turns() - from) * sign);
            assert!(farthest_back > -0.01, "place {place}, {rpm} rpm: {farthest_back:.4} turns back");
            assert!(turns_at(&mut axis, rpm), "place {place}, {rpm} rpm: {}", axis.figures());
        }
    }
}

/// Full torque at once: torque mode has no ramp.
#[test]
fn hall_commutation_makes_torque_from_any_angle() {
    for place in 0..STARTS {
        let mut axis = Bldc::strong();
        axis.place(start(place));
        axis.clamp();
        axis.sap(Ap::TargetCurrent, 4000);
        axis.run_ms(100);
        let current_q = axis.mean(200, |axis| axis.current_q_ma());
        assert!(current_q > 4000.0 * 0.85, "place {place}: {current_q:.0} mA along q of 4000");
    }
}

/// Without interpolation AP 210 is the middle of the sector: 30° off at most; 5461 is the first one's.
#[test]
fn the_hall_angle_is_the_middle_of_the_sector_that_the_rotor_is_in() {
    for place in 0..STARTS {
        let mut axis = Bldc::strong();
        axis.place(start(place));
        axis.clamp();
        let read = f64::from(axis.gap(Ap::ActualHallAngle)).rem_euclid(ELECTRICAL_TURN);
        let sector = (axis.electrical() / ELECTRICAL_TURN * 6.0).floor();
        let wanted = (sector + 0.5) * ELECTRICAL_TURN / 6.0;
        assert!(apart_deg(read, wanted).abs() < 0.5, "place {place}: AP 210 = {read}, sector {sector}");
    }
}

/// AP 252: extrapolated between the edges, the angle is far better while it turns evenly, and the torque smoother.
#[test]
fn interpolation_smooths_angle_and_torque() {
    let mut ripples = Vec::new();
    for interpolation in [0, 1] {
        let mut axis = Bldc::strong();
        axis.set_all(&[(Ap::HallInterpolation, interpolation), (Ap::MaxAcceleration, 5000)]);
        axis.set("load.friction_nm", 0.06);
        axis.rotate(2000);
        axis.run_ms(1000);
        let worst = worst_deg(&mut axis, Ap::ActualHallAngle, 2000);
        if interpolation == 0 {
            assert!((28.0..34.0).contains(&worst), "{worst:.1}° off without interpolation");
        } else {
            assert!(worst < 10.0, "{worst:.1}° off with interpolation");
        }
        let (low, high) = axis.range(2000, |axis| axis.read("physical.torque_nm"));
        ripples.push(high - low);
    }
    assert!(ripples[1] < 0.7 * ripples[0], "{ripples:?} Nm without and with interpolation");
}

#[test]
fn interpolation_does_not_disturb_standstill_and_reversal() {
    let mut axis = Bldc::strong();
    axis.sap(Ap::HallInterpolation, 1);
    for rpm in [1000, -1000, 300] {
        assert!(turns_at(&mut axis, rpm), "{rpm} rpm: {}", axis.figures());
    }
    axis.halt();
    axis.run_ms(1500);
    assert!(off_deg(&mut axis, Ap::ActualHallAngle).abs() < 33.0);
}

/// Mode 0: the offset is found by dragging the rotor to a known angle.
#[test]
fn initialisation_mode_0_finds_the_offset_from_any_angle() {
    for place in 0..STARTS {
        let mut axis = Bldc::strong();
        axis.place(start(place));
        axis.sap(Ap::StartCurrent, 2000);
        let before = axis.turns();
        axis.use_encoder();
        assert!((axis.turns() - before).abs() < 0.3, "it turns by an electrical turn at most");
        let off = off_deg(&mut axis, Ap::ActualEncoderAngle);
        assert!(off.abs() < 8.0, "place {place}: AP 211 is {off:.1}° off");
        // The encoder of this bench counts 0 at the shaft's 0, which is an electrical 0, and 1024 for an electrical turn. What
        // it counted before the module was switched on it cannot know: 0 here.
        let offset = f64::from(axis.gap(Ap::EncoderCommutationOffset));
        assert!((0.0..4096.0).contains(&offset), "AP 165 = {offset}");
        let wrong = offset / 1024.0 - (offset / 1024.0).round();
        assert!(wrong.abs() * 360.0 < 8.0, "place {place}: AP 165 = {offset}");
        assert!(turns_at(&mut axis, 600), "place {place}: {}", axis.figures());
    }
}

/// Mode 1: the halls commutate until the first edge tells the angle exactly; it need not go farther than that.
#[test]
fn initialisation_mode_1_uses_the_halls_from_any_angle() {
    for place in 0..STARTS {
        let mut axis = Bldc::strong();
        axis.sap(Ap::InitSineMode, 1);
        axis.place(start(place));
        let before = axis.turns();
        axis.sap(Ap::CommutationMode, 7);
        axis.run_ms(500);
        assert!((axis.turns() - before).abs() < 0.5, "place {place}: {}", axis.figures());
        for rpm in [600, -600] {
            assert!(turns_at(&mut axis, rpm), "place {place}: {}", axis.figures());
        }
        let worst = worst_deg(&mut axis, Ap::ActualEncoderAngle, 1000);
        assert!(worst < 5.0, "place {place}: AP 211 is {worst:.1}° off");
    }
}

/// Mode 2: turns slowly, at AP 241, to the N channel, where the offset set before is right.
#[test]
fn initialisation_mode_2_turns_to_the_index_from_any_angle() {
    for place in [0, 3, 7, 10] {
        let mut axis = Bldc::strong();
        axis.set_all(&[
            (Ap::InitSineMode, 2),
            (Ap::InitVelocity, 60),
            (Ap::EncoderCommutationOffset, 0),
            (Ap::StartCurrent, 2000),
        ]);
        axis.place(0.3 + start(place));
        axis.sap(Ap::CommutationMode, 7);
        axis.run_ms(400);
        let rpm = axis.mean(2000, |axis| axis.rpm());
        assert!((rpm / 60.0 - 1.0).abs() < 0.35, "place {place}: {rpm:.1} rpm on the way to the index");
        axis.run_ms(1500);
        assert_eq!(axis.gap(Ap::EncoderCommutationOffset), 0, "kept");
        assert!((0.9..1.6).contains(&axis.turns()), "place {place}: {}", axis.figures());
        let off = off_deg(&mut axis, Ap::ActualEncoderAngle);
        assert!(off.abs() < 4.0, "place {place}: AP 211 is {off:.1}° off");
        assert!(turns_at(&mut axis, 600), "place {place}: {}", axis.figures());
    }
}

/// AP 165 counts from the index: with the index elsewhere another offset is right.
#[test]
fn initialisation_mode_2_applies_the_stored_offset() {
    // The index is at 0.3 turns, an electrical 72°; the next electrical 0 is 819.2 counts on.
    let mut axis = Bldc::strong_on(&bench("[module.encoder]\noffset_turns = 0.3"));
    axis.set_all(&[
        (Ap::InitSineMode, 2),
        (Ap::InitVelocity, 60),
        (Ap::EncoderCommutationOffset, 819),
        (Ap::StartCurrent, 2000),
        (Ap::CommutationMode, 7),
    ]);
    axis.run_ms(1500);
    let off = off_deg(&mut axis, Ap::ActualEncoderAngle);
    assert!(off.abs() < 4.0, "AP 211 is {off:.1}° off");
    assert!(turns_at(&mut axis, 600), "{}", axis.figures());
}

#[test]
fn the_start_current_flows_during_the_controlled_initialisation() {
    for current in [500, 1500] {
        let mut axis = Bldc::strong();
        axis.set_all(&[(Ap::StartCurrent, current), (Ap::InitSineDelay, 1000), (Ap::CommutationMode, 7)]);
        axis.run_ms(300);
        let first = axis.mean(200, |axis| axis.amplitude_ma());
        let angle = f64::from(axis.gap(Ap::ActualControlledAngle));
        assert!(
            apart_deg(angle, ELECTRICAL_TURN / 4.0).abs() < 1.0,
            "AP 212 = {angle} in the first half: 90°"
        );
        axis.run_ms(500);
        let second = axis.mean(200, |axis| axis.amplitude_ma());
        let angle = f64::from(axis.gap(Ap::ActualControlledAngle));
        assert!(apart_deg(angle, 0.0).abs() < 1.0, "AP 212 = {angle} in the second half: 0°");
        for amplitude in [first, second] {
            let wanted = f64::from(current);
            assert!((amplitude / wanted - 1.0).abs() < 0.03, "{amplitude:.0} mA of AP 177 = {wanted}");
        }
        // The rotor stands where the field is, but for friction: 5 mNm of 31 or more for an ampere.
        let off = apart_deg(axis.electrical(), 0.0);
        assert!(off.abs() < 25.0, "{off:.1}° off the field");
    }
}

/// AP 244 is how long the whole takes.
#[test]
fn the_initialisation_lasts_axis_parameter_244() {
    for ms in [400, 1000] {
        let mut axis = Bldc::strong();
        axis.set_all(&[(Ap::InitSineDelay, ms), (Ap::StartCurrent, 2000), (Ap::CommutationMode, 7)]);
        axis.rotate(600);
        let mut took = 0;
        while axis.rpm() < 100.0 || axis.gap(Ap::RampVelocity) == 0 {
            axis.run_ms(1);
            took += 1;
            assert!(took < 2 * ms, "{}", axis.figures());
        }
        assert!((ms..ms + 150).contains(&took), "began to turn after {took} ms, AP 244 = {ms}");
    }
}

#[test]
fn motion_commands_during_initialisation_are_accepted_and_start_afterwards() {
    for mode in 0..3 {
        let mut axis = Bldc::strong();
        axis.set_all(&[(Ap::InitSineMode, mode), (Ap::InitVelocity, 60), (Ap::StartCurrent, 2000)]);
        axis.sap(Ap::CommutationMode, 7);
        axis.rotate(-800);
        assert_eq!(axis.gap(Ap::TargetVelocity), -800);
        axis.run_ms(2500);
        let mean = axis.mean(4000, |axis| axis.rpm());
        assert!((mean / -800.0 - 1.0).abs() < 0.02, "mode {mode}: {mean:.1} rpm; {}", axis.figures());
    }
    let mut axis = Bldc::strong();
    axis.sap(Ap::CommutationMode, 7);
    axis.go_by(4096);
    assert_eq!(axis.gap(Ap::PositionReached), 0);
    axis.run_ms(800);
    assert_eq!(axis.gap(Ap::PositionReached), 0, "not while it initialises");
    let target = axis.gap(Ap::TargetPosition);
    axis.reach(3000);
    axis.run_ms(3000);
    let off = axis.gap(Ap::ActualPosition) - target;
    assert!(off.abs() <= 6, "{off}; {}", axis.figures());
}

#[test]
fn axis_parameter_31_and_writing_159_again_initialise_anew() {
    for again in [Ap::ReinitCommutation, Ap::CommutationMode] {
        let mut axis = Bldc::strong();
        axis.sap(Ap::StartCurrent, 2000);
        axis.use_encoder();
        axis.sap(Ap::EncoderCommutationOffset, axis_offset_wrong());
        axis.sap(again, 7);
        axis.run_ms(300);
        let current = axis.amplitude_ma();
        assert!((current / 2000.0 - 1.0).abs() < 0.05, "{again:?}: {current:.0} mA");
        axis.run_ms(1000);
        let off = off_deg(&mut axis, Ap::ActualEncoderAngle);
        assert!(off.abs() < 8.0, "{again:?}: {off:.1}° off");
        assert!(turns_at(&mut axis, 600), "{again:?}: {}", axis.figures());
    }
}

/// A quarter of an electrical turn of 1024 counts.
const fn axis_offset_wrong() -> i32 {
    256
}

/// Only 159, 31 and power-on start it (decisions 6.12).
#[test]
fn writing_249_to_251_starts_nothing() {
    let mut axis = Bldc::strong();
    axis.use_encoder();
    let before = axis.turns();
    for (parameter, value) in
        [(Ap::InitSineMode, 0), (Ap::EncoderResolution, 4096), (Ap::EncoderDirection, 0)]
    {
        axis.sap(parameter, value);
        axis.run_ms(100);
        assert!(axis.amplitude_ma() < 300.0, "{parameter:?}: {:.0} mA", axis.amplitude_ma());
    }
    assert!((axis.turns() - before).abs() < 0.01);
}

#[test]
fn a_module_that_starts_with_the_encoder_initialises_at_power_on() {
    let mut axis = Bldc::strong();
    axis.sap(Ap::CommutationMode, 7);
    axis.ok(tmcl_tables::Command::StoreAxisParameter, Ap::CommutationMode.number(), 0, 0);
    axis.run_ms(1200);
    axis.place(axis.turns() + 0.11);
    axis.power_cycle();
    axis.run_ms(1200);
    assert_eq!(axis.gap(Ap::CommutationMode), 7);
    let off = off_deg(&mut axis, Ap::ActualEncoderAngle);
    assert!(off.abs() < 14.0, "{off:.1}° off; {}", axis.figures());
    assert!(turns_at(&mut axis, 600), "{}", axis.figures());
}

#[test]
fn the_encoder_angle_follows_the_rotor() {
    let mut axis = Bldc::aligned();
    axis.sap(Ap::MaxAcceleration, 8000);
    for rpm in [0, 100, -1000, 3000] {
        axis.rotate(rpm);
        axis.run_ms(1000);
        let worst = worst_deg(&mut axis, Ap::ActualEncoderAngle, 500);
        // A control period at 3000 rpm is 3.6 electrical degrees.
        let period = f64::from(rpm.abs()) / 60.0 * 4.0 * 360.0 * 50e-6;
        assert!(worst < 5.0 + 2.0 * period, "{rpm} rpm: {worst:.1}° off");
    }
}

mod wrong {
    use super::*;

    #[test]
    fn an_inverted_encoder_fails_visibly_and_axis_parameter_251_mends_it() {
        let inverted = bench("[module.encoder]\ninverted = true");
        for (bench_file, direction, works) in
            [(bench(""), 0, true), (bench(""), 1, false), (inverted.clone(), 0, false), (inverted, 1, true)]
        {
            let mut axis = Bldc::strong_on(&bench_file);
            axis.sap(Ap::EncoderDirection, direction);
            axis.use_encoder();
            assert_eq!(turns_at(&mut axis, 600), works, "{direction} on {bench_file}: {}", axis.figures());
        }
    }

    #[test]
    fn a_wrong_pole_count_fails_visibly() {
        for poles in [2, 4, 6, 10, 14] {
            let mut axis = Bldc::strong();
            axis.sap(Ap::MotorPoles, poles);
            axis.use_encoder();
            assert!(!turns_at(&mut axis, 600), "{poles} poles: {}", axis.figures());
        }
    }

    #[test]
    fn a_wrong_encoder_resolution_fails_visibly() {
        for counts in [2048, 4000, 10_000] {
            let mut axis = Bldc::strong();
            axis.sap(Ap::EncoderResolution, counts);
            axis.use_encoder();
            assert!(!turns_at(&mut axis, 600) || counts == 4000, "{counts}: {}", axis.figures());
            if counts == 4000 {
                axis.run_ms(2000);
                assert!(!turns_at(&mut axis, 600), "{counts} counts drift away: {}", axis.figures());
            }
        }
    }

    #[test]
    fn a_dead_encoder_line_fails_visibly() {
        for line in ["a", "b"] {
            let mut axis = Bldc::strong();
            axis.use_encoder();
            axis.set(fault::ENCODER_LINE, line);
            assert!(!turns_at(&mut axis, 600), "{line}: {}", axis.figures());
        }
    }

    /// Turned by hand through every sector, a line that is stuck shows 000 or 111 somewhere.
    #[test]
    fn a_dead_hall_line_raises_the_hall_error_flag() {
        for line in fault::HALLS {
            for level in ["low", "high"] {
                let mut axis = Bldc::strong();
                axis.sap(Ap::EnableDriver, 0);
                axis.set("load.torque_nm", 0.012);
                axis.run_ms(100);
                assert!(!axis.flag(flag::HALL_ERROR));
                axis.set(line, level);
                let mut seen = 0;
                let from = axis.turns();
                while axis.turns() - from < 4.0 * PERIOD {
                    axis.run_ticks(1);
                    seen += u32::from(axis.flag(flag::HALL_ERROR));
                }
                assert!(seen > 0, "{line} {level}: no hall error");
                axis.set(line, "none");
                axis.run_ms(50);
                assert!(!axis.flag(flag::HALL_ERROR), "{line} {level}: the flag resets itself");
            }
        }
    }

    #[test]
    fn a_dead_hall_line_fails_visibly_when_it_should_turn() {
        for line in fault::HALLS {
            for level in ["low", "high"] {
                let mut axis = Bldc::strong();
                assert!(turns_at(&mut axis, 600));
                axis.set(line, level);
                let mut flagged = false;
                let (slowest, fastest) = axis.range(10_000, |axis| {
                    flagged |= axis.flag(flag::HALL_ERROR);
                    axis.rpm()
                });
                let uneven = slowest < 540.0 || fastest > 660.0;
                assert!(
                    flagged || uneven,
                    "{line} {level}: {slowest:.0} to {fastest:.0} rpm and no hall error"
                );
            }
        }
    }

    #[test]
    fn inverted_halls_fail_visibly_and_axis_parameter_254_mends_them() {
        let inverted = bench("[module.halls]\ninverted = true");
        for (bench_file, invert, works) in
            [(bench(""), 0, true), (bench(""), 1, false), (inverted.clone(), 0, false), (inverted, 1, true)]
        {
            let mut axis = Bldc::strong_on(&bench_file);
            axis.sap(Ap::HallSensorInvert, invert);
            assert_eq!(turns_at(&mut axis, 600), works, "AP 254 = {invert}: {}", axis.figures());
        }
    }
}
