//! One file per command.

#[expect(clippy::module_inception, reason = "the command is called `commands`")]
pub(crate) mod commands;
pub(crate) mod completions;
pub(crate) mod demo;
pub(crate) mod man;
pub(crate) mod modules;
pub(crate) mod params;
pub(crate) mod serve;
