//! Where the rotor is, as encoder and hall sensors tell it (§5, AP 1, 159, 165, 209 to 211, 250 to 254).

use motion_control::foc::hall::HallTracker;
use motion_control::foc::speed::HallTachometer;

use super::initialization::Initialization;
use super::{AxisParameter, Tmcm1640};

/// AP 159: the encoder commutates; anything else: the hall sensors.
pub(super) const BY_ENCODER: i32 = 7;

/// Hall sectors in an electrical turn.
const HALL_SECTORS: i64 = 6;

/// The encoder's counter, and where it is within a turn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct EncoderAngle {
    raw: i32,
    /// Counts in the direction of AP 251 since power-on.
    counts: i32,
    /// AP 209 less these.
    offset: i32,
    /// 0 to AP 250 − 1, from the N channel once it was seen.
    pub(super) within_turn: i64,
    /// Whether the N channel was seen since power-on.
    pub(super) referenced: bool,
    /// Whether AP 165 was found without the N channel: a place since power-on, not yet one on the disc.
    pub(super) offset_floats: bool,
}

impl EncoderAngle {
    /// AP 209.
    pub(super) fn counter(&self) -> i32 {
        self.counts.wrapping_add(self.offset)
    }

    fn set_counter(&mut self, counter: i32) {
        self.offset = counter.wrapping_sub(self.counts);
    }
}

impl Tmcm1640 {
    /// Takes note of what the sensors counted since the last control period.
    pub(super) fn follow_sensors(&mut self) {
        self.halls.tick(self.sensed.halls, self.kept_value(AxisParameter::HallSensorInvert) != 0);
        self.follow_encoder();
        self.hall_speed.tick(self.halls.count());
        let counted = self.counted_now();
        self.position = self.position.wrapping_add(counted.wrapping_sub(self.counted));
        self.counted = counted;
        if self.sensed.encoder_index {
            self.take_index();
        }
    }

    /// The lines mean something else from now on: nothing turned.
    pub(super) fn begin_halls_anew(&mut self) {
        self.halls = HallTracker::new();
        self.hall_speed = HallTachometer::new(0);
        self.counted = self.counted_now();
    }

    /// The counts since the N channel were no parts of this turn: it has to come again.
    pub(super) fn forget_index(&mut self) {
        self.encoder.referenced = false;
    }

    fn follow_encoder(&mut self) {
        let raw = self.sensed.encoder_counts;
        let counts = raw.wrapping_sub(self.encoder.raw);
        let counts = if self.kept_value(AxisParameter::EncoderDirection) == 0 {
            counts
        } else {
            counts.wrapping_neg()
        };
        self.encoder.raw = raw;
        self.encoder.counts = self.encoder.counts.wrapping_add(counts);
        let turned = self.encoder.within_turn + i64::from(counts);
        self.encoder.within_turn = turned.rem_euclid(self.encoder_steps());
        self.encoder_speed.tick(self.encoder.counts);
    }

    /// Encoder counts or hall sectors, whatever they are called.
    pub(super) fn counted_now(&self) -> i32 {
        if self.is_encoder_mode() { self.encoder.counts } else { self.halls.count() }
    }

    /// The N channel passed. The first time it makes AP 165, if that was found without it, a place on the encoder's disc: the
    /// angle stays as it is. One that was stored or set is such a place already. A motor that is being turned to the N channel
    /// begins to count there again.
    fn take_index(&mut self) {
        let sought = matches!(self.initialization, Some(Initialization::Turn { .. }));
        if sought || !self.encoder.referenced {
            let offset = self.commutation_offset() - self.encoder.within_turn;
            self.encoder.within_turn = 0;
            self.encoder.referenced = true;
            if self.encoder.offset_floats {
                self.encoder.offset_floats = false;
                self.set_commutation_offset(offset);
            }
        }
        if self.kept_value(AxisParameter::ClearOnNull) != 0 {
            self.zero_position();
            if self.kept_value(AxisParameter::ClearOnce) != 0 {
                self.kept.set(AxisParameter::ClearOnNull.index(), 0);
            }
        }
    }

    /// The counters of the encoder and of the position start anew from 0.
    pub(super) fn zero_position(&mut self) {
        self.redefine_position(0);
        self.encoder.set_counter(0);
    }

    /// SAP 1: calls the present place something else. By encoder, that is what AP 209 reads too.
    pub(super) fn set_position(&mut self, position: i32) {
        self.position = position;
        if self.is_encoder_mode() {
            self.encoder.set_counter(position);
        }
    }

    pub(super) fn is_encoder_mode(&self) -> bool {
        self.kept_value(AxisParameter::CommutationMode) == BY_ENCODER
    }

    /// AP 250, at least 1.
    pub(super) fn encoder_steps(&self) -> i64 {
        i64::from(self.kept_value(AxisParameter::EncoderResolution).cast_unsigned()).max(1)
    }

    /// Half of AP 253.
    pub(super) fn pole_pairs(&self) -> i64 {
        i64::from(self.kept_value(AxisParameter::MotorPoles) / 2).max(1)
    }

    /// What AP 1 counts in a turn: encoder steps, or hall sectors.
    pub(super) fn counts_per_turn(&self) -> i64 {
        if self.is_encoder_mode() { self.encoder_steps() } else { HALL_SECTORS * self.pole_pairs() }
    }

    /// AP 165.
    pub(super) fn commutation_offset(&self) -> i64 {
        i64::from(self.kept_value(AxisParameter::EncoderCommutationOffset))
    }

    /// AP 165, brought into a turn.
    pub(super) fn set_commutation_offset(&mut self, offset: i64) {
        let offset = offset.rem_euclid(self.encoder_steps());
        let offset = i32::try_from(offset).unwrap_or(i32::MAX);
        self.kept.set(AxisParameter::EncoderCommutationOffset.index(), offset);
    }

    /// The rotor's electrical angle by the encoder: 0 where it stands at AP 165.
    pub(super) fn encoder_angle(&self) -> u16 {
        let steps = self.encoder_steps();
        let turned = (self.encoder.within_turn - self.commutation_offset()).rem_euclid(steps);
        let electrical = turned * self.pole_pairs() % steps;
        // Less than a turn: it fits.
        u16::try_from((electrical << 16) / steps).unwrap_or(0)
    }

    /// The rotor's electrical angle by the hall sensors.
    pub(super) fn hall_angle(&self) -> u16 {
        self.halls.angle(self.kept_value(AxisParameter::HallInterpolation) != 0)
    }

    /// The angle that commutates now.
    pub(super) fn commutation_angle(&self) -> u16 {
        match &self.initialization {
            Some(initialization) => initialization.angle(self.hall_angle()),
            None if self.is_encoder_mode() => self.encoder_angle(),
            None => self.hall_angle(),
        }
    }
}
