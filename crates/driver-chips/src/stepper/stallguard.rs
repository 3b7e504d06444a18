//! stallGuard2: how much load the motor could still take, from the power that the current gives to the back-EMF.
//!
//! Model (decisions §5.5): SG = clamp(g · (1 − |sin δ|) + 8 · SGT, 0, 1023) with the load angle δ between the commanded
//! current and the rotor, and g = 500 · min(1, v / 1 rps) · clamp((U − E − I·R) / 0.25 U, 0, 1). What varies is averaged
//! over the full step, or with SFILT over four of them, as the silicon integrates it.

use super::Pins;
use super::table::Command;

/// The reading of an unloaded motor with SGT = 0.
const GAIN: f64 = 500.0;

/// Below this the back-EMF is too small to measure.
const FULL_VELOCITY_RPS: f64 = 1.0;

/// The part of the supply that the regulator needs as headroom.
const HEADROOM: f64 = 0.25;

/// What a step of SGT adds to a reading.
const THRESHOLD_UNIT: f64 = 8.0;

const LARGEST_READING: f64 = 1023.0;

/// Full steps in a reading with SFILT.
const FILTER_FULL_STEPS: u8 = 4;

/// What of the measurement can be set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct StallGuard {
    /// SGT, −64 to 63.
    pub(crate) threshold: i8,
    /// SFILT: one reading in four full steps instead of one in each.
    pub(crate) filter: bool,
}

/// The chip's measurement.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Measurement {
    value: u16,
    /// The quadrant of the commanded vector: a full step is from one to the next.
    quadrant: Option<u8>,
    window: Window,
}

/// What was sampled since the last reading.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Window {
    full_steps: u8,
    samples: u32,
    velocity_sum_rps: f64,
    freedom_sum: f64,
}

impl Measurement {
    /// The last reading, 0 to 1023.
    pub(crate) fn value(&self) -> u16 {
        self.value
    }

    /// Forgets what was sampled since the last reading: the bridges are off.
    pub(crate) fn interrupt(&mut self) {
        self.quadrant = None;
        self.window = Window::default();
    }

    /// A sample of a period in which the commanded vector turned; says a new reading when there is one.
    ///
    /// At most one full step is seen in a period.
    pub(crate) fn sample(
        &mut self,
        command: Command,
        peak_current_a: f64,
        pins: &Pins,
        settings: StallGuard,
    ) -> Option<u16> {
        let quadrant = quadrant(command.vector);
        let reading = if self.quadrant.is_some_and(|before| before != quadrant) {
            self.window.full_steps += 1;
            self.window.reading(settings)
        } else {
            None
        };
        if let Some(value) = reading {
            self.value = value;
            self.window = Window::default();
        }
        self.quadrant = Some(quadrant);
        self.window.samples = self.window.samples.saturating_add(1);
        self.window.velocity_sum_rps += pins.rotor_velocity_rps * f64::from(command.direction);
        // The pins show the beginning of the period, where the coils carry what was commanded for the one before.
        let freedom = freedom(command.before, pins);
        if freedom > 0.0 {
            self.window.freedom_sum += freedom * headroom(peak_current_a, pins);
        }
        reading
    }
}

impl Window {
    /// The reading, if enough full steps are in.
    fn reading(&self, settings: StallGuard) -> Option<u16> {
        let needed = if settings.filter { FILTER_FULL_STEPS } else { 1 };
        if self.full_steps < needed {
            return None;
        }
        let samples = f64::from(self.samples.max(1));
        // A rotor that swings about one place has no velocity on the average: that is what a stall looks like.
        let speed = (self.velocity_sum_rps / samples / FULL_VELOCITY_RPS).clamp(0.0, 1.0);
        let threshold = THRESHOLD_UNIT * f64::from(settings.threshold.clamp(-64, 63));
        let reading = GAIN * speed * self.freedom_sum / samples + threshold;
        Some(reading.clamp(0.0, LARGEST_READING) as u16)
    }
}

/// 1 − |sin δ|, and 0 from 90° on, where the rotor can follow no longer.
///
/// For a commanded unit vector u and the back-EMF e: u·e = |e| sgn(v) sin δ and u×e = |e| sgn(v) cos δ.
fn freedom(vector: [i16; 2], pins: &Pins) -> f64 {
    let [u_a, u_b] = vector.map(f64::from);
    let [e_a, e_b] = pins.back_emf_v;
    let product = libm::sqrt((u_a * u_a + u_b * u_b) * (e_a * e_a + e_b * e_b));
    let ahead = (u_a * e_b - u_b * e_a) * pins.rotor_velocity_rps;
    if product == 0.0 || ahead <= 0.0 {
        return 0.0;
    }
    (1.0 - (u_a * e_a + u_b * e_b).abs() / product).max(0.0)
}

/// How well the regulator can do its work, 0 to 1, with what back-EMF and resistance leave of the supply.
fn headroom(peak_current_a: f64, pins: &Pins) -> f64 {
    let [e_a, e_b] = pins.back_emf_v;
    let squared_v2 = e_a * e_a + e_b * e_b;
    let needed_v = HEADROOM * pins.bus_voltage_v;
    let driven_v = pins.bus_voltage_v - peak_current_a * pins.resistance_ohm;
    // Most motors have enough, which takes no root to see.
    if driven_v > needed_v && squared_v2 < (driven_v - needed_v) * (driven_v - needed_v) {
        return 1.0;
    }
    let left_v = driven_v - libm::sqrt(squared_v2);
    if left_v <= 0.0 { 0.0 } else { (left_v / needed_v).min(1.0) }
}

fn quadrant([a, b]: [i16; 2]) -> u8 {
    match (a, b) {
        (1.., 0..) => 0,
        (..=0, 1..) => 1,
        (..=-1, ..=0) => 2,
        _ => 3,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quadrants_are_full_steps_of_a_period() {
        let around = [[248, 0], [175, 175], [0, 248], [-1, 1], [-248, 0], [-175, -175], [0, -248], [1, -1]];
        assert_eq!(around.map(quadrant), [0, 0, 1, 1, 2, 2, 3, 3]);
    }
}
