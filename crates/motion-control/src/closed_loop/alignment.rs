//! The initialisation of the closed loop: pulls the rotor to a known electrical angle, and checks that the encoder follows
//! (TMCM-1311 §8.1, AP 129 and 133; decision).
//!
//! The field is put at 90°, with a current that rises from nothing, and stays until the rotor has come to rest; then it
//! turns to 0°. The encoder must have counted what a full step is worth, and downwards: else it is dead, wired the wrong way,
//! set to the wrong resolution, or the rotor is blocked.

use super::scale::EncoderScale;
use crate::TICKS_PER_SECOND;

/// How long the field is at 90° and then at 0°: 500 ms each.
const STAGE_TICKS: u32 = (TICKS_PER_SECOND / 2) as u32;

/// In what part of it the current rises, and the field turns: gently, so that the rotor does not ring.
const RISE_TICKS: u32 = STAGE_TICKS / 5;
const TURN_TICKS: u32 = STAGE_TICKS / 2;

/// The field's first place, in µsteps: 90°, a full step.
const START: u16 = 256;

/// What the field shall do in this control period.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Stand at so many µsteps of the electrical period, at (`current` + 1)/256 of the full current.
    Field {
        /// 0 to 256.
        phase: u16,
        /// 0 to 255.
        current: u8,
    },
    /// The rotor stands at 0°.
    Aligned,
    /// The encoder did not follow.
    Failed,
}

/// An initialisation that runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Alignment {
    ticks: u32,
    /// The encoder when the field left 90°.
    count_at_start: i32,
}

impl Default for Alignment {
    fn default() -> Self {
        Self::new()
    }
}

impl Alignment {
    /// One that begins, wherever the rotor is; it has to stand.
    #[must_use]
    pub fn new() -> Self {
        Self { ticks: 0, count_at_start: 0 }
    }

    /// A control period. `full_step_counts` are 256 times the counts of a full step.
    pub fn tick(&mut self, count: i32, scale: &EncoderScale) -> Order {
        self.ticks += 1;
        let Some(turning) = self.ticks.checked_sub(STAGE_TICKS) else {
            let current = (self.ticks * 256 / RISE_TICKS).clamp(1, 256) - 1;
            return Order::Field { phase: START, current: u8::try_from(current).unwrap_or(u8::MAX) };
        };
        if turning == 0 {
            self.count_at_start = count;
        }
        if turning < STAGE_TICKS {
            let turned = u32::from(START) * turning.min(TURN_TICKS) / TURN_TICKS;
            let phase = START.saturating_sub(u16::try_from(turned).unwrap_or(START));
            return Order::Field { phase, current: u8::MAX };
        }
        if is_full_step(self.count_at_start.wrapping_sub(count), scale) {
            Order::Aligned
        } else {
            Order::Failed
        }
    }
}

/// Whether the rotor went back by a full step, give or take a quarter of it and a count.
fn is_full_step(counts: i32, scale: &EncoderScale) -> bool {
    let (counts, full_step) = (i64::from(counts), i64::from(START));
    scale.microsteps(counts - 1) <= full_step * 5 / 4 && scale.microsteps(counts + 1) >= full_step * 3 / 4
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs one with an encoder that counts `per_microstep` from where the field stands, and returns how it ends and when.
    fn run(scale: &EncoderScale, count: impl Fn(u16) -> i32) -> (Order, u32) {
        let (mut alignment, mut phase) = (Alignment::new(), START);
        loop {
            match alignment.tick(count(phase), scale) {
                Order::Field { phase: next, .. } => phase = next,
                end => return (end, alignment.ticks),
            }
        }
    }

    fn scale(counts: u32) -> EncoderScale {
        EncoderScale::new(200, counts).expect("neither is 0")
    }

    #[test]
    fn it_takes_a_second() {
        let scale = scale(51_200);
        assert_eq!(run(&scale, |phase| phase.into()), (Order::Aligned, 20_000));
    }

    #[test]
    fn the_current_rises_within_100_ms() {
        let mut alignment = Alignment::new();
        let mut currents = (0..2000).map(|_| match alignment.tick(0, &scale(4000)) {
            Order::Field { phase: 256, current } => current,
            other => panic!("{other:?}"),
        });
        assert_eq!(currents.next(), Some(0));
        assert_eq!(currents.last(), Some(255));
    }

    #[test]
    fn an_encoder_of_any_resolution_will_do() {
        for counts in [401, 1000, 4000, 10_000, 16_384, 40_000, 65_535] {
            let scale = scale(counts);
            let order = run(&scale, |phase| scale.counts(phase.into()) as i32).0;
            assert_eq!(order, Order::Aligned, "{counts}");
        }
    }

    #[test]
    fn what_does_not_follow_fails() {
        let scale = scale(40_000);
        let ends = |count: &dyn Fn(u16) -> i32| run(&scale, count).0;
        assert_eq!(ends(&|_| 7), Order::Failed, "dead or blocked");
        assert_eq!(ends(&|phase| -i32::from(phase) * 200 / 256), Order::Failed, "the wrong way");
        assert_eq!(ends(&|phase| i32::from(phase) * 20 / 256), Order::Failed, "4000 counts");
        assert_eq!(ends(&|phase| i32::from(phase) * 260 / 256), Order::Failed, "30 % too many");
        assert_eq!(ends(&|phase| i32::from(phase) * 240 / 256), Order::Aligned, "20 % too many");
    }
}
