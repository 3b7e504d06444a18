//! Stop switches: what they stop, how, and what they let pass (TMCM-1311 §6, AP 9 to 13, 149; §10.1, GP 79; decisions 5.10).

use crate::common::motion::{SLACK, move_to};
use crate::common::program::{listening, sgp};
use crate::common::{Module, TURN};
use tmcl_tables::tmcm_1311::AxisParameter as Ap;
use tmcl_tables::{Command, GlobalParameter as Gp};

const BENCH: &str = "[[module]]\nkind = \"tmcm-1311\"\n[module.switches]\nleft = { at_turns = -0.5, bounce_ms = 2.0 }\nright = { at_turns = 0.5, bounce_ms = 2.0 }\n";

/// A side, as seen in a mirror: its sign, its fault setting, its parameters.
const SIDES: [(i32, &str, Ap, Ap, Command); 2] = [
    (-1, "fault.switch_left", Ap::LeftLimitSwitch, Ap::LeftLimitSwitchDisable, Command::RotateLeft),
    (1, "fault.switch_right", Ap::RightLimitSwitch, Ap::RightLimitSwitchDisable, Command::RotateRight),
];

fn module() -> Module {
    let mut module = Module::on(BENCH);
    module.sap(Ap::MaxAcceleration, 2 * TURN);
    module
}

/// Runs until the switch is hit, and returns how fast the motor is in the tick after.
#[track_caller]
fn hit(module: &mut Module, switch: Ap) -> i32 {
    for _ in 0..60_000 {
        if module.gap(switch) == 1 {
            module.run_ticks(1);
            return module.gap(Ap::ActualVelocity);
        }
        module.run_ticks(1);
    }
    panic!("the switch is never hit");
}

#[test]
fn motion_into_a_switch_stops_at_once_where_the_switch_is() {
    for (sign, _, switch, _, rotate) in SIDES {
        for by_position in [false, true] {
            let mut module = module();
            if by_position {
                move_to(&mut module, sign * 2 * TURN);
            } else {
                module.ok(rotate, 0, 0, 40_000);
            }
            assert_eq!(hit(&mut module, switch), 0);
            module.run_ms(1000);
            let turns = module.turns() * f64::from(sign);
            assert!((turns - 0.5).abs() < 0.001, "{turns} turns");
            assert_eq!(module.gap(Ap::ActualVelocity), 0);
            // The target stays, and it is not reached (decisions 5.10).
            assert_eq!(module.gap(Ap::PositionReached), 0);
            let (target, value) = if by_position {
                (Ap::TargetPosition, sign * 2 * TURN)
            } else {
                (Ap::TargetVelocity, sign * 40_000)
            };
            assert_eq!(module.gap(target), value);
            assert_eq!(module.gap(Ap::RampMode), i32::from(!by_position));
        }
    }
}

/// v²/2a at one turn a second and two turns/s² is a quarter of a turn.
#[test]
fn a_soft_stop_slows_down_with_the_ramp() {
    for (sign, _, switch, _, rotate) in SIDES {
        let mut module = module();
        module.sap(Ap::SoftStop, 1);
        module.ok(rotate, 0, 0, TURN);
        let velocity = hit(&mut module, switch) * sign;
        assert!((TURN - 20..TURN).contains(&velocity), "{velocity} pps");
        module.run_ms(1500);
        let turns = module.turns() * f64::from(sign);
        assert!((turns - 0.75).abs() < SLACK, "{turns} turns");
        assert_eq!(module.gap(Ap::ActualVelocity), 0);
        assert_eq!(module.gap(Ap::TargetVelocity), sign * TURN);
    }
}

#[test]
fn once_the_switch_is_released_or_disabled_the_motor_goes_on() {
    for (sign, fault, _, disable, rotate) in SIDES {
        for disabled in [false, true] {
            for by_position in [false, true] {
                let mut module = module();
                module.set(fault, "open");
                module.run_ticks(1);
                if by_position {
                    move_to(&mut module, sign * TURN / 4);
                } else {
                    module.ok(rotate, 0, 0, 1000);
                }
                module.run_ms(500);
                assert_eq!(module.gap(Ap::ActualPosition), 0);
                // In velocity mode too, although the old target is where it stands.
                assert_eq!(module.gap(Ap::PositionReached), 0);
                if disabled {
                    module.sap(disable, 1);
                } else {
                    module.set(fault, "none");
                }
                if by_position {
                    module.arrive();
                    assert_eq!(module.gap(Ap::ActualPosition), sign * TURN / 4);
                } else {
                    module.run_ms(500);
                    assert_eq!(module.gap(Ap::ActualVelocity), sign * 1000);
                }
            }
        }
    }
}

/// Status 100, and no step: not even one, whatever the ramp's start velocity.
#[test]
fn a_motion_towards_an_active_switch_is_accepted_and_does_not_begin() {
    for (sign, fault, switch, _, rotate) in SIDES {
        let mut module = module();
        module.sap(Ap::StartStopVelocity, 20_000);
        module.set(fault, "open");
        module.run_ms(1);
        assert_eq!(module.gap(switch), 1);
        for soft in [0, 1] {
            module.sap(Ap::SoftStop, soft);
            module.ok(rotate, 0, 0, 30_000);
            module.run_ms(200);
            move_to(&mut module, sign * 1000);
            module.run_ms(200);
            assert_eq!(module.gap(Ap::ActualPosition), 0);
            assert!(module.turns().abs() < 0.001);
        }
    }
}

#[test]
fn motion_away_from_an_active_switch_is_free() {
    for (sign, _, switch, _, rotate) in SIDES {
        let mut module = module();
        module.ok(rotate, 0, 0, 30_000);
        hit(&mut module, switch);
        module.run_ms(100);
        assert_eq!(module.gap(switch), 1);
        move_to(&mut module, 0);
        module.arrive();
        assert!(module.turns().abs() < SLACK);
        assert_eq!((module.gap(switch), module.gap(Ap::ActualPosition)), (0, 0));
        module.ok(rotate, 0, 0, 30_000);
        hit(&mut module, switch);
        module.ok(rotate, 0, 0, -30_000);
        module.run_ms(1000);
        assert_eq!(module.gap(Ap::ActualVelocity), -sign * 30_000, "the other way");
    }
}

#[test]
fn a_disabled_switch_stops_nothing_and_the_other_one_does() {
    for (sign, fault, switch, disable, rotate) in SIDES {
        let mut module = module();
        module.sap(disable, 1);
        module.ok(rotate, 0, 0, TURN);
        module.run_ms(2000);
        assert!(module.turns() * f64::from(sign) > 1.0);
        assert_eq!((module.gap(switch), module.gap(Ap::ActualVelocity)), (1, sign * TURN));
        // Switched on in mid-flight.
        module.sap(disable, 0);
        module.run_ticks(1);
        assert_eq!(module.gap(Ap::ActualVelocity), 0);
        module.set(fault, "closed");
        module.run_ms(500);
        assert_eq!(module.gap(Ap::ActualVelocity), sign * TURN);
    }
}

/// With GP 79 a closed contact is active.
#[test]
fn a_reversed_polarity_reverses_what_stops() {
    for (sign, fault, switch, _, rotate) in SIDES {
        let mut module = module();
        module.sgp(Gp::EndSwitchPolarity, 1);
        assert_eq!(module.gap(switch), 1);
        module.ok(rotate, 0, 0, 1000);
        module.run_ms(100);
        assert_eq!(module.gap(Ap::ActualPosition), 0);
        module.set(fault, "open");
        module.run_ms(100);
        assert_eq!(module.gap(Ap::ActualVelocity), sign * 1000);
        module.sgp(Gp::EndSwitchPolarity, 0);
        module.run_ms(1);
        assert_eq!(module.gap(Ap::ActualVelocity), 0);
    }
}

/// Turning round on the way into a switch, the motor does not have to brake: it stands, and goes the other way.
#[test]
fn a_reversal_that_runs_into_the_switch_goes_on_away_from_it() {
    for (sign, _, switch, _, rotate) in SIDES {
        let mut module = module();
        module.ok(rotate, 0, 0, TURN);
        while module.turns() * f64::from(sign) < 0.49 {
            module.run_ticks(1);
        }
        move_to(&mut module, 0);
        let velocity = hit(&mut module, switch) * sign;
        assert!((-20..=0).contains(&velocity), "{velocity} pps");
        module.arrive();
        assert!(module.turns().abs() < SLACK);
    }
}

/// The switch interrupts (27, 28) and stops.
#[test]
fn the_edge_that_stops_interrupts() {
    for ((_, _, switch, _, rotate), interrupt) in SIDES.into_iter().zip([27, 28]) {
        let bench = BENCH.replace("bounce_ms = 2.0", "bounce_ms = 0.0");
        let mut module = listening(Module::on(&bench), &[interrupt], &[sgp(interrupt, 3, 1)]);
        module.ok(rotate, 0, 0, TURN);
        hit(&mut module, switch);
        module.run_ms(1);
        assert_eq!(module.variable(0), 1);
        assert_eq!(module.gap(Ap::ActualVelocity), 0);
    }
}
