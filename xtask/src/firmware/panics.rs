//! Which code of an image could panic: none of ours.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use anyhow::{Result, bail};

use super::code::Code;
use super::output_with;
use crate::workspace_root;

/// Finds every call of something that panics, by the line of source that it comes from. Those of libraries are told by file;
/// one of ours is an error.
pub(super) fn check(image: &Path, code: &Code) -> Result<()> {
    let mut places = Vec::new();
    for (_, function) in code.functions().filter(|(_, function)| !panics(&function.name)) {
        for (place, target) in &function.calls {
            if panics(&code.around(*target)?.1.name) {
                places.push(format!("{place:#x}"));
            }
        }
    }
    let causes = causes(image, &places)?;
    let root = workspace_root();
    let (ours, theirs): (Vec<_>, Vec<_>) =
        causes.iter().partition(|cause| Path::new(cause).starts_with(&root));
    println!("  {:>7}  checks of the storage's driver that could panic; none of ours", theirs.len());
    for (file, lines) in by_file(&theirs) {
        // The compiler's own have no line.
        let lines: Vec<_> = lines.iter().filter(|line| **line > 0).map(u32::to_string).collect();
        println!("           {file}: lines {}", lines.join(", "));
    }
    if ours.is_empty() {
        return Ok(());
    }
    let ours: Vec<_> = ours.iter().map(|cause| cause.as_str()).collect();
    bail!("this could panic:\n  {}", ours.join("\n  "))
}

/// For each address the line of source that is the cause, `FILE:LINE`.
fn causes(image: &Path, places: &[String]) -> Result<Vec<String>> {
    let lines = output_with("arm-none-eabi-addr2line", |command| {
        command.arg("-e").arg(image).args(["-i", "-a"]).args(places)
    })?;
    // The lines that were inlined there, the innermost first; those of Rust's library are not the cause.
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
    Ok(causes)
}

/// Lines by file, the file from its package on.
fn by_file<'a>(causes: &[&'a String]) -> BTreeMap<&'a str, BTreeSet<u32>> {
    let mut files = BTreeMap::<_, BTreeSet<_>>::new();
    for cause in causes {
        let Some((file, line)) = cause.rsplit_once(':') else { continue };
        // "123 (discriminator 4)"
        let line = line.split(' ').next().and_then(|line| line.parse().ok()).unwrap_or(0);
        let start = file.rfind("/src/").map_or(0, |end| file[..end].rfind('/').map_or(0, |slash| slash + 1));
        files.entry(&file[start..]).or_default().insert(line);
    }
    files
}

fn panics(function: &str) -> bool {
    const PARTS: [&str; 6] = [
        "core::panicking::",
        "unwrap_failed",
        "expect_failed",
        "_index_fail",
        "assert_failed",
        "len_mismatch_fail",
    ];
    PARTS.into_iter().any(|part| function.contains(part))
}
