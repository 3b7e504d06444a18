//! Current regulation: the share of the current that a position error calls for, and how fast it follows (TMCM-1311 §8.8).
//!
//! A share is a factor of 0 to 255: (factor + 1)/256 of the current. The error gives a target, and the actual factor moves
//! towards it in steps with a pause after each.
//!
//! The pause is kept as the time since the last step, which each direction compares with its own delay (decision). One
//! timer for both, as §8.8 may be read, would hold an increase back for the delay of the decrease before it; parameter 120
//! says "between two increments".
//!
//! This module must never know what the error is measured in, nor amperes.

/// What the regulation does; the parameters of TMCM-1311 §8.8.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CurrentScaleSettings {
    /// The factor while the error is at most `lower_error`.
    pub minimum: u8,
    /// The factor from `upper_error` on. One below `minimum` is legal: the factor then falls as the error grows.
    pub maximum: u8,
    /// The error the factor begins to change at.
    pub lower_error: u32,
    /// The error the factor ends to change at; one not above `lower_error` acts as the next above that (decision).
    pub upper_error: u32,
    /// A step up. 0 never moves, but with a delay of 0.
    pub increment: u8,
    /// A step down. 0 never moves, but with a delay of 0.
    pub decrement: u8,
    /// Control periods from a step to the next increment; 0 sets a target above at once.
    pub increment_ticks: u32,
    /// Control periods from a step to the next decrement; 0 sets a target below at once.
    pub decrement_ticks: u32,
}

/// The state of the regulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CurrentScale {
    actual: u8,
    target: u8,
    /// Control periods since the last step, while one of the delays still counts; then `u32::MAX`, so that rest is exact.
    ticks_since_step: u32,
}

impl CurrentScale {
    /// Settled at this factor; the first step does not wait.
    #[must_use]
    pub const fn new(actual: u8) -> Self {
        Self { actual, target: actual, ticks_since_step: u32::MAX }
    }

    /// The factor now.
    #[must_use]
    pub fn actual(&self) -> u8 {
        self.actual
    }

    /// The factor that the error of the last tick called for.
    #[must_use]
    pub fn target(&self) -> u8 {
        self.target
    }

    /// One control period with this magnitude of the error.
    pub fn tick(&mut self, error: u32, settings: &CurrentScaleSettings) {
        self.target = target(error, settings);
        let elapsed = self.ticks_since_step.saturating_add(1);
        let counts = elapsed < settings.increment_ticks.max(settings.decrement_ticks);
        self.ticks_since_step = if counts { elapsed } else { u32::MAX };
        let rises = self.target > self.actual;
        let (step, delay) = if rises {
            (settings.increment, settings.increment_ticks)
        } else {
            (settings.decrement, settings.decrement_ticks)
        };
        let next = match (delay, rises) {
            (0, _) => self.target,
            _ if self.ticks_since_step < delay => return,
            (_, true) => self.actual.saturating_add(step).min(self.target),
            (_, false) => self.actual.saturating_sub(step).max(self.target),
        };
        if next != self.actual {
            self.actual = next;
            self.ticks_since_step = 0;
        }
    }

    /// The regulation is off: the whole current, at once.
    pub fn full(&mut self) {
        *self = Self::new(u8::MAX);
    }
}

/// A current scaled by a factor: `value` · (`factor` + 1)/256, rounded to the nearest, halves away from zero. Both
/// directions are alike, and the result is never the larger one.
#[must_use]
pub fn scaled(value: i16, factor: u8) -> i16 {
    let magnitude = (i32::from(value).abs() * (i32::from(factor) + 1) + 128) >> 8;
    let scaled = if value < 0 { -magnitude } else { magnitude };
    // It fits, being no larger than the value.
    i16::try_from(scaled).unwrap_or(value)
}

/// The factor an error calls for: linear between the limits, rounded to the nearest, halves towards the maximum.
fn target(error: u32, settings: &CurrentScaleSettings) -> u8 {
    let &CurrentScaleSettings { minimum, maximum, lower_error, upper_error, .. } = settings;
    if error <= lower_error {
        return minimum;
    }
    // Nothing lies between errors that are equal or the wrong way round.
    if error >= upper_error {
        return maximum;
    }
    let (above, span) = (error - lower_error, upper_error - lower_error);
    let change = rounded_share(maximum.abs_diff(minimum), above, span);
    if maximum >= minimum { minimum.saturating_add(change) } else { minimum.saturating_sub(change) }
}

/// `whole` · `part`/`parts`, where `part` is below `parts`: in 32 bits, unless the errors are very far apart.
fn rounded_share(whole: u8, part: u32, parts: u32) -> u8 {
    let product = part.checked_mul(u32::from(whole)).and_then(|product| product.checked_add(parts / 2));
    let share = match product {
        Some(product) => product / parts,
        None => ((u64::from(part) * u64::from(whole) + u64::from(parts / 2)) / u64::from(parts)) as u32,
    };
    u8::try_from(share).unwrap_or(whole)
}

#[cfg(test)]
mod tests;
