//! Targets, velocities and accelerations changed while the motor moves; and that none of it is left to chance.

use crate::common::motion::{finish, finish_within_limits, move_to};
use crate::common::{Module, TICKS_PER_MS, TURN};
use tmcl_tables::Command;
use tmcl_tables::tmcm_1311::AxisParameter as Ap;
use tmcl_wire::Request;

mod changes_in_flight {
    use super::*;

    /// Starts a move over four turns and lets it get to speed.
    fn under_way() -> Module {
        let mut module = Module::new();
        move_to(&mut module, 4 * TURN);
        module.run_ms(1500);
        assert_eq!(module.gap(Ap::ActualVelocity), TURN);
        module
    }

    #[test]
    fn a_farther_target_prolongs_the_move() {
        let mut module = under_way();
        move_to(&mut module, 6 * TURN);
        assert_eq!(module.gap(Ap::ActualVelocity), TURN, "without a halt");
        let ticks = finish_within_limits(&mut module);
        // 7 s in all: 6 turns at 1 turn/s, and 1 s for the ramps.
        assert!((5499 * TICKS_PER_MS..=5501 * TICKS_PER_MS).contains(&ticks), "{ticks}");
    }

    #[test]
    fn a_nearer_target_that_can_still_be_braked_for_is_reached_directly() {
        let mut module = under_way();
        move_to(&mut module, 2 * TURN);
        let ticks = finish_within_limits(&mut module);
        assert!((1499 * TICKS_PER_MS..=1501 * TICKS_PER_MS).contains(&ticks), "{ticks}");
    }

    #[test]
    fn a_target_behind_turns_it_round() {
        let mut module = under_way();
        move_to(&mut module, -TURN);
        let mut farthest = 0;
        let (mut before, limit) = (i64::from(TURN), i64::from(TURN));
        while module.gap(Ap::PositionReached) == 0 {
            module.run_ticks(1);
            farthest = farthest.max(module.gap(Ap::ActualPosition));
            let velocity = i64::from(module.gap(Ap::ActualVelocity));
            assert!(velocity.abs() <= limit);
            // 2.56 pps a tick, and what rounding makes of it; the last tick may drop the last fraction.
            let arrived = module.gap(Ap::ActualPosition) == -TURN;
            assert!((velocity - before).abs() <= 4 || arrived, "{before} to {velocity}");
            before = velocity;
        }
        // At one turn after 1.5 s, and v²/2a = half a turn of braking.
        assert!((farthest - 3 * TURN / 2).abs() < 100, "{farthest}");
        assert_eq!(module.gap(Ap::ActualPosition), -TURN);
        module.run_ms(100);
        assert_eq!(module.gap(Ap::ActualPosition), -TURN);
    }

    /// §8.4, open point 269: updated on-line.
    #[test]
    fn a_new_velocity_counts_at_once() {
        for velocity in [3 * TURN / 2, TURN / 4] {
            let mut module = under_way();
            module.sap(Ap::MaxVelocity, velocity);
            module.run_ms(1010);
            assert_eq!(module.gap(Ap::ActualVelocity), velocity);
            finish_within_limits(&mut module);
            assert_eq!(module.gap(Ap::ActualPosition), 4 * TURN);
        }
    }

    #[test]
    fn a_new_acceleration_counts_at_once() {
        let mut module = under_way();
        module.sap(Ap::MaxAcceleration, 10 * TURN);
        let ticks = finish_within_limits(&mut module);
        // At 1 turn, 1 turn/s; braking takes 0.1 s and 0.05 turns: 2.95 s + 0.1 s.
        assert!((3049 * TICKS_PER_MS..=3051 * TICKS_PER_MS).contains(&ticks), "{ticks}");
        assert_eq!(module.gap(Ap::ActualPosition), 4 * TURN);
    }

    /// Too slow to brake now: it may overshoot, but it comes back and ends exactly.
    #[test]
    fn a_much_lower_acceleration_still_ends_exactly() {
        let mut module = under_way();
        move_to(&mut module, 7 * TURN / 4);
        module.run_ms(400);
        module.sap(Ap::MaxAcceleration, TURN / 4);
        finish(&mut module);
        assert_eq!(module.gap(Ap::ActualPosition), 7 * TURN / 4);
        assert_eq!(module.gap(Ap::ActualVelocity), 0);
        module.run_ms(100);
        assert_eq!(module.gap(Ap::ActualPosition), 7 * TURN / 4);
    }

    #[test]
    fn a_move_from_a_rotation_and_a_rotation_from_a_move() {
        let mut module = Module::new();
        module.ok(Command::RotateLeft, 0, 0, TURN);
        module.run_ms(1500);
        move_to(&mut module, TURN);
        finish(&mut module);
        assert_eq!(module.gap(Ap::ActualPosition), TURN);
        move_to(&mut module, 5 * TURN);
        module.run_ms(1500);
        module.ok(Command::RotateLeft, 0, 0, 1000);
        module.run_ms(1100);
        assert_eq!(module.gap(Ap::ActualVelocity), -1000);
    }
}

mod determinism {
    use super::*;

    /// A day in the life of a module: everything it answers, and where the rotor really is.
    fn session(module: &mut Module, seed: u32) -> Vec<(Vec<u8>, u64)> {
        let mut random = seed;
        let mut next = |below: u32| {
            random ^= random << 13;
            random ^= random >> 17;
            random ^= random << 5;
            random % below
        };
        let mut seen = Vec::new();
        for _ in 0..400 {
            let position = next(200_000).cast_signed() - 100_000;
            let request = match next(8) {
                0 => Request::new(Command::RotateRight, 0, 0, position),
                1 => Request::new(Command::MoveToPosition, 0, 0, position),
                2 => Request::new(Command::MoveToPosition, 1, 0, position),
                3 => Request::new(Command::SetAxisParameter, 4, 0, position.abs()),
                4 => Request::new(Command::SetAxisParameter, 5, 0, position.abs() + 1),
                5 => Request::new(Command::GetGlobalParameter, 133, 0, 0),
                6 => Request::new(Command::GetAxisParameter, 209, 0, 0),
                _ => Request::new(Command::GetAxisParameter, 1, 0, 0),
            };
            let answer = module.exchange(&tmcl_wire::serial::encode_request(1, request));
            seen.push((answer, module.turns().to_bits()));
            module.run_ticks(u64::from(next(600)));
        }
        seen
    }

    #[test]
    fn the_same_inputs_give_the_same_replies_and_positions() {
        assert_eq!(session(&mut Module::new(), 1), session(&mut Module::new(), 1));
    }

    #[test]
    fn a_snapshot_runs_on_like_the_original() {
        let mut original = Module::new();
        session(&mut original, 2);
        // In the middle of a datagram, too.
        original.exchange(&[1, 6, 1]);
        let mut snapshot = original.clone();
        assert_eq!(session(&mut original, 3), session(&mut snapshot, 3));
        original.run_ms(1000);
        assert_eq!(original.turns(), {
            snapshot.run_ms(1000);
            snapshot.turns()
        });
    }
}
