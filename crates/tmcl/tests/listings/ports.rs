//! Listings that read inputs, set outputs, and compute.

use tmcl_tables::tmcm_1311::AxisParameter as Ap;

use super::host::Host;
use super::text::{as_suggested, assembled, listing, text};

/// IN_0 and IN_4 are the analogue inputs, read as digital ones (§5.7.15.1).
const INPUTS: [(&str, u16); 8] = [
    ("ain.0", 4095),
    ("input.1", 1),
    ("input.2", 1),
    ("input.3", 1),
    ("ain.4", 4095),
    ("input.5", 1),
    ("input.6", 1),
    ("input.7", 1),
];

/// §5.7.14 and §5.7.15.1.
#[test]
fn the_outputs_follow_the_inputs() {
    let mut host = Host::running(&listing("tmcm_1311_5_7_14"));
    // Every pattern, in an order in which neighbours differ in many bits.
    for pattern in (0..=255_u8).map(|count| count.wrapping_mul(109)) {
        for (bit, (name, high)) in INPUTS.into_iter().enumerate() {
            host.set(name, if pattern & (1 << bit) == 0 { 0 } else { high });
        }
        host.run_ms(1);
        for bit in 0..8 {
            let expected = i32::from(pattern >> bit & 1);
            assert_eq!(host.gio(2, bit), expected, "OUT_{bit} for {pattern:#010b}, as a host reads it");
            assert_eq!(
                host.read(&format!("output.{bit}")),
                f64::from(expected),
                "OUT_{bit} for {pattern:#010b}"
            );
        }
    }
    assert!(host.runs());
    host.assert_nothing_refused();
}

/// §5.7.29: the motor goes to four times what the potentiometer says, and follows it in mid-move.
#[test]
fn the_motor_follows_the_potentiometer() {
    let mut host = Host::running(&listing("tmcm_1311_5_7_29"));
    for reading in [1000, 4095, 1, 0] {
        host.set("ain.0", reading);
        // From reading to target: four instructions.
        host.run_ms(1);
        assert_eq!(host.gap(Ap::TargetPosition), 4 * i32::from(reading));
        host.arrive_at(4 * i32::from(reading));
        host.run_ms(300);
        host.assert_at(4.0 * f64::from(reading), 0.0);
        host.assert_stands();
    }
    host.set("ain.0", 4000);
    host.run_ms(400);
    assert!(host.gap(Ap::ActualVelocity) > 10_000, "in mid-move");
    host.set("ain.0", 200);
    host.arrive_at(800);
    host.assert_at(800.0, 0.0);
    host.assert_nothing_refused();
}

/// §11.4 with the AGP that its text means: the variable is doubled.
#[test]
fn the_variable_is_doubled() {
    let mended = assembled("mended", &as_suggested(&text("tmcm_1311_11_4")));
    let mut host = Host::running(&mended);
    host.run_ms(1);
    assert_eq!(host.variable(42), 2 * 1234);
    assert!(!host.runs());
    host.assert_nothing_refused();
}
