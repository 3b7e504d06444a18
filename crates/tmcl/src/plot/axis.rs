//! An axis: the range it shows, and ticks at multiples of 1, 2 or 5 times a power of ten.

use super::number::{Notation, exponent, power_of_ten};

/// Larger values are drawn as if they were this large, so that differences stay finite.
const LARGEST: f64 = 1e300;

/// Smaller values are drawn as 0.
const SMALLEST: f64 = 1e-290;

/// Values that differ by less than this part of themselves are the same value: what is left is rounding, and to spread it
/// over a panel would mislead.
const SAME: f64 = 1e-6;

/// A range of values and where its ticks are.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Axis {
    low: f64,
    high: f64,
    /// In ascending order.
    pub(super) ticks: Vec<Tick>,
    /// The unit the labels are in: the axis's own, with a prefix where that helps.
    pub(super) unit: String,
}

/// A labelled place on an axis.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tick {
    /// In the axis's own unit, without prefix.
    pub(super) value: f64,
    pub(super) label: String,
}

impl Axis {
    /// An axis that shows `range`, widened at both ends by a `margin`th of it, with at most `most_ticks` (two at least)
    /// ticks. Without a range it shows 0 to 1, and a single value stands in its middle.
    pub(super) fn new(range: Option<(f64, f64)>, margin: f64, unit: &str, most_ticks: usize) -> Self {
        let (low, high) = shown(range.unwrap_or((0.0, 1.0)), margin);
        let step = step(low, high, most_ticks.max(2));
        let (first, last) = multiples(low, high, step);
        let count = (last - first) as u32;
        let values: Vec<f64> = (0..=count).map(|index| (first + f64::from(index)) * step).collect();
        let largest = values.iter().fold(step, |largest, value| value.abs().max(largest));
        let notation = Notation::new(largest, step, unit);
        let tick = |value| Tick { value, label: notation.write(value) };
        Self { low, high, ticks: values.into_iter().map(tick).collect(), unit: notation.unit.clone() }
    }

    /// Where a value lies: 0 at the low end, 1 at the high end.
    pub(super) fn fraction(&self, value: f64) -> f64 {
        ((value.clamp(-LARGEST, LARGEST) - self.low) / (self.high - self.low)).clamp(0.0, 1.0)
    }

    /// Whether 0 lies within, not at an end.
    pub(super) fn crosses_zero(&self) -> bool {
        self.low < 0.0 && self.high > 0.0
    }

    /// The length of the longest label, in characters.
    pub(super) fn label_width(&self) -> usize {
        self.ticks.iter().map(|tick| tick.label.chars().count()).max().unwrap_or(0)
    }
}

fn shown((low, high): (f64, f64), margin: f64) -> (f64, f64) {
    let (low, high) = (low.clamp(-LARGEST, LARGEST), high.clamp(-LARGEST, LARGEST));
    let size = low.abs().max(high.abs());
    if high - low > (SAME * size).max(SMALLEST) {
        let margin = margin * (high - low);
        return (low - margin, high + margin);
    }
    if size < SMALLEST {
        return (-1.0, 1.0);
    }
    let middle = f64::midpoint(low, high);
    (middle - 0.1 * size, middle + 0.1 * size)
}

/// The smallest step that does not give more ticks than allowed.
fn step(low: f64, high: f64, most_ticks: usize) -> f64 {
    let power = power_of_ten(exponent((high - low) / most_ticks as f64));
    let steps = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power);
    let fits = |step: &f64| {
        let (first, last) = multiples(low, high, *step);
        last - first < most_ticks as f64
    };
    steps.into_iter().find(fits).unwrap_or(20.0 * power)
}

/// The first and last multiple of the step in the range; an end that is a multiple but for rounding counts.
fn multiples(low: f64, high: f64, step: f64) -> (f64, f64) {
    ((low / step - 1e-6).ceil(), (high / step + 1e-6).floor())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn labels(low: f64, high: f64, unit: &str, most_ticks: usize) -> Vec<String> {
        Axis::new(Some((low, high)), 0.0, unit, most_ticks).ticks.into_iter().map(|tick| tick.label).collect()
    }

    #[test]
    fn ticks_are_where_one_would_put_them() {
        assert_eq!(labels(0.0, 400.0, "rpm", 5), ["0", "100", "200", "300", "400"]);
        assert_eq!(labels(-1.4, 1.4, "A", 7), ["−1.0", "−0.5", "0", "0.5", "1.0"]);
        assert_eq!(labels(0.0, 2.0, "s", 10), ["0", "0.5", "1.0", "1.5", "2.0"]);
        assert_eq!(labels(0.0, 51_200.0, "pps", 4), ["0", "20k", "40k"]);
        assert_eq!(labels(0.0, 0.03, "s", 4), ["0", "10", "20", "30"]);
    }

    #[test]
    fn a_constant_stands_in_the_middle() {
        assert!((Axis::new(Some((24.0, 24.0)), 0.05, "V", 5).fraction(24.0) - 0.5).abs() < 1e-12);
        let zero = Axis::new(Some((0.0, 0.0)), 0.05, "V", 5);
        assert!((zero.fraction(0.0) - 0.5).abs() < 1e-12 && zero.crosses_zero());
    }

    proptest! {
        #[test]
        fn some_ticks_within_the_range(a: f64, b: f64, margin in 0.0..0.1, most_ticks in 2_usize..12) {
            let (low, high) = if a <= b { (a, b) } else { (b, a) };
            prop_assume!(low.is_finite() && high.is_finite());
            let axis = Axis::new(Some((low, high)), margin, "A", most_ticks);
            prop_assert!((1..=most_ticks).contains(&axis.ticks.len()), "{axis:?}");
            for pair in axis.ticks.windows(2) {
                prop_assert!(pair[0].value < pair[1].value && pair[0].label != pair[1].label, "{axis:?}");
            }
            let slack = 1e-5 * (axis.high - axis.low);
            for tick in &axis.ticks {
                prop_assert!((axis.low - slack..=axis.high + slack).contains(&tick.value), "{axis:?}");
            }
            prop_assert!((0.0..=1.0).contains(&axis.fraction(low)) && axis.fraction(low) <= axis.fraction(high));
        }

        #[test]
        fn labels_say_the_value(low in -1e4..1e4, size in 0.1..1e4) {
            let axis = Axis::new(Some((low, low + size)), 0.0, "rpm", 6);
            let step = axis.ticks.windows(2).map(|pair| pair[1].value - pair[0].value).next().unwrap_or(1.0);
            for tick in axis.ticks {
                let text = tick.label.replace('−', "-");
                let read = match text.strip_suffix('k') {
                    Some(thousands) => 1000.0 * thousands.parse::<f64>().unwrap(),
                    None => text.parse().unwrap(),
                };
                prop_assert!((read - tick.value).abs() < 1e-6 * step, "{text} for {}", tick.value);
            }
        }
    }
}
