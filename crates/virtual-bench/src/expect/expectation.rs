//! What an expectation is made of.

use super::condition::Condition;
use super::error::ExpectError;
use super::parser;
use crate::bench::Bench;

/// Something that shall be true of a run, such as `actual_position == 10000 within 2s`.
#[derive(Clone, Debug, PartialEq)]
pub struct Expectation {
    pub(super) text: String,
    pub(super) rule: Rule,
    pub(super) condition: Condition,
    pub(super) timing: Timing,
}

/// How often the condition must be met.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rule {
    /// Once.
    Eventually,
    /// All the time.
    Always,
    /// Not once.
    Never,
}

/// When the condition is looked at; times count from when the monitor was made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Timing {
    /// In a stretch of time.
    During(Window),
    /// At an instant.
    At(u64),
    /// When the run ends.
    AtEnd,
}

/// A stretch of time, both ends included.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Window {
    /// Where it begins.
    pub(super) after_ns: u64,
    /// Where it ends; None where it is the whole run.
    pub(super) within_ns: Option<u64>,
    /// How long the condition must be met without a break.
    pub(super) hold_ns: u64,
}

impl Expectation {
    /// Reads an expectation about the quantities of `bench`.
    ///
    /// # Errors
    /// The first thing that is wrong with the text.
    pub fn parse(text: &str, bench: &Bench) -> Result<Self, ExpectError> {
        parser::parse(text, bench)
    }

    /// The text it was read from, but for white space around it.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }
}
