//! A power stage that is two places in memory: where converters and timers of a real board would be.

use core::marker::PhantomData;

use crate::module::PowerStage;

/// The board's second block of RAM, which the image itself does not use.
const SENSED: usize = 0x2010_0000;
const DRIVE: usize = 0x2010_1000;

/// What sensors say is read from one place, and what the power stage shall do written to another. A debugger can play motor.
pub struct Exchange<S, D>(PhantomData<(S, D)>);

impl<S: Default, D> Exchange<S, D> {
    /// Sensors that say nothing yet.
    #[must_use]
    pub fn new() -> Self {
        // SAFETY: this RAM is there and nobody else's, it is aligned for anything, and so large.
        unsafe { (SENSED as *mut S).write_volatile(S::default()) };
        Self(PhantomData)
    }
}

impl<S: Default, D> Default for Exchange<S, D> {
    fn default() -> Self {
        Self::new()
    }
}

impl<S: Copy, D: Copy> PowerStage for Exchange<S, D> {
    type Sensed = S;
    type Drive = D;

    fn sensed(&mut self) -> S {
        // SAFETY: `new` has written a value there.
        unsafe { (SENSED as *const S).read_volatile() }
    }

    fn drive(&mut self, drive: &D) {
        // SAFETY: as in `new`.
        unsafe { (DRIVE as *mut D).write_volatile(*drive) };
    }
}
