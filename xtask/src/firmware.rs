//! `cargo xtask firmware`: the images of `firmware/mps2-an385`, what they take, and a module on an emulated chip.
//!
//! Rust's core library for the processor comes from rustup's target where it is installed; else Debian's compiler and its
//! sources build it.

mod run;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail};

use crate::workspace_root;

pub(crate) use run::{Ports, run};

const TARGET: &str = "thumbv7m-none-eabi";
const QEMU: &str = "qemu-system-arm";
const MISSING_QEMU: &str = "qemu-system-arm is missing: `apt-get install qemu-system-arm` (Debian, Ubuntu), `brew install qemu` (macOS)";

/// Debian's compiler, and the sources that come beside it.
const DEBIAN_RUSTC: &str = "/usr/bin/rustc";
const DEBIAN_SOURCES: &str = "/usr/lib/rustlib/src/rust/library/core";

/// The modules that images are built for.
pub(crate) const MODULES: [&str; 2] = ["tmcm-1311", "tmcm-1640"];

/// What an image without physics may take (an aim of ours): flash, and RAM without the stack.
const FLASH_BUDGET: u64 = 128 * 1024;
const RAM_BUDGET: u64 = 20 * 1024;

/// Builds every image, and reports what it takes.
pub(crate) fn build() -> Result<()> {
    build_images()?;
    for module in MODULES {
        report(module)?;
    }
    Ok(())
}

fn build_images() -> Result<()> {
    let mut command = Command::new("cargo");
    command
        .current_dir(workspace_root().join("firmware"))
        .args(["build", "--release", "--package", "mps2-an385", "--target", TARGET])
        .env_remove("RUSTUP_TOOLCHAIN")
        .env_remove("CARGO");
    match toolchain()? {
        Toolchain::Rustup => {
            command.env("RUSTFLAGS", "-C link-arg=-Tlink.x -C link-arg=--nmagic");
        }
        Toolchain::Debian => {
            let flags = "-C linker=arm-none-eabi-ld -C link-arg=-Tlink.x -C link-arg=--nmagic";
            command.arg("-Zbuild-std=core").env("RUSTC_BOOTSTRAP", "1").env("RUSTC", DEBIAN_RUSTC);
            command.env("RUSTFLAGS", flags);
        }
    }
    let status = command.status().context("starting cargo")?;
    if !status.success() {
        bail!("the images do not build: cargo ended with {status}");
    }
    Ok(())
}

/// Which compiler builds for the processor.
enum Toolchain {
    Rustup,
    Debian,
}

fn toolchain() -> Result<Toolchain> {
    let installed = Command::new("rustup").args(["target", "list", "--installed"]).output();
    if installed.is_ok_and(|output| String::from_utf8_lossy(&output.stdout).contains(TARGET)) {
        return Ok(Toolchain::Rustup);
    }
    let works = |program: &str| Command::new(program).arg("--version").output().is_ok();
    let mut missing = Vec::new();
    if !works(DEBIAN_RUSTC) {
        missing.push("rustc-web");
    }
    if !Path::new(DEBIAN_SOURCES).exists() {
        missing.push("rust-web-src");
    }
    if !works("arm-none-eabi-ld") {
        missing.push("binutils-arm-none-eabi");
    }
    if missing.is_empty() {
        return Ok(Toolchain::Debian);
    }
    bail!(
        "no compiler for {TARGET}: `rustup target add {TARGET}`, or on Debian `apt-get install {}`",
        missing.join(" ")
    )
}

/// Says what is missing where there is no emulator.
pub(crate) fn emulator() -> Result<()> {
    let version = Command::new(QEMU).arg("--version").stdout(Stdio::null()).status();
    version.map(drop).context(MISSING_QEMU)
}

fn image(name: &str) -> PathBuf {
    workspace_root().join("firmware/target").join(TARGET).join("release").join(name)
}

/// Flash and RAM of a module's image without physics, and who takes the flash.
fn report(module: &str) -> Result<()> {
    let image = image(module);
    let sections = output("arm-none-eabi-size", &["-A"], &image)?;
    let size = |names: &[&str]| -> u64 {
        let fields = sections.lines().map(|line| line.split_whitespace().collect::<Vec<_>>());
        fields
            .filter(|fields| names.contains(fields.first().unwrap_or(&"")))
            .filter_map(|fields| fields.get(1)?.parse::<u64>().ok())
            .sum()
    };
    let flash = size(&[".vector_table", ".text", ".rodata", ".data"]);
    let ram = size(&[".data", ".bss", ".uninit"]);
    println!("{module}: {flash} bytes of flash, {ram} bytes of RAM beside the stack");
    for (name, bytes) in by_crate(&output("arm-none-eabi-nm", &["--print-size", "--demangle"], &image)?) {
        println!("  {bytes:>7}  {name}");
    }
    check_panics(&image)?;
    if flash > FLASH_BUDGET || ram > RAM_BUDGET {
        bail!("{module} takes more than {FLASH_BUDGET} bytes of flash or {RAM_BUDGET} bytes of RAM");
    }
    Ok(())
}

/// Every call of something that panics, by the line of source that it comes from: none may be ours. The checks of the storage's
/// driver are counted.
fn check_panics(image: &Path) -> Result<()> {
    let code = output("arm-none-eabi-objdump", &["--disassemble", "--demangle"], image)?;
    let mut places = Vec::new();
    let mut function = "";
    for line in code.lines() {
        if let Some((_, name)) = line.strip_suffix(">:").and_then(|line| line.split_once(" <")) {
            function = name;
        } else if let Some((address, rest)) = line.trim_start().split_once(":\t")
            && let Some((_, callee)) = rest.strip_suffix('>').and_then(|rest| rest.split_once(" <"))
            && panics(callee)
            && !panics(function)
        {
            places.push(format!("0x{address}"));
        }
    }
    let arguments: Vec<_> = ["-i", "-a"].into_iter().chain(places.iter().map(String::as_str)).collect();
    let lines =
        output_with("arm-none-eabi-addr2line", |command| command.arg("-e").arg(image).args(&arguments))?;
    // For each address the lines that were inlined there, the innermost first; those of Rust's library are not the cause.
    let mut causes = Vec::new();
    let mut waits = false;
    for line in lines.lines() {
        if line.starts_with("0x") {
            waits = true;
        } else if waits && !line.contains("/library/") && !line.contains("rustlib") {
            causes.push(line.to_owned());
            waits = false;
        }
    }
    let root = workspace_root();
    let ours: Vec<_> = causes.iter().filter(|line| Path::new(line).starts_with(&root)).cloned().collect();
    println!(
        "  {:>7}  checks of the storage's driver that could panic; none of ours",
        causes.len() - ours.len()
    );
    if ours.is_empty() { Ok(()) } else { bail!("this could panic:\n  {}", ours.join("\n  ")) }
}

fn panics(function: &str) -> bool {
    [
        "core::panicking::",
        "unwrap_failed",
        "expect_failed",
        "_index_fail",
        "assert_failed",
        "len_mismatch_fail",
    ]
    .into_iter()
    .any(|name| function.contains(name))
}

/// The flash that the symbols of each crate take, the largest first. What is inlined counts where it ends up.
fn by_crate(symbols: &str) -> Vec<(String, u64)> {
    let mut crates = BTreeMap::<String, u64>::new();
    for line in symbols.lines() {
        let fields: Vec<_> = line.splitn(4, ' ').collect();
        let [_, size, kind, name] = fields.as_slice() else { continue };
        let Ok(size) = u64::from_str_radix(size, 16) else { continue };
        if "tTrR".contains(kind) {
            let path = name.trim_start_matches(['<', '&', '(']);
            let name = path
                .split("::")
                .next()
                .filter(|_| path.contains("::"))
                .unwrap_or("others: constants, tables of switches, start-up");
            *crates.entry(name.to_owned()).or_default() += size;
        }
    }
    let mut crates: Vec<_> = crates.into_iter().collect();
    crates.sort_by_key(|(_, bytes)| std::cmp::Reverse(*bytes));
    crates
}

fn output(program: &str, arguments: &[&str], image: &Path) -> Result<String> {
    output_with(program, |command| command.args(arguments).arg(image))
}

fn output_with(program: &str, with: impl FnOnce(&mut Command) -> &mut Command) -> Result<String> {
    let output = with(&mut Command::new(program)).output();
    let output = output.with_context(|| {
        format!("{program} is missing: `apt-get install binutils-arm-none-eabi` (Debian, Ubuntu)")
    })?;
    if !output.status.success() {
        bail!("{program}: {}", String::from_utf8_lossy(&output.stderr));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}
