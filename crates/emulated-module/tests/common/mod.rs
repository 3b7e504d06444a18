//! What the tests of sessions share.
#![allow(clippy::disallowed_methods, clippy::unwrap_used, reason = "tests that read files")]
#![allow(dead_code, reason = "each test uses some of it")]

use std::fs;
use std::path::{Path, PathBuf};

use emulated_module::Session;

pub(crate) fn folder() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Every session of a module: its name, its file and its text.
pub(crate) fn sessions(module: &str) -> Vec<(String, PathBuf, Session)> {
    let mut sessions: Vec<_> = fs::read_dir(folder().join("sessions").join(module))
        .unwrap()
        .map(|entry| {
            let path = entry.unwrap().path();
            let name = path.file_stem().unwrap().to_string_lossy().into_owned();
            let session = Session::parse(&fs::read_to_string(&path).unwrap())
                .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
            (name, path, session)
        })
        .collect();
    sessions.sort_by(|one, other| one.0.cmp(&other.0));
    assert!(!sessions.is_empty());
    sessions
}

/// The image with physics of a module.
pub(crate) fn image(module: &str) -> PathBuf {
    let folder = folder().join("../../firmware/target/thumbv7m-none-eabi/release");
    let image = folder.join(format!("{module}-bench"));
    assert!(image.exists(), "{} is missing: `cargo xtask firmware` builds it", image.display());
    image
}

/// A new chip's memory.
pub(crate) fn memory(name: &str) -> PathBuf {
    let memory = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.psram"));
    let _ = fs::remove_file(&memory);
    memory
}
