//! Our programs as the chores run them.

use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result, bail};
use cargo_metadata::MetadataCommand;

use crate::workspace_root;

/// How everything of ours is built that CI runs: at full speed, since tests run hours of virtual time, and once.
pub(crate) const PROFILE: &str = "system-tests";

/// Builds `tmcl` and says where it is.
pub(crate) fn built() -> Result<PathBuf> {
    build("tmcl", &["--package", "tmcl"])
}

/// Builds the program that runs a module on an emulated chip, of the whole workspace as the tests do, and says where it is.
pub(crate) fn emulated_module() -> Result<PathBuf> {
    build("emulated-module", &["--workspace", "--bin", "emulated-module"])
}

fn build(name: &str, what: &[&str]) -> Result<PathBuf> {
    let status = Command::new(env!("CARGO"))
        .args(["build", "--profile", PROFILE, "--quiet"])
        .args(what)
        .current_dir(workspace_root())
        .status()
        .context("starting cargo")?;
    if !status.success() {
        bail!("{name} does not build");
    }
    let metadata = MetadataCommand::new().current_dir(workspace_root()).no_deps().exec()?;
    let name = format!("{name}{}", std::env::consts::EXE_SUFFIX);
    Ok(metadata.target_directory.join(PROFILE).join(name).into())
}
