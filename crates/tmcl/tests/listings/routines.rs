//! The three routines of §11.6, which a host calls at addresses 0, 1 and 2.

use tmcl_tables::tmcm_1311::AxisParameter as Ap;

use super::host::Host;
use super::text::listing;

/// What AP 5 is unless somebody sets it, in pps/s.
const ACCELERATION: f64 = 51_200.0;

/// Runs until the program has stopped, and returns how long that took, in ms.
#[track_caller]
fn finish(host: &mut Host) -> f64 {
    let begun_ms = host.now_ms();
    while host.runs() {
        assert!(host.now_ms() < begun_ms + 20_000.0, "it does not stop");
        host.run_ms(1);
    }
    host.now_ms() - begun_ms
}

/// Calls a routine that rotates the motor for some time and stops it, and compares how far it came.
#[track_caller]
fn rotates(host: &mut Host, address: u32, velocity: i32, duration_ms: f64) {
    let begun = host.gap(Ap::ActualPosition);
    host.call(address);
    host.run_ms(200);
    host.assert_rotates(velocity, 500);
    let took_ms = 700.0 + finish(host);
    assert!((took_ms - duration_ms).abs() <= 11.0, "{took_ms} ms");
    host.run_ms(200);
    host.assert_stands();
    // Ramping down makes up for what ramping up lost.
    let speed = f64::from(velocity);
    let slack = speed.abs() * 0.011 + speed.powi(2) / ACCELERATION;
    host.assert_at(f64::from(begun) + speed * duration_ms / 1000.0, slack);
}

#[test]
fn the_first_goes_there_and_back() {
    let mut host = Host::with_program(&listing("tmcm_1311_11_6"));
    host.call(0);
    host.arrive_at(1000);
    host.assert_at(1000.0, 0.0);
    assert!(host.runs());
    finish(&mut host);
    host.assert_at(0.0, 0.0);
    assert_eq!(host.gap(Ap::PositionReached), 1);
    host.assert_nothing_refused();
}

#[test]
fn the_second_rotates_left_for_a_second() {
    let mut host = Host::with_program(&listing("tmcm_1311_11_6"));
    rotates(&mut host, 1, -500, 1000.0);
    host.assert_nothing_refused();
}

#[test]
fn the_third_rotates_right_for_seven_seconds() {
    let mut host = Host::with_program(&listing("tmcm_1311_11_6"));
    rotates(&mut host, 2, 1000, 7000.0);
    host.assert_nothing_refused();
}

/// One after the other, in any order, without another download.
#[test]
fn they_can_be_called_again_and_again() {
    let mut host = Host::with_program(&listing("tmcm_1311_11_6"));
    for _ in 0..2 {
        rotates(&mut host, 2, 1000, 7000.0);
        rotates(&mut host, 1, -500, 1000.0);
        host.call(0);
        finish(&mut host);
        host.assert_at(0.0, 0.0);
    }
    host.assert_nothing_refused();
}
