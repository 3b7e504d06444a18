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
mod direct;
mod exit;
mod module_name;
mod panel;
mod parameters;
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
        Command::Exec(options) => commands::exec::run(&options),
        Command::Shell(options) => commands::shell::run(&options),
        Command::Ports(options) => commands::ports::run(&options),
        Command::Scan(options) => commands::scan::run(&options),
        Command::Info(options) => commands::info::run(&options),
        Command::Download(options) => commands::download::run(&options),
        Command::Upload(options) => commands::upload::run(&options),
        Command::Start(options) => commands::application::start(&options),
        Command::Stop(options) => commands::application::stop(&options),
        Command::Step(options) => commands::application::step(&options),
        Command::Reset(options) => commands::application::reset(&options),
        Command::Status(options) => commands::application::status(&options),
        Command::FactoryReset(options) => commands::factory_reset::run(&options),
        Command::Serve(options) => commands::serve::run(&options),
        Command::State(options) => commands::state::run(&options),
        Command::Modules(options) => commands::modules::run(&options),
        Command::Params(options) => commands::params::run(&options),
        Command::Commands(options) => commands::commands::run(&options),
        Command::Get(options) => commands::get::run(&options),
        Command::Set(options) => commands::set::run(&options),
        Command::Store(options) => commands::store::run(&options),
        Command::Restore(options) => commands::restore::run(&options),
        Command::Watch(options) => commands::watch::run(&options),
        Command::Dump(options) => commands::dump::run(&options),
        Command::Diff(options) => commands::diff::run(&options),
        Command::Apply(options) => commands::apply::run(&options),
        Command::Completions { shell } => commands::completions::run(shell),
        Command::Man { out } => commands::man::run(out.as_deref()),
    };
    exit::finish(outcome)
}
