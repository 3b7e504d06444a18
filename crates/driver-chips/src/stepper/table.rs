//! The microstep table, and the current vector that it commands.

use core::f64::consts::PI;

/// Length of the longest vector (datasheet, "Direct coil current setting").
pub(crate) const AMPLITUDE: i16 = 248;

/// Microsteps in an electrical period.
pub(crate) const PERIOD: i32 = 1024;

const QUARTER: usize = 256;

/// The chip's table: a quarter of a sine at the middle of each microstep, so that mirroring it leaves no gap and no double.
static QUARTER_WAVE: [u8; QUARTER] = quarter_wave();

const fn quarter_wave() -> [u8; QUARTER] {
    let mut table = [0; QUARTER];
    let mut index = 0;
    while index < QUARTER {
        let angle = (index as f64 + 0.5) * PI / 512.0;
        #[expect(
            clippy::indexing_slicing,
            reason = "evaluated at compile time: out of range would not compile"
        )]
        {
            table[index] = (AMPLITUDE as f64 * sine(angle) + 0.5) as u8;
        }
        index += 1;
    }
    table
}

/// The sine of an angle from 0 to π/2 by its series: `libm` does not run at compile time.
const fn sine(angle: f64) -> f64 {
    let (mut sum, mut term, mut order) = (angle, angle, 1.0);
    while order < 20.0 {
        term *= -angle * angle / ((order + 1.0) * (order + 2.0));
        sum += term;
        order += 2.0;
    }
    sum
}

/// What the commanded vector does in a control period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Command {
    /// Currents A and B in 1/[`AMPLITUDE`] of the current scale.
    pub(crate) vector: [i16; 2],
    /// What they were in the period before: what the coils carry when this one begins.
    pub(crate) before: [i16; 2],
    /// It is another one than before, or there were steps (four full steps make the same again).
    pub(crate) changed: bool,
    /// Which way it turned: 1 where its angle grows, −1, or 0 if it did not turn.
    pub(crate) direction: i8,
}

/// The sign of the angle from one vector to another.
pub(crate) fn turn(from: [i16; 2], to: [i16; 2]) -> i8 {
    let ([from_a, from_b], [to_a, to_b]) = (from.map(i32::from), to.map(i32::from));
    (from_a * to_b - from_b * to_a).signum() as i8
}

/// Currents A and B at a position of the microstep counter.
pub(crate) fn vector(position: u16) -> [i16; 2] {
    [wave(position + QUARTER as u16), wave(position)]
}

fn wave(position: u16) -> i16 {
    let within = usize::from(position) % QUARTER;
    let at = |index: usize| QUARTER_WAVE.get(index).copied().map_or(0, i16::from);
    match (position / 256) % 4 {
        0 => at(within),
        1 => at(QUARTER - 1 - within),
        2 => -at(within),
        _ => -at(QUARTER - 1 - within),
    }
}
