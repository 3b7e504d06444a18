//! `cargo xtask firmware`: the images of `firmware/mps2-an385`, what they take, and a module on an emulated chip.
//!
//! Rust's core library for the processor comes from rustup's target where it is installed; else Debian's compiler and its
//! sources build it.

mod code;
mod panics;
mod run;
mod stack;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail};

use crate::workspace_root;
use code::Code;
pub(crate) use run::{Ports, run};

const TARGET: &str = "thumbv7m-none-eabi";
const QEMU: &str = "qemu-system-arm";
const MISSING_QEMU: &str = "qemu-system-arm is missing: `apt-get install qemu-system-arm` (Debian, Ubuntu), `brew install qemu` (macOS)";

/// Debian's compiler, and the sources that come beside it.
const DEBIAN_RUSTC: &str = "/usr/bin/rustc";
const DEBIAN_SOURCES: &str = "/usr/lib/rustlib/src/rust/library/core";

/// The modules that images are built for.
pub(crate) const MODULES: [&str; 2] = ["tmcm-1311", "tmcm-1640"];

/// What an image without physics may take (an aim of ours): flash, and RAM with the stack.
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
    let code = Code::of(&image)?;
    let depth = stack::depth(&code)?;
    let all = ram + depth.bytes;
    println!(
        "{module}: {flash} bytes of flash; {all} bytes of RAM, {ram} and at most {} of stack",
        depth.bytes
    );
    for (name, bytes) in by_crate(&output("arm-none-eabi-nm", &["--print-size", "--demangle"], &image)?) {
        println!("  {bytes:>7}  {name}");
    }
    panics::check(&image, &code)?;
    let with_physics = stack::depth(&Code::of(&self::image(&format!("{module}-bench")))?)?;
    println!("  {:>7}  bytes of stack at most with physics", with_physics.bytes);
    println!("           the deepest chain of calls:");
    for (function, frame) in depth.chain.iter().filter(|(_, frame)| *frame > 0) {
        println!("  {frame:>7}  {}", without_parameters(function));
    }
    if flash > FLASH_BUDGET || all > RAM_BUDGET {
        bail!("{module} takes more than {FLASH_BUDGET} bytes of flash or {RAM_BUDGET} bytes of RAM");
    }
    Ok(())
}

/// A path without what is between `::<` and its `>`, which is long and says little.
fn without_parameters(path: &str) -> String {
    let mut short = String::new();
    let mut depth = 0_usize;
    let mut rest = path;
    while let Some(letter) = rest.chars().next() {
        match letter {
            '<' if depth > 0 || short.ends_with(|last: char| last.is_alphanumeric() || last == ':') => {
                depth += 1;
            }
            '>' if depth > 0 => depth -= 1,
            _ if depth == 0 => short.push(letter),
            _ => {}
        }
        rest = &rest[letter.len_utf8()..];
    }
    short.trim_end_matches(':').to_owned()
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
