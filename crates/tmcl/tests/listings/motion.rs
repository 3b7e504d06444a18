//! Listings that move the motor.

use tmcl_tables::tmcm_1311::AxisParameter as Ap;

use super::host::Host;
use super::text::{assembled, listing, text};

/// What AP 5 is until a program sets it, in pps/s.
const ACCELERATION: f64 = 51_200.0;

/// §3.3.2: left for 5 s, right for 5 s, then to and fro for ever.
#[test]
fn the_simple_program_rotates_both_ways_and_moves_to_and_fro() {
    let mut host = Host::running(&listing("tmcm_1311_3_3_2"));
    // The ramps: 50 000 pps are reached after a second, and as much is lost of the way as a triangle has.
    let (speed, ramp) = (50_000.0, 50_000.0_f64.powi(2) / (2.0 * ACCELERATION));
    host.run_to_ms(2_000);
    host.assert_rotates(-50_000, 3_000);
    host.assert_at(-(5.0 * speed - ramp), 20.0);
    // MST, and ROR right after it: the motor slows down, turns round, and is where it was when it is as fast again.
    host.run_to_ms(5_970);
    assert!((-1000..0).contains(&host.gap(Ap::ActualVelocity)));
    host.run_to_ms(8_000);
    host.assert_rotates(50_000, 2_000);
    let lost = 2.0 * speed / ACCELERATION * speed;
    host.assert_at(-(5.0 * speed - ramp) + 5.0 * speed - lost, 40.0);
    for position in [10_000, -100_000, 10_000, -100_000] {
        host.arrive_at(position);
        host.assert_at(f64::from(position), 0.0);
    }
    assert_eq!((host.gap(Ap::MaxVelocity), host.gap(Ap::MaxAcceleration)), (50_000, 50_000));
    assert!(host.runs());
    host.assert_nothing_refused();
}

/// §5.7.18, and with it the comparison of §5.7.17: from 1000 on the program goes to `Label`, below it takes what stands before
/// it. Nothing does in the listing but dots; here it is an output.
#[test]
fn the_jump_depends_on_the_position() {
    let text = text("tmcm_1311_5_7_18");
    let filled = assembled("filled", &text.replacen("//...", "SIO 0, 2, 1", 1));
    for (position, below) in [(-1000, true), (999, true), (1000, false), (5000, false)] {
        let mut host = Host::with_program(&filled);
        host.sap(Ap::ActualPosition, position);
        host.sap(Ap::TargetPosition, position);
        host.call(0);
        host.run_ms(500);
        assert_eq!(host.gio(2, 0) == 1, below, "at {position}");
        assert!(!host.runs());
        host.assert_rotates(-1000, 1_000);
        host.assert_nothing_refused();
    }
}

/// §5.7.18 as printed: either way the motor rotates left in the end, and goes on when the program has stopped.
#[test]
fn the_label_rotates_the_motor() {
    let mut host = Host::running(&listing("tmcm_1311_5_7_18"));
    host.run_ms(1_000);
    assert!(!host.runs());
    host.assert_rotates(-1000, 1_000);
    host.assert_at(-1990.0, 10.0);
    host.assert_nothing_refused();
}

/// §5.7.19.
#[test]
fn the_infinite_loop_goes_there_and_back() {
    let mut host = Host::running(&listing("tmcm_1311_5_7_19"));
    for position in [10_000, 0, 10_000, 0, 10_000] {
        host.arrive_at(position);
        host.assert_at(f64::from(position), 0.0);
    }
    assert!(host.runs());
    host.assert_nothing_refused();
}

/// §5.7.20: the subroutine waits for the position and half a second more, and returns to the instruction behind the call,
/// which is a move to 0 that the loop takes back at once. More rounds than the stack is deep: every call returns.
#[test]
fn the_subroutine_returns_behind_its_call() {
    let mut host = Host::running(&listing("tmcm_1311_5_7_20"));
    let arrived_ms = host.arrive_at(10_000);
    let mut returned_ms = host.run_until(&[("target_position", 0)]);
    assert!((returned_ms - arrived_ms - 500.0).abs() < 10.0, "{arrived_ms} ms, then {returned_ms} ms");
    for _ in 0..12 {
        host.run_until(&[("target_position", 10_000)]);
        let again_ms = host.run_until(&[("target_position", 0)]);
        assert!((again_ms - returned_ms - 500.0).abs() < 15.0, "{returned_ms} ms, then {again_ms} ms");
        returned_ms = again_ms;
        host.assert_at(10_000.0, 1.0);
    }
    assert!(host.runs());
    host.assert_nothing_refused();
}

/// §11.2, here with the names of §11.3: slowly there and back, for ever. AP 5 = 100 takes 5 s to AP 4 = 500.
#[test]
fn the_main_loop_runs_between_two_positions() {
    let mut host = Host::running(&listing("tmcm_1311_11_3"));
    for (round, position) in [5000, 0, 5000].into_iter().enumerate() {
        let leg_ms = (5000.0 / 500.0 + 500.0 / 100.0) * 1000.0;
        let arrived_ms = host.arrive_at(position);
        let expected_ms = leg_ms * (round + 1) as f64;
        assert!((arrived_ms - expected_ms).abs() < 10.0, "{arrived_ms} ms, not {expected_ms} ms");
        host.assert_at(f64::from(position), 0.0);
    }
    assert_eq!((host.gap(Ap::MaxVelocity), host.gap(Ap::MaxAcceleration)), (500, 100));
    assert!(host.runs());
    host.assert_nothing_refused();
}
