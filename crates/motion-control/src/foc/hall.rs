//! The rotor's electrical angle and position from three hall sensors (decisions for the TMCM-1640: sectors of 60°, of which
//! the rotor is taken to be in the middle or, interpolated, where the last sector's speed has brought it).
//!
//! Only an edge between two sectors says exactly where the rotor is. Between edges it is guessed, and a guess never leaves
//! the sector that the sensors show.
//!
//! This module must never know how many poles the motor has.

/// Sectors of an electrical turn.
const SECTORS: u8 = 6;

/// The width of a sector, rounded up.
const SECTOR_WIDTH: u32 = 10_923;

/// Without an edge for so long, 500 ms, the rotor may be anywhere in its sector.
const STANDSTILL_TICKS: u32 = 10_000;

/// What the sensors should not do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HallError {
    /// All lines are equal, as in no sector: a broken wire or sensor.
    InvalidPattern,
    /// Two or three sectors in one step: edges were missed.
    SkippedSector,
}

/// The sector that the lines show, H1 in bit 0: 0 to 5 in the order of rotation to the right, the first from 0 to 60°;
/// none if all lines are equal. Some motors' lines are `inverted`. Further bits are ignored.
#[must_use]
pub fn sector(bits: u8, inverted: bool) -> Option<u8> {
    let lines = if inverted { !bits } else { bits };
    match lines & 0b111 {
        0b001 => Some(0),
        0b011 => Some(1),
        0b010 => Some(2),
        0b110 => Some(3),
        0b100 => Some(4),
        0b101 => Some(5),
        _ => None,
    }
}

/// The rotor as the sensors have shown it so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HallTracker {
    /// The last valid sector.
    sector: Option<u8>,
    count: i32,
    error: Option<HallError>,
    /// The direction in which the sector was entered, 1 or -1; 0 as long as there was no edge.
    direction: i32,
    /// The time since the last edge, up to [`STANDSTILL_TICKS`].
    idle_ticks: u32,
    /// The time the sector before took; 0 when it says nothing about the speed: after standstill or a reversal.
    period_ticks: u32,
}

impl HallTracker {
    /// Before the sensors were read for the first time; the position is 0.
    #[must_use]
    pub const fn new() -> Self {
        Self { sector: None, count: 0, error: None, direction: 0, idle_ticks: 0, period_ticks: 0 }
    }

    /// One control period, at whose end the lines are these (see [`sector`]).
    pub fn tick(&mut self, bits: u8, inverted: bool) {
        self.idle_ticks += 1;
        if self.idle_ticks >= STANDSTILL_TICKS {
            self.idle_ticks = STANDSTILL_TICKS;
            self.period_ticks = 0;
        }
        self.error = None;
        let Some(now) = sector(bits, inverted) else {
            self.error = Some(HallError::InvalidPattern);
            return;
        };
        let step = self.sector.map_or(0, |before| self.step(before, now));
        self.sector = Some(now);
        if step != 0 {
            self.enter(step);
        }
    }

    /// The last valid sector, if there was any.
    #[must_use]
    pub fn sector(&self) -> Option<u8> {
        self.sector
    }

    /// The position: sectors passed, up in the order of rotation to the right. It wraps.
    #[must_use]
    pub fn count(&self) -> i32 {
        self.count
    }

    /// What was wrong in the last control period. A skipped sector is an error for that one only, an invalid pattern as
    /// long as it lasts.
    #[must_use]
    pub fn error(&self) -> Option<HallError> {
        self.error
    }

    /// The angle of the edge by which the sector was entered, if it was entered by one in this very control period: then the
    /// rotor is there.
    #[must_use]
    pub fn edge(&self) -> Option<u16> {
        let entered = self.idle_ticks == 0 && self.direction != 0;
        self.sector.filter(|_| entered).map(|sector| self.entry_angle(sector))
    }

    /// The electrical angle of the rotor: the middle of its sector, or interpolated.
    ///
    /// Interpolation begins at the edge the rotor came over and goes on as fast as it crossed the sector before, up to the far
    /// edge. After 500 ms without an edge, or if nothing is known of the speed because there was one edge only or the last one
    /// was crossed backwards, the middle is the best guess (a decision). Before the first valid pattern the angle is 0.
    #[must_use]
    pub fn angle(&self, interpolate: bool) -> u16 {
        let Some(sector) = self.sector else {
            return 0;
        };
        if !interpolate || self.period_ticks == 0 {
            return middle(sector);
        }
        // Both factors are small: at most 10 000 periods of at most a sector.
        let way = (self.idle_ticks * SECTOR_WIDTH / self.period_ticks).min(SECTOR_WIDTH - 1) as u16;
        let entry = self.entry_angle(sector);
        if self.direction < 0 { entry.wrapping_sub(way) } else { entry.wrapping_add(way) }
    }

    /// The sectors between two, the shorter way; of 180° the way the rotor was turning.
    fn step(&self, before: u8, now: u8) -> i32 {
        match (SECTORS + now - before) % SECTORS {
            3 if self.direction < 0 => -3,
            up @ 0..=3 => up.into(),
            up => i32::from(up) - i32::from(SECTORS),
        }
    }

    fn enter(&mut self, step: i32) {
        self.count = self.count.wrapping_add(step);
        let (direction, sectors) = (step.signum(), step.unsigned_abs());
        if sectors > 1 {
            self.error = Some(HallError::SkippedSector);
        }
        let goes_on = direction == self.direction && self.idle_ticks < STANDSTILL_TICKS;
        self.period_ticks = if goes_on { (self.idle_ticks / sectors).max(1) } else { 0 };
        self.direction = direction;
        self.idle_ticks = 0;
    }

    fn entry_angle(&self, sector: u8) -> u16 {
        edge_angle(if self.direction < 0 { sector + 1 } else { sector })
    }
}

/// The angle at which sector `number` begins, to the nearest; that after the last is where the first does.
fn edge_angle(number: u8) -> u16 {
    ((u32::from(number) * 65_536 + 3) / u32::from(SECTORS)) as u16
}

/// 30° into a sector.
fn middle(sector: u8) -> u16 {
    ((u32::from(sector) * 2 + 1) * 65_536 / (2 * u32::from(SECTORS))) as u16
}

#[cfg(test)]
mod tests;
