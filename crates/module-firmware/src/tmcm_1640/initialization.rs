//! Finding the encoder's commutation offset (§5, AP 249 with 165, 177, 241 and 244; decision).
//!
//! An incremental encoder does not know where it is after power-on. Mode 0 pulls the rotor to a known angle; mode 1 turns by the
//! hall sensors until one of them changes, which tells the angle exactly; mode 2 turns the rotor to the N channel, from which
//! on a stored offset applies.

use super::{AxisParameter, Tmcm1640};
use crate::{TICKS_PER_MS, TICKS_PER_SECOND};

/// 90° electrical.
const QUARTER_TURN: u16 = 0x4000;

/// An electrical angle in parts that make the smallest velocity exact: 1/65 536 of a turn, and 1/2³² of that.
const FRACTION_BITS: u32 = 32;

/// An initialisation that runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Initialization {
    /// Begins with the next control period in which the power stage may be on, with the settings of that time.
    Due,
    /// Mode 0: the field stands at 90°, then at 0°, half of `ticks_left` each.
    Pull { ticks_left: u64, half_ticks: u64 },
    /// Mode 1: block commutation until the sector changes from this one.
    Halls { sector: Option<u8> },
    /// Mode 2: the field turns, at an angle with [`FRACTION_BITS`].
    Turn { angle: u64, step: u64 },
}

impl Initialization {
    /// The angle of the field's current; by the hall sensors' where these commutate.
    pub(super) fn angle(&self, hall_angle: u16) -> u16 {
        match *self {
            Self::Pull { ticks_left, half_ticks } if ticks_left > half_ticks => QUARTER_TURN,
            Self::Due | Self::Pull { .. } => 0,
            Self::Halls { .. } => hall_angle,
            Self::Turn { angle, .. } => (angle >> FRACTION_BITS) as u16, // wraps
        }
    }

    /// Whether the current points along the field's angle, and drags the rotor there.
    pub(super) fn drags(&self) -> bool {
        !matches!(self, Self::Halls { .. })
    }
}

impl Tmcm1640 {
    /// AP 31, a write of AP 159 = 7, power-on with it: begins as AP 249 says.
    pub(super) fn begin_initialization(&mut self) {
        if !self.is_encoder_mode() {
            self.initialization = None;
            return;
        }
        self.reset_regulation();
        // Not yet as AP 249 says: at power-on that is restored after AP 159.
        self.initialization = Some(Initialization::Due);
    }

    /// The power stage went off: whatever the rotor was led to, it may have left again.
    pub(super) fn interrupt_initialization(&mut self) {
        self.initialization = self.initialization.map(|_| Initialization::Due);
    }

    /// What AP 249 says.
    fn first_step(&mut self) -> Initialization {
        match self.kept_value(AxisParameter::InitSineMode) {
            1 => Initialization::Halls { sector: self.halls.sector() },
            2 => {
                // AP 165 is a place on the disc, whatever was found before.
                self.encoder.offset_floats = false;
                Initialization::Turn { angle: 0, step: self.init_step() }
            }
            _ => {
                let delay_ms = self.kept_value(AxisParameter::InitSineDelay).max(0).unsigned_abs();
                let half_ticks = u64::from(delay_ms) * TICKS_PER_MS / 2;
                Initialization::Pull { ticks_left: 2 * half_ticks, half_ticks }
            }
        }
    }

    /// How far the field turns in a control period at AP 241.
    fn init_step(&self) -> u64 {
        let rpm = i128::from(self.kept_value(AxisParameter::InitVelocity));
        let turns_per_tick = (rpm * i128::from(self.pole_pairs())) << (FRACTION_BITS + 16);
        (turns_per_tick / (60 * i128::from(TICKS_PER_SECOND))) as u64 // whole turns do not matter
    }

    /// A control period of an initialisation, while the power stage is on.
    pub(super) fn initialize_on(&mut self) {
        if self.initialization == Some(Initialization::Due) {
            self.initialization = Some(self.first_step());
            return;
        }
        match &mut self.initialization {
            None | Some(Initialization::Due) => {}
            Some(Initialization::Pull { ticks_left: 0, .. }) => self.finish_initialization(0),
            Some(Initialization::Pull { ticks_left, .. }) => *ticks_left -= 1,
            Some(Initialization::Turn { .. }) if self.sensed.encoder_index => {
                self.initialization = None;
                self.reset_regulation();
            }
            Some(Initialization::Turn { angle, step }) => *angle = angle.wrapping_add(*step),
            Some(Initialization::Halls { sector }) => {
                let before = *sector;
                *sector = self.halls.sector();
                if let Some(angle) = self.halls.edge().filter(|_| before != self.halls.sector()) {
                    self.finish_initialization(angle);
                }
            }
        }
    }

    /// The rotor stands at this electrical angle: AP 165 follows from where the encoder is.
    fn finish_initialization(&mut self, angle: u16) {
        let steps = self.encoder_steps();
        let turned = i64::from(angle) * steps / (self.pole_pairs() << 16);
        self.set_commutation_offset(self.encoder.within_turn - turned);
        self.encoder.offset_floats = !self.encoder.referenced;
        self.initialization = None;
        self.reset_regulation();
    }
}
