//! What the hardware of every module has, whatever it drives.

use motor_physics::encoder::{Encoder, EncoderConfig, EncoderFault};
use motor_physics::switch::{LimitSwitch, SwitchFault};

use crate::parts::EncoderParts;
use crate::{Contact, EncoderLine};

/// A control period in seconds.
pub const PERIOD_S: f64 = 50e-6;

/// How often the temperatures are brought up to date.
pub(crate) const HEAT_NS: u64 = 100_000_000;

/// What a board takes for itself (chosen).
pub(crate) const BOARD_W: f64 = 1.5;

/// The encoder, switched on with the shaft at `turns`.
pub(crate) fn encoder(parts: &EncoderParts, turns: f64) -> Encoder {
    let &EncoderParts { counts, offset_turns, inverted, index } = parts;
    let mut encoder = Encoder::new(EncoderConfig { counts_per_turn: counts, offset_turns, inverted }, turns);
    encoder.fault = encoder_fault(None, index);
    encoder
}

/// The same encoder with a counter that starts at 0 again.
pub(crate) fn restarted(encoder: &Encoder, turns: f64) -> Encoder {
    let mut restarted = Encoder::new(encoder.config(), turns);
    restarted.fault = encoder.fault;
    restarted
}

/// An encoder without an index is one whose index never comes.
pub(crate) fn encoder_fault(line: Option<EncoderLine>, has_index: bool) -> EncoderFault {
    match line {
        None if has_index => EncoderFault::None,
        Some(EncoderLine::A) => EncoderFault::LineA,
        Some(EncoderLine::B) => EncoderFault::LineB,
        None | Some(EncoderLine::Index) => EncoderFault::Index,
    }
}

/// These levels with one of them set.
#[must_use]
pub fn with_level(levels: u8, number: u8, high: bool) -> u8 {
    let bit = 1_u8.checked_shl(number.into()).unwrap_or(0);
    if high { levels | bit } else { levels & !bit }
}

/// Makes a contact stick, or works it again.
pub(crate) fn stick(switch: Option<&mut LimitSwitch>, stuck: Option<Contact>) {
    if let Some(switch) = switch {
        switch.fault = match stuck {
            None => SwitchFault::None,
            Some(Contact::Open) => SwitchFault::StuckOpen,
            Some(Contact::Closed) => SwitchFault::StuckClosed,
        };
    }
}

/// The nearest whole number, halves away from 0; what is beyond 16 bits ends there.
pub(crate) fn rounded(value: f64) -> i16 {
    (value + libm::copysign(0.5, value)) as i16
}

pub(crate) fn seconds(time_ns: u64) -> f64 {
    time_ns as f64 * 1e-9
}
