//! The project's own chores. `cargo xtask test` is the test command: what it passes, CI passes.
#![allow(clippy::disallowed_methods, reason = "an edge: it runs programs and reads and writes files")]

mod codegen;
mod figures;
mod firmware;
mod fuzz;
mod layering;
mod program;
mod test;

use std::path::PathBuf;

use clap::{Parser, Subcommand};

#[derive(Parser)]
#[command(name = "cargo xtask", about = "The project's own chores")]
struct Arguments {
    #[command(subcommand)]
    chore: Chore,
}

#[derive(Subcommand)]
enum Chore {
    /// Run everything that CI runs: format, lints, generated files, figures, layers, tests, real clients, fuzz smoke runs
    Test {
        /// Only the steps whose name contains this
        #[arg(long)]
        only: Option<String>,
    },
    /// Generate the Rust tables and the reference pages from data/
    Codegen {
        /// Fail where a generated file is not what data/ says, and write nothing
        #[arg(long)]
        check: bool,
    },
    /// Draw the figures of the documentation by examples/figures/figures.toml
    Figures {
        /// Fail where a figure is not what its run draws, and write nothing
        #[arg(long)]
        check: bool,
    },
    /// Build the modules' images for a Cortex-M3, and report what they take
    Firmware {
        /// Run one on an emulated chip: the physics of the default bench around it, its port at TCP and pseudo terminals
        #[arg(long)]
        run: bool,
        /// Which module runs
        #[arg(long, default_value = "tmcm-1311", value_parser = firmware::MODULES)]
        module: String,
        #[command(flatten)]
        ports: firmware::Ports,
    },
    /// Check that crates import only what ARCHITECTURE.md lets them
    Layering,
}

fn main() -> std::process::ExitCode {
    let outcome = match Arguments::parse().chore {
        Chore::Test { only } => test::run(only.as_deref()),
        Chore::Codegen { check } => codegen::run(mode(check)),
        Chore::Figures { check } => figures::run(mode(check)),
        Chore::Firmware { run: false, .. } => firmware::build(),
        Chore::Firmware { run: true, module, ports } => firmware::run(&module, &ports),
        Chore::Layering => layering::run(),
    };
    match outcome {
        Ok(()) => std::process::ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            std::process::ExitCode::FAILURE
        }
    }
}

fn mode(check: bool) -> codegen::Mode {
    if check { codegen::Mode::Check } else { codegen::Mode::Write }
}

/// The folder of the workspace's `Cargo.toml`.
fn workspace_root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).parent().expect("xtask lies in the workspace").to_owned()
}
