//! How large a panel is, and its axes.

use crate::plot::axis::Axis;
use crate::plot::{Figure, Panel};

/// Of a panel over time.
const TIME_HEIGHT: f64 = 132.0;
/// Of a panel over something else.
const XY_HEIGHT: f64 = 220.0;
/// Of a panel over something in the same unit: as wide as high, so that a circle is round.
const SQUARE: f64 = 300.0;
/// The part of the values' range that is left free at each end.
const MARGIN: f64 = 0.06;

/// What is known of a panel before it has its place.
pub(super) struct Shape {
    pub(super) height: f64,
    /// Without one it is as wide as there is room.
    pub(super) width: Option<f64>,
    /// To the right.
    pub(super) across: Axis,
    /// Upwards.
    pub(super) value: Axis,
}

impl Shape {
    pub(super) fn new(figure: &Figure, panel: &Panel) -> Self {
        let (range, value) = (figure.across_range(panel), figure.value_range(panel));
        let upwards = |range, ticks| Axis::new(range, MARGIN, &panel.unit, ticks);
        match &panel.across {
            None => Self {
                height: TIME_HEIGHT,
                width: None,
                across: Axis::new(range, 0.0, "s", 11),
                value: upwards(value, 6),
            },
            Some(across) if across.unit == panel.unit => {
                let (range, value) = as_wide(range, value);
                let across = Axis::new(range, MARGIN, &across.unit, 7);
                Self { height: SQUARE, width: Some(SQUARE), across, value: upwards(value, 7) }
            }
            Some(across) => Self {
                height: XY_HEIGHT,
                width: None,
                across: Axis::new(range, 0.02, &across.unit, 11),
                value: upwards(value, 7),
            },
        }
    }
}

type Range = Option<(f64, f64)>;

/// Both ranges about their middles, the smaller one as wide as the other.
fn as_wide(first: Range, second: Range) -> (Range, Range) {
    let (Some(first), Some(second)) = (first, second) else { return (first, second) };
    let half = |(low, high): (f64, f64)| high / 2.0 - low / 2.0;
    let larger = half(first).max(half(second));
    let widened = |(low, high): (f64, f64)| {
        let middle = f64::midpoint(low, high);
        Some((middle - larger, middle + larger))
    };
    (widened(first), widened(second))
}
