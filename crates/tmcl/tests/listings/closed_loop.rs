//! The closed-loop examples of §8.11, run as printed, and watched by somebody who stands beside the motor.

use tmcl_tables::tmcm_1311::AxisParameter as Ap;

use super::host::Host;
use super::text::listing;

/// Encoder counts in a turn of the default bench.
const COUNTS: f64 = 40_000.0;

/// AP 134: so near to the target it is reached.
const WINDOW: f64 = 50.0;

/// How long the initialisation of the closed loop takes at most.
const INITIALISATION_MS: f64 = 1300.0;

/// The rotor is where `position`, in encoder steps, is, the zero being where it stood when the loop closed.
#[track_caller]
fn assert_stands_at(host: &mut Host, position: i32, zero_turns: f64) {
    let turns = host.turns() - zero_turns;
    assert!((turns - f64::from(position) / COUNTS).abs() < WINDOW / COUNTS, "{turns} turns at {position}");
    let off = f64::from(host.gap(Ap::ActualPosition) - position);
    assert!(off.abs() <= WINDOW, "AP 1 is {off} off");
    assert_eq!(host.gap(Ap::ActualPosition), host.gap(Ap::EncoderCounter));
}

/// Runs until the motor has reached this target, and returns when, in ms.
#[track_caller]
fn arrive_at(host: &mut Host, position: i32) -> f64 {
    host.run_until(&[("target_position", position), ("position_reached", 1)])
}

/// §8.11.1: there and back, with a second's pause at either end.
#[test]
fn example_1_goes_there_and_back() {
    let mut host = Host::running(&listing("tmcm_1311_8_11_1"));
    let closed_ms = host.run_until(&[("closed_loop_initialized", 1)]);
    assert!(closed_ms < INITIALISATION_MS, "{closed_ms} ms");
    let set = [
        (Ap::MaxCurrent, 128),
        (Ap::MotorFullSteps, 200),
        (Ap::EncoderResolution, 40_000),
        (Ap::MaxVelocity, 398_105),
        (Ap::MaxAcceleration, 3_981_070),
        (Ap::MaxCorrectionVelocity, 1_023_950),
    ];
    for (parameter, value) in set {
        assert_eq!(host.gap(parameter), value);
    }
    let zero_turns = host.turns();
    // 655 360 µsteps at 398 105 a second, with a tenth of a second to get there: 12.8 turns.
    let mut begun_ms = host.now_ms();
    for position in [512_000, 0, 512_000] {
        let arrived_ms = arrive_at(&mut host, position);
        let took_ms = arrived_ms - begun_ms;
        assert!((1746.0..1850.0).contains(&took_ms), "{took_ms} ms to {position}");
        assert_stands_at(&mut host, position, zero_turns);
        host.run_ms(900);
        assert_stands_at(&mut host, position, zero_turns);
        begun_ms = arrived_ms + 1000.0;
    }
    assert!(host.runs());
    host.assert_nothing_refused();
}

/// §8.11.2: finds the encoder's resolution, closes the loop, and goes on by position-reached interrupts.
#[test]
fn example_2_is_driven_by_interrupts() {
    let mut host = Host::running(&listing("tmcm_1311_8_11_2"));
    host.sap(Ap::EncoderResolution, 0);
    host.run_until(&[("encoder_initialization", 2)]);
    assert_eq!(host.gap(Ap::EncoderResolution), 40_000);
    // An electrical period and a turn.
    let detected_turns = host.turns();
    assert!((detected_turns - 1.02).abs() < 0.001, "{detected_turns} turns");
    host.run_until(&[("closed_loop_initialized", 1)]);
    let zero_turns = host.turns();
    for position in [51_200, 0, 51_200, 0] {
        arrive_at(&mut host, position);
        assert_stands_at(&mut host, position, zero_turns);
    }
    assert!(host.runs());
    host.assert_nothing_refused();
}
