//! A stepper whose rotor simply follows the field: no inertia, no load, no lost steps, ideal current regulation.
//!
//! It knows the coil currents only, not where the firmware believes the motor to be: the rotor stands where the current
//! vector points.

use core::f64::consts::{SQRT_2, TAU};

use module_firmware::tmcm_1311::{Drive, Sensed};

use crate::hardware::{Hardware, Physical};

/// Pole pairs of a 200-step motor.
const POLE_PAIRS: f64 = 50.0;

/// Counts per turn of the default bench's encoder (TMCM-1311 §8.11.1).
const ENCODER_COUNTS: f64 = 40_000.0;

/// Full-scale RMS coil current of the TMCM-1311.
const FULL_SCALE_RMS_MA: f64 = 3000.0;

/// Length of the longest coil vector that the firmware commands.
const VECTOR_LENGTH: f64 = 248.0;

const SUPPLY_DV: u16 = 480;
const BOARD_C: i16 = 25;

/// The hardware of a TMCM-1311 without physics.
#[derive(Clone, Debug)]
pub struct FieldFollower {
    /// The rotor's angle in electrical periods, unwrapped.
    electrical_turns: f64,
    coils: [i16; 2],
    currents_ma: [f64; 2],
}

impl Default for FieldFollower {
    /// The rotor at the field's zero, no current.
    fn default() -> Self {
        Self { electrical_turns: 0.0, coils: [0, 0], currents_ma: [0.0; 2] }
    }
}

impl Hardware for FieldFollower {
    type Sensed = Sensed;
    type Drive = Drive;

    fn sensed(&self) -> Sensed {
        let counts = libm::floor(self.physical().rotor_turns * ENCODER_COUNTS);
        // The counter of a real encoder interface wraps at 32 bits.
        let wrapped = libm::fmod(counts, 4_294_967_296.0);
        Sensed {
            encoder_counts: (wrapped as i64) as i32,
            coil_currents_ma: self.currents_ma.map(|current_ma| libm::round(current_ma) as i16),
            supply_voltage_dv: SUPPLY_DV,
            temperature_c: BOARD_C,
            ..Sensed::default()
        }
    }

    fn advance(&mut self, drive: &Drive, _until_ns: u64) {
        let powered = drive.chip.off_time != 0;
        let scale = if powered { f64::from(drive.chip.current_scale.min(31)) + 1.0 } else { 0.0 } / 32.0;
        let full_scale_ma = FULL_SCALE_RMS_MA * SQRT_2 * scale * if drive.chip.half_scale { 0.5 } else { 1.0 };
        self.currents_ma = drive.coils.map(|coil| full_scale_ma * f64::from(coil) / VECTOR_LENGTH);
        if powered && drive.coils != self.coils {
            self.coils = drive.coils;
            self.follow();
        }
    }

    fn physical(&self) -> Physical {
        Physical { rotor_turns: self.electrical_turns / POLE_PAIRS }
    }
}

impl FieldFollower {
    /// Turns the rotor the shorter way to where the coil vector points; without current it stays.
    fn follow(&mut self) {
        let [a, b] = self.coils.map(f64::from);
        if a == 0.0 && b == 0.0 {
            return;
        }
        let field = libm::atan2(b, a) / TAU;
        let lag = field - self.electrical_turns;
        self.electrical_turns += lag - libm::round(lag);
    }
}

#[cfg(test)]
mod tests {
    use module_firmware::tmcm_1311::ChipSettings;

    use super::*;

    fn drive(coils: [i16; 2]) -> Drive {
        let chip = ChipSettings { current_scale: 31, off_time: 5, ..ChipSettings::default() };
        Drive { coils, chip, ..Drive::default() }
    }

    #[test]
    fn a_quarter_period_is_a_full_step() {
        let mut follower = FieldFollower::default();
        for coils in [[0, 248], [-248, 0], [0, -248], [248, 0]] {
            follower.advance(&drive(coils), 0);
        }
        assert!((follower.physical().rotor_turns - 4.0 / 200.0).abs() < 1e-12);
        assert_eq!(follower.sensed().encoder_counts, 800);
    }

    #[test]
    fn bridges_that_are_off_move_nothing_and_carry_nothing() {
        let mut follower = FieldFollower::default();
        follower.advance(&Drive { chip: ChipSettings::default(), ..drive([0, 248]) }, 0);
        assert_eq!(follower.physical().rotor_turns, 0.0);
        assert_eq!(follower.sensed().coil_currents_ma, [0, 0]);
    }

    #[test]
    fn full_scale_is_three_amperes_rms() {
        let mut follower = FieldFollower::default();
        follower.advance(&drive([248, 0]), 0);
        assert_eq!(follower.sensed().coil_currents_ma, [4243, 0]);
        let mut half = drive([0, -248]);
        half.chip.half_scale = true;
        follower.advance(&half, 0);
        assert_eq!(follower.sensed().coil_currents_ma, [0, -2121]);
    }
}
