//! Where the commanded current vector points: taken from a register, or made from steps by a sine table.

use super::Coils;
use crate::stepper::table::{AMPLITUDE, Command, PERIOD, turn, vector};

/// The sequencer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Sequencer {
    /// The microstep counter, 0 to 1023.
    position: u16,
    /// Edges on STEP since the last control period, signed by DIR.
    steps: i32,
    vector: [i16; 2],
}

impl Sequencer {
    pub(super) fn position(&self) -> u16 {
        self.position
    }

    pub(super) fn step(&mut self, steps: i32) {
        // Only what is left of whole periods counts, whatever the resolution.
        self.steps = (self.steps + steps % PERIOD) % PERIOD;
    }

    pub(super) fn advance(&mut self, coils: Coils) -> Command {
        let steps = core::mem::take(&mut self.steps);
        let before = self.vector;
        let stepped = steps != 0 && matches!(coils, Coils::StepDirection { .. });
        self.vector = match coils {
            Coils::Direct(vector) => vector.map(|coil| coil.clamp(-AMPLITUDE, AMPLITUDE)),
            Coils::StepDirection { microstep_resolution } => {
                let microsteps = steps << microstep_resolution.min(8);
                self.position = (i32::from(self.position) + microsteps).rem_euclid(PERIOD) as u16;
                vector(self.position)
            }
        };
        let vector = self.vector;
        Command { vector, before, changed: stepped || before != vector, direction: turn(before, vector) }
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::PI;

    use super::*;

    const FINEST: Coils = Coils::StepDirection { microstep_resolution: 0 };

    #[test]
    fn steps_follow_cosine_and_sine_to_half_a_unit() {
        let mut sequencer = Sequencer::default();
        for position in 0..2 * PERIOD {
            let [a, b] = sequencer.advance(FINEST).vector;
            let angle = (f64::from(position) + 0.5) * PI / 512.0;
            assert!((f64::from(a) - 248.0 * libm::cos(angle)).abs() < 0.501, "A at {position}: {a}");
            assert!((f64::from(b) - 248.0 * libm::sin(angle)).abs() < 0.501, "B at {position}: {b}");
            sequencer.step(1);
        }
    }

    #[test]
    fn a_step_is_two_to_the_resolution_microsteps() {
        for resolution in 0..=8 {
            let coils = Coils::StepDirection { microstep_resolution: resolution };
            let mut sequencer = Sequencer::default();
            sequencer.step(3);
            sequencer.advance(coils);
            assert_eq!(sequencer.position(), (3 << resolution) % 1024);
            sequencer.step(-4);
            sequencer.advance(coils);
            assert_eq!(sequencer.position(), 1024 - (1 << resolution));
        }
    }

    #[test]
    fn the_direction_is_that_of_the_shorter_way() {
        let mut sequencer = Sequencer::default();
        sequencer.advance(FINEST);
        for (steps, direction) in [(1, 1), (-1, -1), (300, 1), (-300, -1), (700, -1), (512, 0), (0, 0)] {
            sequencer.step(steps);
            let command = sequencer.advance(FINEST);
            assert_eq!((command.direction, command.changed), (direction, steps != 0), "{steps} steps");
        }
    }

    #[test]
    fn any_number_of_steps_is_taken_modulo_a_period() {
        let mut sequencer = Sequencer::default();
        for steps in [i32::MAX, i32::MAX, i32::MIN, 7] {
            sequencer.step(steps);
        }
        sequencer.advance(FINEST);
        let sum = 2 * i64::from(i32::MAX) + i64::from(i32::MIN) + 7;
        assert_eq!(i64::from(sequencer.position()), sum.rem_euclid(1024));
    }

    #[test]
    fn direct_currents_pass_up_to_the_amplitude() {
        let mut sequencer = Sequencer::default();
        let command = sequencer.advance(Coils::Direct([100, -300]));
        assert_eq!(command, Command { vector: [100, -248], before: [0, 0], changed: true, direction: 0 });
        let command = sequencer.advance(Coils::Direct([200, -248]));
        assert_eq!(
            command,
            Command { vector: [200, -248], before: [100, -248], changed: true, direction: 1 }
        );
        assert!(!sequencer.advance(Coils::Direct([200, -248])).changed);
    }

    #[test]
    fn steps_are_lost_on_a_chip_that_takes_its_currents_directly() {
        let mut sequencer = Sequencer::default();
        sequencer.step(5);
        sequencer.advance(Coils::Direct([0, 0]));
        sequencer.advance(FINEST);
        assert_eq!(sequencer.position(), 0);
    }
}
