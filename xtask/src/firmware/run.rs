//! A module on an emulated chip, on ports.

use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result};

use crate::program;

/// Where it listens, and what it remembers.
#[derive(clap::Args)]
pub(crate) struct Ports {
    /// Listen here, `host:port`; port 0 picks a free one [default: 127.0.0.1:5311, unless there is --pty]
    #[arg(long, value_name = "ADDRESS", requires = "run")]
    tcp: Vec<String>,
    /// Open a pseudo terminal and link this path to it
    #[arg(long, value_name = "PATH", requires = "run")]
    pty: Vec<PathBuf>,
    /// The file that is its flash and EEPROM [default: target/firmware/MODULE.psram]
    #[arg(long, value_name = "FILE", requires = "run")]
    memory: Option<PathBuf>,
}

/// Builds the images, and runs one until a signal ends it: the program of `crates/emulated-module` takes over, signals and exit
/// code included.
pub(crate) fn run(module: &str, ports: &Ports) -> Result<()> {
    super::emulator()?;
    super::build_images()?;
    let mut command = Command::new(program::emulated_module()?);
    command.arg(module);
    command.args(ports.tcp.iter().flat_map(|address| ["--tcp", address]));
    for path in &ports.pty {
        command.arg("--pty").arg(path);
    }
    if let Some(file) = &ports.memory {
        command.arg("--memory").arg(file);
    }
    replace(&mut command)
}

#[cfg(unix)]
fn replace(command: &mut Command) -> Result<()> {
    use std::os::unix::process::CommandExt;
    Err(command.exec()).context("starting emulated-module")
}

#[cfg(not(unix))]
fn replace(_: &mut Command) -> Result<()> {
    anyhow::bail!("modules run on emulated chips on Unix only")
}
