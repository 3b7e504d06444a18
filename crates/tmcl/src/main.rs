//! `tmcl`, the command line of OpenTMCL.
//!
//! stdout is data, stderr is messages. Exit codes stand in [`exit::Code`].
#![allow(
    clippy::disallowed_methods,
    clippy::disallowed_types,
    reason = "an edge: arguments, files and signals are its business"
)]

mod arguments;
mod bench_file;
mod commands;
mod connection;
mod exit;
mod module_name;
mod panel;
mod plot;
mod print;
mod program;
mod recording;
mod state;
mod virtual_link;

use std::process::ExitCode;

use clap::Parser;

use crate::arguments::{Arguments, Command};

fn main() -> ExitCode {
    let outcome = match Arguments::parse().command {
        Command::Asm(options) => commands::asm::run(&options),
        Command::Disasm(options) => commands::disasm::run(&options),
        Command::Fmt(options) => commands::fmt::run(&options),
        Command::Run(options) => commands::run::run(&options),
        Command::Check(options) => commands::check::run(&options),
        Command::Explain(options) => commands::explain::run(&options),
        Command::Demo(options) => commands::demo::run(&options),
        Command::Serve(options) => commands::serve::run(&options),
        Command::State(options) => commands::state::run(&options),
        Command::Modules(options) => commands::modules::run(&options),
        Command::Params(options) => commands::params::run(&options),
        Command::Commands(options) => commands::commands::run(&options),
        Command::Completions { shell } => commands::completions::run(shell),
        Command::Man { out } => commands::man::run(out.as_deref()),
    };
    exit::finish(outcome)
}
