//! The initialisation of the closed loop: pulls the rotor to a known electrical angle, and checks that the encoder follows
//! (TMCM-1311 §8.1, AP 129 and 133; decision).
//!
//! From where it stands, and with the current that flows, so that no load falls and the rotor is not left on a dead point, the
//! field turns to 90° while the current rises; it stays until the rotor has come to rest, and then it turns to 0°. The encoder must have counted what a full step is worth, and downwards: else it is dead, wired the wrong way,
//! set to the wrong resolution, or the rotor is blocked.

use super::scale::EncoderScale;
use crate::TICKS_PER_SECOND;

/// How long the field is at 90° and then at 0°: 500 ms each.
const STAGE_TICKS: u32 = (TICKS_PER_SECOND / 2) as u32;

/// In what part of it the current rises, and the field turns: gently, so that the rotor does not ring.
const RISE_TICKS: u32 = STAGE_TICKS / 5;
const TURN_TICKS: u32 = STAGE_TICKS / 2;

/// The field's first place, in µsteps: 90°, a full step.
const QUARTER: i32 = 256;

/// Four full steps.
const PERIOD: i32 = 4 * QUARTER;

/// What the field shall do in this control period.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Stand at so many µsteps of the electrical period, at (`current` + 1)/256 of the full current.
    Field {
        /// Wraps.
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
    /// Where the field was, in µsteps: within half a period of 90°.
    from_phase: i32,
    /// The current that flowed, in 1/256.
    from_current: u8,
    /// The encoder when the field left 90°.
    count_at_start: i32,
}

impl Alignment {
    /// One that begins with the field at `phase` µsteps and (`current` + 1)/256 of the full current; the rotor has to stand.
    #[must_use]
    pub fn new(phase: u16, current: u8) -> Self {
        let ahead = (i32::from(phase) - QUARTER + PERIOD / 2).rem_euclid(PERIOD) - PERIOD / 2;
        Self { ticks: 0, from_phase: QUARTER + ahead, from_current: current, count_at_start: 0 }
    }

    /// A control period, with what the encoder counts.
    pub fn tick(&mut self, count: i32, scale: &EncoderScale) -> Order {
        self.ticks += 1;
        let Some(ticks) = self.ticks.checked_sub(STAGE_TICKS) else {
            return self.raise();
        };
        if ticks == 0 {
            self.count_at_start = count;
        }
        if ticks < STAGE_TICKS {
            return Order::Field { phase: phase_between(QUARTER, 0, ticks), current: u8::MAX };
        }
        if is_full_step(self.count_at_start.wrapping_sub(count), scale) {
            Order::Aligned
        } else {
            Order::Failed
        }
    }

    /// The first stage: the current rises, then the field turns to 90°.
    fn raise(&self) -> Order {
        let rise = u32::from(u8::MAX - self.from_current) * self.ticks.min(RISE_TICKS) / RISE_TICKS;
        let current = self.from_current.saturating_add(u8::try_from(rise).unwrap_or(u8::MAX));
        let turning = self.ticks.saturating_sub(RISE_TICKS);
        Order::Field { phase: phase_between(self.from_phase, QUARTER, turning), current }
    }
}

/// The field on its way from one place to another, `ticks` after it left.
fn phase_between(from: i32, to: i32, ticks: u32) -> u16 {
    let part = i32::try_from(ticks.min(TURN_TICKS)).unwrap_or(0);
    let phase = from + (to - from) * part / TURN_TICKS.cast_signed();
    u16::try_from(phase.rem_euclid(PERIOD)).unwrap_or(0)
}

/// Whether the rotor went back by a full step, give or take a quarter of it and a count.
fn is_full_step(counts: i32, scale: &EncoderScale) -> bool {
    let (counts, full_step) = (i64::from(counts), i64::from(QUARTER));
    scale.microsteps(counts - 1) <= full_step * 5 / 4 && scale.microsteps(counts + 1) >= full_step * 3 / 4
}

#[cfg(test)]
mod tests {
    extern crate std;

    use std::vec::Vec;

    use super::*;

    /// Runs one with an encoder that shows `count` where the field is, and returns how it ends and when.
    fn run(scale: &EncoderScale, count: impl Fn(u16) -> i32) -> (Order, u32) {
        let (mut alignment, mut phase) = (Alignment::new(0, 0), 0);
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
        assert_eq!(run(&scale, i32::from), (Order::Aligned, 20_000));
    }

    /// Where the field is, and how much current it has, in the first stage.
    fn first_stage(phase: u16, current: u8) -> Vec<(u16, u8)> {
        let mut alignment = Alignment::new(phase, current);
        let fields = (1..STAGE_TICKS).map(|_| match alignment.tick(0, &scale(4000)) {
            Order::Field { phase, current } => (phase, current),
            other => panic!("{other:?}"),
        });
        fields.collect()
    }

    #[test]
    fn the_current_rises_within_100_ms_from_what_it_was_while_the_field_stays() {
        let fields = first_stage(700, 100);
        assert_eq!((fields[0], fields[1000], fields[1999]), ((700, 100), (700, 177), (700, 255)));
        assert!(fields.windows(2).all(|pair| pair[0].1 <= pair[1].1));
        assert_eq!(fields.last(), Some(&(256, 255)));
    }

    #[test]
    fn the_field_turns_the_shorter_way_and_never_jumps() {
        for phase in (0..1024).step_by(16) {
            let fields = first_stage(phase, 255);
            let turned = |a: u16, b: u16| (i32::from(b) - i32::from(a) + 512).rem_euclid(1024) - 512;
            assert!(fields.windows(2).all(|pair| turned(pair[0].0, pair[1].0).abs() <= 1), "{phase}");
            let way: i32 = fields.windows(2).map(|pair| turned(pair[0].0, pair[1].0)).sum();
            assert!(way.abs() <= 512, "{phase}: {way}");
            assert_eq!(fields.last(), Some(&(256, 255)));
        }
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
