//! The current vector of a two-phase stepper: sine and cosine over 1024 microsteps of an electrical period.

/// Microsteps of 1/256 full step in an electrical period of four full steps.
pub const PERIOD: u16 = 1024;

/// Length of the vector: the largest coil current that [`vector`] asks for.
///
/// 248, not 255: the TMC262 loses the top of the wave to its chopper hysteresis (datasheet, "Direct coil current
/// setting").
pub const AMPLITUDE: i16 = 248;

/// Steps of a quarter wave.
pub(crate) const QUARTER: usize = 256;

/// Fractional bits of the recurrence that builds the table.
const FRACTION: u32 = 60;

static QUARTER_WAVE: [i16; QUARTER + 1] = quarter_wave(AMPLITUDE);

/// sin(k·π/512)·`amplitude` for k = 0…256, by the exact recurrence s(k+1) = 2·cos(π/512)·s(k) − s(k−1).
pub(crate) const fn quarter_wave(amplitude: i16) -> [i16; QUARTER + 1] {
    // π/512 in 60 fractional bits; its sine and cosine by their series, three terms being far below one unit of i16.
    const STEP: i128 = 7_074_237_752_028_440; // round(π/512 · 2^60)
    let square = (STEP * STEP) >> FRACTION;
    let one = 1_i128 << FRACTION;
    let sine = (STEP * (one - square / 6 + ((square * square) >> FRACTION) / 120)) >> FRACTION;
    let cosine = one - square / 2 + ((square * square) >> FRACTION) / 24;
    let mut table = [0; QUARTER + 1];
    let (mut previous, mut present) = (0_i128, sine);
    let mut index = 1;
    while index <= QUARTER {
        let scaled = (present * amplitude as i128 + (one >> 1)) >> FRACTION;
        #[expect(
            clippy::indexing_slicing,
            reason = "evaluated at compile time: out of range would not compile"
        )]
        {
            table[index] = scaled as i16;
        }
        (previous, present) = (present, ((2 * cosine * present) >> FRACTION) - previous);
        index += 1;
    }
    table
}

/// The coil currents (A, B) whose field stands at `phase` microsteps: A = cos, B = sin, in units of
/// 1/[`AMPLITUDE`] of the current scale.
#[must_use]
pub fn vector(phase: u16) -> (i16, i16) {
    (wave(phase.wrapping_add(PERIOD / 4)), wave(phase))
}

fn wave(phase: u16) -> i16 {
    let within = usize::from(phase % (PERIOD / 4));
    let at = |index: usize| QUARTER_WAVE.get(index).copied().unwrap_or(0);
    match (phase / (PERIOD / 4)) % 4 {
        0 => at(within),
        1 => at(QUARTER - within),
        2 => -at(within),
        _ => -at(QUARTER - within),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_vector_follows_sine_and_cosine_to_half_a_unit() {
        for phase in 0..4 * PERIOD {
            let angle = f64::from(phase) * core::f64::consts::TAU / f64::from(PERIOD);
            let (a, b) = vector(phase);
            assert!((f64::from(a) - 248.0 * libm::cos(angle)).abs() < 0.501, "A at {phase}: {a}");
            assert!((f64::from(b) - 248.0 * libm::sin(angle)).abs() < 0.501, "B at {phase}: {b}");
        }
    }
}
