//! Reading programs, what they include, and `-`, which is stdin.

use std::ffi::OsStr;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use tmcl_lang::{Resolved, Resolver, SourceFile};

use crate::exit::{Code, Failure};

/// What stands for stdin and stdout.
pub(crate) const STANDARD: &str = "-";

/// What messages call a file.
pub(crate) fn name(file: &Path) -> String {
    if file == Path::new(STANDARD) { "<stdin>".to_owned() } else { file.display().to_string() }
}

/// The bytes of a file, or of stdin.
pub(crate) fn read(file: &Path) -> Result<Vec<u8>, Failure> {
    let bytes = if file == Path::new(STANDARD) {
        let mut bytes = Vec::new();
        io::stdin().lock().read_to_end(&mut bytes).map(|_| bytes)
    } else {
        std::fs::read(file)
    };
    bytes.map_err(|error| Failure::new(Code::Usage, format!("cannot read {}: {error}", name(file))))
}

/// A program's file, as the assembler takes it.
pub(crate) fn root(file: &Path) -> Result<SourceFile, Failure> {
    Ok(SourceFile { name: name(file), bytes: read(file)?, builtin: false })
}

/// Writes a file, or to stdout.
pub(crate) fn write(file: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let written = if file == Path::new(STANDARD) {
        let mut out = io::stdout().lock();
        io::Write::write_all(&mut out, bytes).and_then(|()| io::Write::flush(&mut out))
    } else {
        std::fs::write(file, bytes)
    };
    written.map_err(|error| Failure::new(Code::Usage, format!("cannot write {}: {error}", file.display())))
}

/// Finds an included file beside the one that includes it. Where the file system tells letters apart and there is no file of
/// that very name, one that differs in case does, and so do folders: the programs come from systems that do not.
pub(crate) struct BesideIncluder;

impl Resolver for BesideIncluder {
    fn resolve(&mut self, includer: &str, name: &str) -> Result<Option<Resolved>, String> {
        let folder = Path::new(includer).parent().unwrap_or(Path::new(""));
        let path = folder.join(name.replace('\\', "/"));
        let path = if path.is_file() { Some(path) } else { in_other_case(&path) };
        let Some(path) = path else { return Ok(None) };
        let bytes = std::fs::read(&path).map_err(|error| error.to_string())?;
        Ok(Some(Resolved { name: tidy(&path).display().to_string(), bytes }))
    }
}

fn in_other_case(path: &Path) -> Option<PathBuf> {
    let mut found = PathBuf::new();
    for component in path.components() {
        let exact = found.join(component);
        found = if exact.exists() { exact } else { sibling_in_other_case(&found, component.as_os_str())? };
    }
    found.is_file().then_some(found)
}

fn sibling_in_other_case(folder: &Path, name: &OsStr) -> Option<PathBuf> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let mut entries = std::fs::read_dir(folder).ok()?.flatten();
    entries.find(|entry| entry.file_name().eq_ignore_ascii_case(name)).map(|entry| entry.path())
}

/// Without `.` and `a/..`, so that a file has one name.
fn tidy(path: &Path) -> PathBuf {
    use std::path::Component;
    let mut tidied = PathBuf::new();
    for component in path.components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir if matches!(tidied.components().next_back(), Some(Component::Normal(_))) => {
                tidied.pop();
            }
            other => tidied.push(other),
        }
    }
    tidied
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_has_one_name() {
        assert_eq!(tidy(Path::new("./a/../b/./c.inc")), Path::new("b/c.inc"));
        assert_eq!(tidy(Path::new("../a.inc")), Path::new("../a.inc"));
    }
}
