//! `cargo xtask test`: every check in order, each with its time, and a summary at the end.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use anyhow::{Context, Result, bail};

use crate::program::{self, PROFILE};
use crate::{codegen, figures, firmware as images, layering, workspace_root};

/// A step: its name and what it does.
type Step = (&'static str, fn() -> Result<()>);

const STEPS: &[Step] = &[
    ("format", || cargo(&["fmt", "--all", "--check"])),
    ("layering", layering::run),
    ("clippy", || cargo(&["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"])),
    ("codegen", || codegen::run(codegen::Mode::Check)),
    ("tests", || cargo(&["test", "--profile", PROFILE, "--workspace", "--all-targets"])),
    ("doc tests", || cargo(&["test", "--profile", PROFILE, "--workspace", "--doc"])),
    ("documentation", documentation),
    ("firmware", firmware),
    ("figures", || figures::run(codegen::Mode::Check)),
    ("real clients", real_clients),
    ("fuzz", fuzz),
];

/// Runs the steps whose name contains `only`; stops at nothing, fails if one failed.
pub(crate) fn run(only: Option<&str>) -> Result<()> {
    let steps: Vec<_> =
        STEPS.iter().filter(|(name, _)| only.is_none_or(|part| name.contains(part))).collect();
    if steps.is_empty() {
        let names: Vec<_> = STEPS.iter().map(|(name, _)| *name).collect();
        bail!("no step of that name; there are: {}", names.join(", "));
    }
    let mut lines = Vec::new();
    let mut failed = 0;
    for (name, step) in &steps {
        eprintln!("\n── {name}");
        let start = Instant::now();
        let outcome = step();
        let seconds = start.elapsed().as_secs_f64();
        match outcome {
            Ok(()) => lines.push(format!("  ok      {name} ({seconds:.1} s)")),
            Err(error) => {
                failed += 1;
                eprintln!("{name}: {error:#}");
                lines.push(format!("  FAILED  {name} ({seconds:.1} s): {}", first_line(&error)));
            }
        }
    }
    println!("\nSummary\n{}\n", lines.join("\n"));
    println!("{} passed, {failed} failed", steps.len() - failed);
    if failed > 0 { bail!("{failed} of {} steps failed", steps.len()) } else { Ok(()) }
}

fn first_line(error: &anyhow::Error) -> String {
    format!("{error:#}").lines().next().unwrap_or_default().to_owned()
}

fn cargo(arguments: &[&str]) -> Result<()> {
    check(Command::new(env!("CARGO")).args(arguments))
}

fn documentation() -> Result<()> {
    check(
        Command::new(env!("CARGO"))
            .args(["doc", "--workspace", "--no-deps", "--document-private-items"])
            .env("RUSTDOCFLAGS", "-D warnings -A rustdoc::private_intra_doc_links"),
    )
}

/// The images, what they take, their storage, and sessions on an emulated chip.
fn firmware() -> Result<()> {
    let folder = workspace_root().join("firmware");
    let run = |arguments: &[&str]| check_in(&folder, Command::new(env!("CARGO")).args(arguments));
    run(&["fmt", "--all", "--check"])?;
    images::emulator()?;
    images::build()?;
    run(&["test", "--package", "module-storage"])?;
    // Of the whole workspace, as the step "tests" builds it: nothing is compiled twice.
    let tests =
        ["--features", "emulated-module/emulator", "--test", "emulated_chips", "--test", "power_cuts"];
    cargo(&["test", "--profile", PROFILE, "--workspace"].into_iter().chain(tests).collect::<Vec<_>>())
}

/// PyTrinamic, unmodified, against `tmcl serve`, in a virtual environment under `target/`.
fn real_clients() -> Result<()> {
    let python = virtual_environment()?;
    check(
        Command::new(python)
            .args(["-m", "pytest", "-q", "-p", "no:cacheprovider", "tests/clients"])
            .env("TMCL", program::built()?)
            .env("EMULATED_MODULE", program::emulated_module()?)
            .env("PYTHONDONTWRITEBYTECODE", "1"),
    )
}

fn virtual_environment() -> Result<PathBuf> {
    let folder = workspace_root().join("target/venv");
    let python = folder.join("bin/python");
    let requirements = "tests/clients/requirements.txt";
    if !python.exists() {
        eprintln!("creating a Python environment in {}", folder.display());
        let made = check(Command::new("python3").args(["-m", "venv", "--clear"]).arg(&folder));
        made.context("python3 with venv is missing: `apt-get install python3-venv` (Debian, Ubuntu), `brew install python` (macOS)")?;
    }
    eprintln!("installing {requirements} into {}", folder.display());
    let install =
        ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--requirement", requirements];
    check(Command::new(&python).args(install)).context("pip needs to reach a Python package index")?;
    Ok(python)
}

/// What parses bytes or text from outside.
const FUZZ_TARGETS: [&str; 11] = [
    "serial_decoder",
    "firmware_bytes",
    "ascii",
    "program",
    "bench_file",
    "config_file",
    "eeprom_image",
    "expectation",
    "client_replies",
    "slcan",
    "assembler",
];

/// Each fuzz target for a few seconds, from an empty corpus: a smoke run, not a campaign.
fn fuzz() -> Result<()> {
    let tools = workspace_root().join("target/tools");
    let cargo_fuzz = tools.join("bin/cargo-fuzz");
    if !cargo_fuzz.exists() {
        eprintln!("installing cargo-fuzz into {}", tools.display());
        let install = ["install", "--quiet", "--locked", "cargo-fuzz", "--root"];
        check(Command::new(env!("CARGO")).args(install).arg(&tools))
            .context("cargo needs to reach crates.io")?;
    }
    for target in FUZZ_TARGETS {
        check(
            Command::new(&cargo_fuzz)
                .args(["run", target, "--", "-max_total_time=5", "-verbosity=0"])
                .env("RUSTC_BOOTSTRAP", "1"),
        )
        .context("a C++ compiler is needed to link libFuzzer: `apt-get install g++`")?;
    }
    Ok(())
}

fn check(command: &mut Command) -> Result<()> {
    check_in(&workspace_root(), command)
}

fn check_in(folder: &Path, command: &mut Command) -> Result<()> {
    let shown = format!("{command:?}");
    let status = command.current_dir(folder).status().with_context(|| format!("starting {shown}"))?;
    if !status.success() {
        bail!("{shown} ended with {status}");
    }
    Ok(())
}
