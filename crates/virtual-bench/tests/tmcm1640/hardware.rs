//! The TMCM-1640 with switches on its shaft (§5.1 AP 164, 166; bench file `[module.switches]`), and with wires that came off.

use crate::common::bldc::{Bldc, bench, fault};
use tmcl_tables::tmcm_1640::AxisParameter as Ap;

/// Switches at ±2 turns; their contacts open when they are pressed, which makes the input high.
fn between_switches(enabled: i32) -> Bldc {
    let mut axis =
        Bldc::strong_on(&bench("[module.switches]\nleft = { at_turns = -2.0 }\nright = { at_turns = 2.0 }"));
    axis.set_all(&[
        (Ap::MaxAcceleration, 20_000),
        (Ap::StopSwitchPolarity, 3),
        (Ap::StopSwitchEnable, enabled),
    ]);
    axis
}

/// Turned until it stands, or for 2 s.
fn turned_to(axis: &mut Bldc, rpm: i32) -> f64 {
    axis.rotate(rpm);
    axis.run_ms(2000);
    axis.turns()
}

#[test]
fn the_shaft_stops_at_its_switches() {
    let mut axis = between_switches(3);
    for (rpm, switch) in [(600, 2.0), (-600, -2.0), (1500, 2.0)] {
        let turns = turned_to(&mut axis, rpm);
        let beyond = (turns - switch) * switch.signum();
        assert!((0.0..0.7).contains(&beyond), "{rpm} rpm, {switch}: {}", axis.figures());
        assert!(axis.rpm().abs() < 15.0, "{}", axis.figures());
    }
}

#[test]
fn a_switch_that_is_not_enabled_is_passed() {
    let mut axis = between_switches(1);
    assert!(turned_to(&mut axis, 600) > 10.0, "{}", axis.figures());
    let mut axis = between_switches(2);
    assert!(turned_to(&mut axis, -600) < -10.0, "{}", axis.figures());
}

/// With the polarity of the other kind of switch, both are pressed until the shaft stands on one.
#[test]
fn the_wrong_polarity_keeps_the_shaft_where_it_is() {
    let mut axis = between_switches(3);
    axis.sap(Ap::StopSwitchPolarity, 0);
    for rpm in [600, -600] {
        let turns = turned_to(&mut axis, rpm);
        assert!(turns.abs() < 0.1, "{}", axis.figures());
    }
}

/// A cut wire looks like a pressed switch, and stops in the one direction.
#[test]
fn a_cut_wire_stops_like_its_switch() {
    let mut axis = between_switches(3);
    axis.set(fault::SWITCH_RIGHT, "open");
    assert!(turned_to(&mut axis, 600).abs() < 0.1, "{}", axis.figures());
    assert!(turned_to(&mut axis, -600) < -2.0, "{}", axis.figures());
    axis.set(fault::SWITCH_RIGHT, "none");
    assert!(turned_to(&mut axis, 600) > 2.0, "{}", axis.figures());
}

/// In torque mode and in position mode too.
#[test]
fn switches_end_torque_and_moves() {
    let mut axis = between_switches(3);
    axis.sap(Ap::TargetCurrent, 300);
    axis.run_ms(2000);
    assert!((2.0..4.0).contains(&axis.turns()) && axis.rpm().abs() < 15.0, "{}", axis.figures());
    let mut axis = between_switches(3);
    axis.go_by(24 * 20);
    axis.run_ms(3000);
    assert!((2.0..2.7).contains(&axis.turns()) && axis.rpm().abs() < 15.0, "{}", axis.figures());
    assert_eq!(axis.gap(Ap::PositionReached), 0);
}

/// Two phases that carry one current cannot turn a field: the torque comes in pulses. Nothing is worse than without the
/// fault for the power stage, and with the wire back the motor runs as before.
#[test]
fn an_open_phase_carries_nothing_and_leaves_nothing_behind() {
    for phase in ["u", "v", "w"] {
        let mut axis = Bldc::strong();
        axis.sap(Ap::MaxCurrent, 2000);
        axis.rotate(1000);
        axis.run_ms(1000);
        axis.set(fault::PHASE_OPEN, phase);
        axis.run_ms(5);
        let name = format!("physical.phase_{phase}_a");
        let (low, high) = axis.range(10_000, |axis| axis.read(&name));
        assert!(low.abs().max(high.abs()) < 1e-3, "phase {phase}: {low} to {high} A");
        axis.set(fault::PHASE_OPEN, "none");
        axis.run_ms(2000);
        let rpm = axis.mean(2000, |axis| axis.rpm());
        assert!((rpm / 1000.0 - 1.0).abs() < 0.03, "phase {phase}: {}", axis.figures());
    }
}

/// Held, the current that an open phase would need does not flow through the others.
#[test]
fn at_standstill_the_other_phases_carry_one_current() {
    let mut axis = Bldc::strong();
    axis.clamp();
    axis.set(fault::PHASE_OPEN, "w");
    axis.sap(Ap::TargetCurrent, 1000);
    axis.run_ms(500);
    let [u, v, w] = ["u", "v", "w"].map(|phase| axis.read(&format!("physical.phase_{phase}_a")));
    assert!(w.abs() < 1e-6 && (u + v).abs() < 1e-6 && u.abs() > 0.1, "{u} {v} {w} A");
}

/// Mode 2 of AP 249 turns until the N channel comes, however long, and hall commutation ends it.
#[test]
fn without_an_index_the_initialisation_turns_on_and_can_be_left() {
    let mut axis = Bldc::strong();
    axis.set_all(&[(Ap::InitSineMode, 2), (Ap::InitVelocity, 60), (Ap::StartCurrent, 2000)]);
    axis.set(fault::ENCODER_LINE, "index");
    axis.sap(Ap::CommutationMode, 7);
    axis.rotate(600);
    axis.run_ms(4000);
    assert!((3.5..4.2).contains(&axis.turns()), "{}", axis.figures());
    assert!(axis.amplitude_ma() < 2300.0, "{}", axis.figures());
    axis.set(fault::ENCODER_LINE, "none");
    axis.run_ms(2000);
    let rpm = axis.mean(2000, |axis| axis.rpm());
    assert!((rpm / 600.0 - 1.0).abs() < 0.02, "the index came: {}", axis.figures());

    axis.set(fault::ENCODER_LINE, "index");
    axis.sap(Ap::ReinitCommutation, 0);
    axis.run_ms(2000);
    axis.sap(Ap::CommutationMode, 6);
    axis.run_ms(1500);
    let rpm = axis.mean(4000, |axis| axis.rpm());
    assert!((rpm / 600.0 - 1.0).abs() < 0.05, "by halls: {}", axis.figures());
}

/// What is stored for the initialisation holds for that of power-on too, whatever the numbers' order.
#[test]
fn at_power_on_the_initialisation_is_the_stored_one() {
    use tmcl_tables::Command;
    let mut axis = Bldc::strong_on(&bench("[module.encoder]\noffset_turns = 0.3"));
    let stored = [
        (Ap::InitSineMode, 2),
        (Ap::InitVelocity, 60),
        (Ap::StartCurrent, 2000),
        (Ap::EncoderCommutationOffset, 819),
        (Ap::CommutationMode, 7),
    ];
    axis.set_all(&stored);
    for (parameter, _) in stored {
        axis.ok(Command::StoreAxisParameter, parameter.number(), 0, 0);
    }
    axis.place(0.4);
    let from = axis.turns();
    axis.power_cycle();
    axis.run_ms(2000);
    assert!((0.5..1.3).contains(&(axis.turns() - from)), "to the index: {}", axis.figures());
    assert_eq!(axis.gap(Ap::EncoderCommutationOffset), 819);
    axis.rotate(600);
    axis.run_ms(1500);
    let rpm = axis.mean(2000, |axis| axis.rpm());
    assert!((rpm / 600.0 - 1.0).abs() < 0.02, "{}", axis.figures());
}
