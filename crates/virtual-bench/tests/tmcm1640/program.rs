//! The test program of §4.4 as printed: rotate left and right with 4000 rpm, 20 s each.

use crate::common::bldc::Bldc;
use crate::common::program::{ja, kind, op, wait};
use tmcl_tables::Command;
use tmcl_tables::tmcm_1640::AxisParameter as Ap;

#[test]
fn the_program_of_section_4_4_rotates_left_and_right() {
    let mut axis = Bldc::new();
    axis.download(&[
        op(Command::RotateLeft, 0, 0, 4000),
        wait(kind::TICKS, 2000),
        op(Command::RotateRight, 0, 0, 4000),
        wait(kind::TICKS, 2000),
        ja(0),
    ]);
    axis.run_from(0);
    axis.run_ms(5);
    assert_eq!(axis.gap(Ap::TargetVelocity), -4000);
    axis.run_ms(15_000);
    for rpm in [-4000, 4000, -4000] {
        let mean = axis.mean(2000, |axis| axis.rpm());
        assert!((mean / f64::from(rpm) - 1.0).abs() < 0.01, "{mean:.0} rpm; {}", axis.figures());
        assert_eq!(axis.gap(Ap::TargetVelocity), rpm);
        // To the middle of the next 20 s; the mean took 100 ms.
        axis.run_ms(19_900);
    }
    assert_eq!(axis.refused(), []);
    axis.stop();
    assert_eq!(axis.status_of_program().0, 0);
    axis.run_ms(1000);
    assert!(axis.rpm() > 3900.0, "stopping the program leaves the motor: {}", axis.figures());
}

/// Download, reading back and a run from the EEPROM after power-on (GP 77).
#[test]
fn a_stored_program_starts_at_power_on() {
    use crate::common::program::STOP;
    let program = [op(Command::RotateRight, 0, 0, 1000), STOP];
    let mut axis = Bldc::new();
    axis.download(&program);
    for (address, instruction) in (0..).zip(program) {
        assert_eq!(axis.read_instruction(address), instruction);
    }
    axis.sgp(tmcl_tables::GlobalParameter::AutoStart, 1);
    axis.power_cycle();
    axis.run_ms(2000);
    assert!((axis.rpm() / 1000.0 - 1.0).abs() < 0.03, "{}", axis.figures());
}
