//! `[module.halls]`: the hall sensors in a brushless motor.

use super::quantity;
use super::section::Section;

/// Three hall sensors, a third of an electrical turn apart.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HallsConfig {
    /// Electrical angle, from phase U's axis, at which their first sector begins; -360 to 360°.
    pub offset_deg: f64,
    /// Their lines show the opposite of what is meant, as those of some motors do.
    pub inverted: bool,
}

/// Reads the section.
pub(super) fn read(mut section: Section<'_, '_>) -> HallsConfig {
    let halls = HallsConfig {
        offset_deg: section.number("offset_deg", &quantity::ELECTRICAL_ANGLE).unwrap_or(0.0),
        inverted: section.boolean("inverted").unwrap_or(false),
    };
    section.finish();
    halls
}
