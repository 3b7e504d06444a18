//! The 21 coordinates of SCO, GCO, CCO and MVP COORD (TMCM-1311 §5.7.24 to §5.7.27).
//!
//! Coordinate 0 lives in RAM only; 1 to 20 can be copied to and from EEPROM, and are written through and restored at
//! power-on while global parameter 84 is 1.

use crate::axis::Axis;
use crate::firmware::Firmware;
use crate::values::Values;

/// How many there are.
pub(crate) const COUNT: u8 = 21;

/// The coordinates in RAM.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Coordinates(Values<{ COUNT as usize }>);

impl Coordinates {
    /// All zero, as after power-on.
    pub(crate) const fn new() -> Self {
        Self(Values::zero())
    }

    pub(crate) fn get(&self, number: u8) -> i32 {
        self.0.get(usize::from(number))
    }

    pub(crate) fn set(&mut self, number: u8, position: i32) {
        self.0.set(usize::from(number), position);
    }
}

impl<A: Axis> Firmware<A> {
    /// What GCO would read from RAM, for those who look on. None where the module has no such coordinate.
    #[must_use]
    pub fn peek_coordinate(&self, number: u8) -> Option<i32> {
        (number < A::SPEC.coordinates).then(|| self.coordinates.get(number))
    }
}
