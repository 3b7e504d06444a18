//! One file per command.

pub(crate) mod application;
pub(crate) mod apply;
pub(crate) mod asm;
pub(crate) mod check;
#[expect(clippy::module_inception, reason = "the command is called `commands`")]
pub(crate) mod commands;
pub(crate) mod completions;
pub(crate) mod demo;
pub(crate) mod diff;
pub(crate) mod disasm;
pub(crate) mod download;
pub(crate) mod dump;
pub(crate) mod exec;
pub(crate) mod explain;
pub(crate) mod factory_reset;
pub(crate) mod fmt;
pub(crate) mod get;
pub(crate) mod info;
pub(crate) mod man;
pub(crate) mod modules;
pub(crate) mod params;
pub(crate) mod ports;
pub(crate) mod restore;
pub(crate) mod run;
pub(crate) mod scan;
pub(crate) mod serve;
pub(crate) mod set;
pub(crate) mod shell;
pub(crate) mod state;
pub(crate) mod store;
pub(crate) mod upload;
pub(crate) mod watch;
