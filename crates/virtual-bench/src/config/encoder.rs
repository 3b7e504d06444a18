//! `[module.encoder]`: the incremental encoder on the shaft.

use motor_physics::presets::QBL4208_ENCODER_COUNTS;

use super::quantity;
use super::section::Section;
use crate::ModuleKind;

/// An incremental encoder.
#[derive(Clone, Debug, PartialEq)]
pub struct EncoderConfig {
    /// Quadrature counts of a turn, four times its lines; 4 to 1 000 000.
    pub counts: u32,
    /// Where the shaft stands at the index pulse.
    pub offset_turns: f64,
    /// It counts down when the shaft turns to the right.
    pub inverted: bool,
    /// It has an index (N) channel, a pulse a turn.
    pub index: bool,
}

impl EncoderConfig {
    /// The encoder of a module of this kind unless the file says otherwise: 40 000 counts (TMCM-1311 §8.11.1), or those of
    /// the default brushless motor's; they count up to the right; that it has an index is chosen.
    #[must_use]
    pub const fn default_for(kind: ModuleKind) -> Self {
        let counts = match kind {
            ModuleKind::Tmcm1311 | ModuleKind::Tmcm1076 => 40_000,
            ModuleKind::Tmcm1640 => QBL4208_ENCODER_COUNTS,
        };
        Self { counts, offset_turns: 0.0, inverted: false, index: true }
    }
}

/// Reads the section.
pub(super) fn read(mut section: Section<'_, '_>, kind: ModuleKind) -> EncoderConfig {
    let default = EncoderConfig::default_for(kind);
    let counts = section.integer("counts", &(4..=1_000_000)).and_then(|counts| u32::try_from(counts).ok());
    let encoder = EncoderConfig {
        counts: counts.unwrap_or(default.counts),
        offset_turns: section.number("offset_turns", &quantity::TURNS).unwrap_or(default.offset_turns),
        inverted: section.boolean("inverted").unwrap_or(default.inverted),
        index: section.boolean("index").unwrap_or(default.index),
    };
    section.finish();
    encoder
}
