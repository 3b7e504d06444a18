//! What can be written to the chip over SPI, as far as it changes its averaged behaviour.

use crate::stepper::CoolStep;

/// The chip's registers. The default is the state after power-on: all zero, bridges off.
///
/// A field that holds more than its register has bits for acts as the largest value that fits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Registers {
    /// Who makes the coil currents (SDOFF with DRVCTRL).
    pub coils: Coils,
    /// CS, 0 to 31: 1/32 to 32/32 of the board's full-scale current.
    pub current_scale: u8,
    /// VSENSE: half the full-scale current.
    pub half_scale: bool,
    /// TOFF, 0 to 15: the chopper's off time. 0 switches the bridges off; how long the others are is averaged away.
    pub off_time: u8,
    /// SGT, −64 to 63: a higher value makes stallGuard2 less sensitive.
    pub stallguard_threshold: i8,
    /// SFILT: one stallGuard2 reading in four full steps instead of one in each.
    pub stallguard_filter: bool,
    /// SMARTEN.
    pub coolstep: CoolStep,
    /// DISS2G: shorts to ground do not switch the bridges off.
    pub short_protection_disabled: bool,
}

/// Where the coil currents come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coils {
    /// SDOFF = 1: currents A and B, signed, in 1/248 of the current scale. Beyond 248 the chopper's hysteresis lets no more
    /// current through.
    Direct([i16; 2]),
    /// SDOFF = 0: the chip's own sequencer follows the STEP input.
    StepDirection {
        /// MRES, 0 to 8: a step moves by 2^MRES of the 256 microsteps of a full step.
        microstep_resolution: u8,
    },
}

impl Default for Coils {
    fn default() -> Self {
        Self::StepDirection { microstep_resolution: 0 }
    }
}
