//! The step "fuzz": each target of `fuzz/` for a few seconds, from an empty corpus: a smoke run, not a campaign.
//!
//! The targets are built all at once with the flags that `cargo fuzz` gives (version 0.13), which is not needed for this;
//! for a campaign, and to look at what was found, there is `cargo fuzz run TARGET`.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::atomic::{AtomicUsize, Ordering};

use anyhow::{Context, Result, anyhow, bail};
use cargo_metadata::MetadataCommand;

use crate::workspace_root;

/// The profile in `fuzz/Cargo.toml`.
const PROFILE: &str = "smoke";

/// How long each target runs.
const TIME: &str = "-max_total_time=5";

/// The sanitizer's instrumentation that libFuzzer is guided by, and the sanitizer that finds misuse of memory.
const FLAGS: &[&str] = &[
    "-Cpasses=sancov-module",
    "-Cllvm-args=-sanitizer-coverage-level=4",
    "-Cllvm-args=-sanitizer-coverage-inline-8bit-counters",
    "-Cllvm-args=-sanitizer-coverage-pc-table",
    "-Cllvm-args=-sanitizer-coverage-trace-compares",
    "-Cllvm-args=-simplifycfg-branch-fold-threshold=0",
    "-Zsanitizer=address",
    "--cfg=fuzzing",
];

/// Builds the targets and runs them, as many at a time as there are processors.
pub(crate) fn run() -> Result<()> {
    let (targets, programs) = build()?;
    let workers = std::thread::available_parallelism().map_or(1, usize::from);
    let next = AtomicUsize::new(0);
    let work = || {
        let waiting = std::iter::from_fn(|| targets.get(next.fetch_add(1, Ordering::Relaxed)));
        waiting.filter_map(|target| smoke(target, &programs).err()).collect::<Vec<_>>()
    };
    let failed = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..workers).map(|_| scope.spawn(work)).collect();
        let panicked = |_| vec![anyhow!("a thread that runs fuzz targets panicked")];
        threads.into_iter().flat_map(|thread| thread.join().unwrap_or_else(panicked)).collect::<Vec<_>>()
    });
    if failed.is_empty() {
        return Ok(());
    }
    let failed: Vec<_> = failed.iter().map(|error| format!("{error:#}")).collect();
    bail!("{}", failed.join("; "))
}

/// The names of all targets, and the folder where their programs are now.
fn build() -> Result<(Vec<String>, PathBuf)> {
    let folder = workspace_root().join("fuzz");
    let host = host()?;
    let mut flags = FLAGS.join(" ");
    if host.contains("-linux-") {
        flags.push_str(" -Cllvm-args=-sanitizer-coverage-stack-depth");
    }
    // With a target named, the flags are not for build scripts.
    let mut command = gentle(Path::new(env!("CARGO")));
    command.args(["build", "--quiet", "--bins", "--profile", PROFILE, "--target", &host]);
    command.current_dir(&folder).env("RUSTC_BOOTSTRAP", "1").env("RUSTFLAGS", flags);
    let status = command.status().context("starting cargo")?;
    if !status.success() {
        bail!(
            "the fuzz targets do not build; libFuzzer needs a C++ compiler: `apt-get install g++` (Debian, Ubuntu)"
        );
    }
    let metadata = MetadataCommand::new().current_dir(&folder).no_deps().exec()?;
    let targets = metadata.packages.iter().flat_map(|package| &package.targets);
    let names = targets.filter(|target| target.is_bin()).map(|target| target.name.clone()).collect();
    Ok((names, metadata.target_directory.join(host).join(PROFILE).into()))
}

/// The triple of this machine, as the compiler knows it.
fn host() -> Result<String> {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let output = Command::new(rustc).arg("-vV").output().context("starting rustc")?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let host = text.lines().find_map(|line| line.strip_prefix("host: "));
    host.map(str::to_owned).context("rustc -vV does not name a host")
}

/// Runs one target. What it says is shown if it finds something.
fn smoke(target: &str, programs: &Path) -> Result<()> {
    let artifacts = workspace_root().join("fuzz/artifacts").join(target);
    std::fs::create_dir_all(&artifacts).with_context(|| format!("making {}", artifacts.display()))?;
    let output = gentle(&programs.join(target))
        .args([TIME, "-verbosity=0", &format!("-artifact_prefix={}/", artifacts.display())])
        .env("ASAN_OPTIONS", "detect_odr_violation=0")
        .current_dir(workspace_root().join("fuzz"))
        .output()
        .with_context(|| format!("starting fuzz target {target}"))?;
    if output.status.success() {
        eprintln!("fuzz target {target}: nothing found");
        return Ok(());
    }
    let Output { status, stderr, .. } = output;
    let text = String::from_utf8_lossy(&stderr);
    eprintln!("fuzz target {target}:\n{text}");
    let input = text.lines().find_map(|line| line.split_once("Test unit written to ")).map(|(_, path)| path);
    match input {
        Some(path) => {
            bail!("{target} found something: see `cargo fuzz run {target} {path}`")
        }
        None => bail!("{target} ended with {status}"),
    }
}

/// A program that lets others go first, where there is `nice`: other steps wait for replies meanwhile.
pub(crate) fn gentle(program: &Path) -> Command {
    if Command::new("nice").arg("true").output().is_ok_and(|output| output.status.success()) {
        let mut command = Command::new("nice");
        command.args(["-n", "19"]).arg(program);
        command
    } else {
        Command::new(program)
    }
}
