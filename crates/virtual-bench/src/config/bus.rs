//! `[bus]`: how the lines join several modules.

use super::section::Section;

/// What all lines have in common.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BusConfig {
    /// Modules hear each other's replies too, as on two wires or on CAN, and not only the host (decision: they do not).
    pub modules_hear_replies: bool,
    /// The interface that is set in every module that has both (GP 88); `None`: as it was. The file does not say so; who
    /// wires the bench does.
    pub interface: Option<Interface>,
}

/// The two bus interfaces of a module (TMCM-1311 §10.1, GP 88).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interface {
    /// RS485.
    Rs485,
    /// CAN.
    Can,
}

/// Reads the section.
pub(super) fn read(mut section: Section<'_, '_>) -> BusConfig {
    let modules_hear_replies = section.boolean("modules_hear_replies").unwrap_or(false);
    section.finish();
    BusConfig { modules_hear_replies, interface: None }
}
