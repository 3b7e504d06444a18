//! Three hall sensors, a third of an electrical turn apart, that show the rotor's electrical angle to a sixth of a turn.

use core::f64::consts::FRAC_PI_3;

/// H3 H2 H1 in the sectors that begin at 0, 60, … 300° (TMCM-1640, decision).
const SECTORS: [u8; 6] = [0b001, 0b011, 0b010, 0b110, 0b100, 0b101];

/// Hall sensors, how they are mounted, and what is broken.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HallSensors {
    /// Electrical angle from phase U's axis at which the first sector begins.
    pub offset_rad: f64,
    /// Whether the lines show the opposite of what is meant.
    pub inverted: bool,
    /// What each of H1, H2, H3 is stuck at, if it is dead.
    pub stuck: [Option<bool>; 3],
}

impl HallSensors {
    /// The lines H3 H2 H1, H1 in bit 0, at an electrical angle that rises as the motor turns to the right.
    #[must_use]
    pub fn bits(&self, electrical_rad: f64) -> u8 {
        let sector = libm::floor((electrical_rad - self.offset_rad) / FRAC_PI_3) as i64;
        let alive = SECTORS.get(sector.rem_euclid(6) as usize).copied().unwrap_or(0);
        let alive = if self.inverted { !alive & 0b111 } else { alive };
        self.stuck.iter().enumerate().fold(alive, |bits, (line, stuck)| match stuck {
            Some(true) => bits | 1 << line,
            Some(false) => bits & !(1 << line),
            None => bits,
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn a_turn_to_the_right_shows_the_sectors_in_order() {
        let halls = HallSensors::default();
        let centres = [0, 1, 2, 3, 4, 5].map(|sector| halls.bits((f64::from(sector) + 0.5) * FRAC_PI_3));
        assert_eq!(centres, SECTORS);
        assert_eq!(halls.bits(-0.01), 0b101);
        assert_eq!(halls.bits(f64::to_radians(59.9)), 0b001);
        assert_eq!(halls.bits(f64::to_radians(60.1)), 0b011);
    }

    #[test]
    fn mounting_turns_the_sectors_and_inversion_is_half_a_turn() {
        let turned = HallSensors { offset_rad: FRAC_PI_3, ..HallSensors::default() };
        let inverted = HallSensors { inverted: true, ..HallSensors::default() };
        for degrees in [10.0, 100.0, 200.0, 350.0] {
            let angle = f64::to_radians(degrees);
            assert_eq!(turned.bits(angle + FRAC_PI_3), HallSensors::default().bits(angle));
            assert_eq!(inverted.bits(angle + 3.0 * FRAC_PI_3), HallSensors::default().bits(angle));
        }
    }

    #[test]
    fn a_dead_line_makes_impossible_patterns() {
        let shows =
            |stuck, degrees| HallSensors { stuck, ..HallSensors::default() }.bits(f64::to_radians(degrees));
        assert_eq!(shows([Some(false), None, None], 30.0), 0b000);
        assert_eq!(shows([None, None, Some(true)], 90.0), 0b111);
        assert_eq!(shows([None, Some(true), None], 150.0), 0b010);
    }

    proptest! {
        #[test]
        fn one_line_changes_from_sector_to_sector(degrees in -1000.0..1000.0, offset_rad in -7.0..7.0, inverted: bool) {
            let halls = HallSensors { offset_rad, inverted, stuck: [None; 3] };
            let here = halls.bits(f64::to_radians(degrees));
            let next = halls.bits(f64::to_radians(degrees) + FRAC_PI_3);
            prop_assert!((1..=6).contains(&here));
            prop_assert_eq!((here ^ next).count_ones(), 1);
        }
    }
}
