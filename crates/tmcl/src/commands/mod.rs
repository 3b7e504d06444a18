//! One file per command.

pub(crate) mod asm;
pub(crate) mod check;
#[expect(clippy::module_inception, reason = "the command is called `commands`")]
pub(crate) mod commands;
pub(crate) mod completions;
pub(crate) mod demo;
pub(crate) mod disasm;
pub(crate) mod explain;
pub(crate) mod fmt;
pub(crate) mod man;
pub(crate) mod modules;
pub(crate) mod params;
pub(crate) mod run;
pub(crate) mod serve;
pub(crate) mod state;
