//! Who may import whom. The table here is the rule; `ARCHITECTURE.md` explains it.

use std::collections::BTreeMap;

use anyhow::{Context, Result, bail};
use cargo_metadata::{DependencyKind, MetadataCommand, Package};

use crate::workspace_root;

/// Each crate of ours and those of ours it may import. An arrow that is not here is an error, and so is a crate.
const ALLOWED: &[(&str, &[&str])] = &[
    ("tmcl-tables", &[]),
    ("motion-control", &[]),
    ("motor-physics", &[]),
    ("driver-chips", &["motor-physics"]),
    ("tmcl-wire", &["tmcl-tables"]),
    ("tmcl-vm", &["tmcl-tables", "tmcl-wire"]),
    ("tmcl-lang", &["tmcl-tables"]),
    ("module-firmware", &["tmcl-tables", "tmcl-wire", "tmcl-vm", "motion-control"]),
    ("module-storage", &["tmcl-tables", "tmcl-vm", "module-firmware"]),
    ("bench-hardware", &["module-firmware", "driver-chips", "motor-physics"]),
    (
        "virtual-bench",
        &["tmcl-tables", "tmcl-wire", "module-firmware", "bench-hardware", "driver-chips", "motor-physics"],
    ),
    ("tmcl-link", &[]),
    ("tmcl-client", &["tmcl-tables", "tmcl-wire", "tmcl-link"]),
    ("tmcl-config", &["tmcl-tables"]),
    ("tmcl-server", &["virtual-bench", "tmcl-link"]),
    (
        "tmcl",
        &[
            "tmcl-tables",
            "tmcl-wire",
            "tmcl-lang",
            "tmcl-link",
            "tmcl-client",
            "tmcl-config",
            "tmcl-server",
            "virtual-bench",
        ],
    ),
    ("emulated-module", &["module-firmware", "virtual-bench", "tmcl-server"]),
    ("xtask", &[]),
];

/// Crates that must build without `std`: `#![no_std]` stands in their root, and nothing they import needs it.
const NO_STD: &[&str] = &[
    "tmcl-tables",
    "motion-control",
    "motor-physics",
    "driver-chips",
    "tmcl-wire",
    "tmcl-vm",
    "module-firmware",
    "module-storage",
    "bench-hardware",
];

/// What the `no_std` crates may import from outside.
const NO_STD_LIBRARIES: &[&str] =
    &["embedded-storage", "embedded-storage-async", "libm", "sequential-storage", "thiserror"];

/// Compares the workspace with the tables above.
pub(crate) fn run() -> Result<()> {
    let metadata = MetadataCommand::new().current_dir(workspace_root()).no_deps().exec()?;
    let allowed: BTreeMap<_, _> = ALLOWED.iter().copied().collect();
    let mut findings = Vec::new();
    for package in metadata.workspace_packages() {
        check_package(package, &allowed, &mut findings)?;
    }
    if findings.is_empty() {
        return Ok(());
    }
    bail!("arrows that point the wrong way (see ARCHITECTURE.md):\n  {}", findings.join("\n  "))
}

fn check_package(
    package: &Package,
    allowed: &BTreeMap<&str, &[&str]>,
    findings: &mut Vec<String>,
) -> Result<()> {
    let name = package.name.as_str();
    let Some(imports) = allowed.get(name) else {
        findings.push(format!("{name} is not in the table of xtask/src/layering.rs"));
        return Ok(());
    };
    let no_std = NO_STD.contains(&name);
    for dependency in package.dependencies.iter().filter(|entry| entry.kind == DependencyKind::Normal) {
        let import = dependency.name.as_str();
        let ours = allowed.contains_key(import);
        if ours && !imports.contains(&import) {
            findings.push(format!("{name} → {import}"));
        }
        if no_std && !ours && !NO_STD_LIBRARIES.contains(&import) {
            findings.push(format!("{name} is no_std and may not import {import}"));
        }
    }
    if no_std {
        let root = package.manifest_path.with_file_name("src").join("lib.rs");
        let text = std::fs::read_to_string(&root).with_context(|| format!("reading {root}"))?;
        if !text.contains("\n#![no_std]\n") {
            findings.push(format!("{name} does not say #![no_std] in {root}"));
        }
    }
    Ok(())
}
