//! Where what was typed is kept: among the user's state, as the XDG specification has it.

use std::path::{Path, PathBuf};

/// The file; none where the system does not say where the user's files are.
pub(super) fn file() -> Option<PathBuf> {
    let folder = |name: &str| std::env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let state = folder("XDG_STATE_HOME")
        .or_else(|| folder("LOCALAPPDATA"))
        .or_else(|| folder("HOME").map(|home| home.join(".local").join("state")))?;
    Some(state.join("tmcl").join("history"))
}

/// Makes its folder.
pub(super) fn prepare(file: &Path) -> Result<(), String> {
    let folder = file.parent().unwrap_or(Path::new(""));
    std::fs::create_dir_all(folder).map_err(|error| format!("cannot make {}: {error}", folder.display()))
}
