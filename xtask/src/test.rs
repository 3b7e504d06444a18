//! `cargo xtask test`: every check in order, each with its time, and a summary at the end.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use anyhow::{Context, Result, anyhow, bail};

use crate::program::{self, PROFILE};
use crate::{codegen, figures, firmware as images, fuzz, layering, workspace_root};

/// A step: its name and what it does.
type Step = (&'static str, fn() -> Result<()>);

const STEPS: &[Step] = &[
    ("format", || cargo(&["fmt", "--all", "--check"])),
    ("layering", layering::run),
    ("clippy", || cargo(&["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"])),
    ("codegen", || codegen::run(codegen::Mode::Check)),
    ("tests", || cargo(&["test", "--profile", PROFILE, "--workspace", "--all-targets"])),
    ("doc tests", || cargo(&["test", "--profile", PROFILE, "--workspace", "--doc"])),
    ("firmware", firmware),
    (REAL_CLIENTS, real_clients),
    ("fuzz", fuzz::run),
    ("documentation", documentation),
    ("figures", || figures::run(codegen::Mode::Check)),
];

/// The step that mostly waits. Those after it run beside it; what it says comes when it ends.
const REAL_CLIENTS: &str = "real clients";

/// Runs the steps whose name contains `only`; stops at nothing, fails if one failed.
pub(crate) fn run(only: Option<&str>) -> Result<()> {
    let steps: Vec<_> =
        STEPS.iter().filter(|(name, _)| only.is_none_or(|part| name.contains(part))).collect();
    if steps.is_empty() {
        let names: Vec<_> = STEPS.iter().map(|(name, _)| *name).collect();
        bail!("no step of that name; there are: {}", names.join(", "));
    }
    let outcomes = std::thread::scope(|scope| {
        let mut outcomes = Vec::new();
        let mut beside = None;
        for step in &steps {
            if step.0 == REAL_CLIENTS {
                eprintln!("\n── {REAL_CLIENTS}: beside those that follow");
                beside = Some((outcomes.len(), scope.spawn(|| outcome(step))));
            } else {
                eprintln!("\n── {}", step.0);
                outcomes.push(outcome(step));
            }
        }
        if let Some((place, thread)) = beside {
            let panicked =
                || Outcome { name: REAL_CLIENTS, seconds: 0.0, error: Some(anyhow!("it panicked")) };
            outcomes.insert(place, thread.join().unwrap_or_else(|_| panicked()));
        }
        outcomes
    });
    let lines: Vec<_> = outcomes.iter().map(Outcome::line).collect();
    println!("\nSummary\n{}\n", lines.join("\n"));
    let failed = outcomes.iter().filter(|outcome| outcome.error.is_some()).count();
    println!("{} passed, {failed} failed", steps.len() - failed);
    if failed > 0 { bail!("{failed} of {} steps failed", steps.len()) } else { Ok(()) }
}

/// How a step ended.
struct Outcome {
    name: &'static str,
    seconds: f64,
    error: Option<anyhow::Error>,
}

impl Outcome {
    /// Its line in the summary.
    fn line(&self) -> String {
        let Self { name, seconds, error } = self;
        match error {
            None => format!("  ok      {name} ({seconds:.1} s)"),
            Some(error) => format!("  FAILED  {name} ({seconds:.1} s): {}", first_line(error)),
        }
    }
}

/// Runs a step, and says what went wrong in it.
fn outcome(&(name, step): &Step) -> Outcome {
    let start = Instant::now();
    let error = step().err();
    if let Some(error) = &error {
        eprintln!("{name}: {error:#}");
    }
    Outcome { name, seconds: start.elapsed().as_secs_f64(), error }
}

fn first_line(error: &anyhow::Error) -> String {
    format!("{error:#}").lines().next().unwrap_or_default().to_owned()
}

fn cargo(arguments: &[&str]) -> Result<()> {
    check(Command::new(env!("CARGO")).args(arguments))
}

fn documentation() -> Result<()> {
    check(
        fuzz::gentle(Path::new(env!("CARGO")))
            .args(["doc", "--workspace", "--no-deps", "--document-private-items"])
            .env("RUSTDOCFLAGS", "-D warnings -A rustdoc::private_intra_doc_links"),
    )
}

/// The images, what they take, and sessions on an emulated chip.
fn firmware() -> Result<()> {
    let folder = workspace_root().join("firmware");
    let run = |arguments: &[&str]| check_in(&folder, Command::new(env!("CARGO")).args(arguments));
    run(&["fmt", "--all", "--check"])?;
    images::emulator()?;
    images::build()?;
    // Of the whole workspace, as the step "tests" builds it: nothing is compiled twice.
    let tests =
        ["--features", "emulated-module/emulator", "--test", "emulated_chips", "--test", "power_cuts"];
    cargo(&["test", "--profile", PROFILE, "--workspace"].into_iter().chain(tests).collect::<Vec<_>>())
}

/// PyTrinamic, unmodified, against `tmcl serve`, in a virtual environment under `target/`.
fn real_clients() -> Result<()> {
    let python = virtual_environment()?;
    check_quietly(
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

fn check(command: &mut Command) -> Result<()> {
    check_in(&workspace_root(), command)
}

/// Like [`check`], for what runs beside other steps: all that the program says is shown at once when it ends.
fn check_quietly(command: &mut Command) -> Result<()> {
    let shown = format!("{command:?}");
    let output =
        command.current_dir(workspace_root()).output().with_context(|| format!("starting {shown}"))?;
    let [text, messages] =
        [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
    eprintln!("\n── {REAL_CLIENTS}\n{text}{messages}");
    if !output.status.success() {
        bail!("{shown} ended with {}", output.status);
    }
    Ok(())
}

fn check_in(folder: &Path, command: &mut Command) -> Result<()> {
    let shown = format!("{command:?}");
    let status = command.current_dir(folder).status().with_context(|| format!("starting {shown}"))?;
    if !status.success() {
        bail!("{shown} ended with {status}");
    }
    Ok(())
}
