//! The closed-loop examples of §8.11, as far as a module without closed loop takes them: they assemble, start, set what they
//! set, and wait for what does not come. They run fully once closed loop exists; then these tests are to follow them through
//! their moves.

use tmcl_tables::tmcm_1311::AxisParameter as Ap;

use super::host::Host;
use super::text::listing;

/// The program stays between these addresses, and the motor stands.
#[track_caller]
fn assert_waits(host: &mut Host, first: u16, last: u16) {
    for _ in 0..1000 {
        host.run_ms(1);
        let address = host.read("program_counter");
        assert!((f64::from(first)..=f64::from(last)).contains(&address), "it is at {address}");
    }
    assert!(host.runs());
    host.assert_stands();
    host.assert_at(0.0, 0.0);
    host.assert_nothing_refused();
}

/// §8.11.1 waits at `ClWait` for axis parameter 133.
#[test]
fn example_1_waits_for_the_closed_loop_flag() {
    let mut host = Host::running(&listing("tmcm_1311_8_11_1"));
    host.run_ms(1);
    let set = [
        (Ap::MaxCurrent, 128),
        (Ap::MotorFullSteps, 200),
        (Ap::MaxVelocity, 398_105),
        (Ap::MaxAcceleration, 3_981_070),
    ];
    for (parameter, value) in set {
        assert_eq!(host.gap(parameter), value);
    }
    assert_waits(&mut host, 7, 8);
    assert_eq!(host.gap(Ap::ClosedLoopInitialized), 0);
}

/// §8.11.2 waits at `Detect` for the encoder detection, axis parameter 132.
#[test]
fn example_2_waits_for_the_encoder_detection() {
    let mut host = Host::running(&listing("tmcm_1311_8_11_2"));
    host.run_ms(1);
    assert_eq!(host.gap(Ap::MaxCurrent), 128);
    assert_waits(&mut host, 2, 7);
}
