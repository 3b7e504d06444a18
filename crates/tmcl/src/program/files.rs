//! Reading programs, what they include, and `-`, which is stdin.

use std::io::{self, Read};
use std::path::{Path, PathBuf};

use tmcl_lang::{Resolved, Resolver, SourceFile};

use crate::exit::{Code, Failure};

/// What stands for stdin and stdout.
pub(crate) const STANDARD: &str = "-";

/// The bytes of a file, or of stdin.
pub(crate) fn read(file: &Path) -> Result<Vec<u8>, Failure> {
    let bytes = if file == Path::new(STANDARD) {
        let mut bytes = Vec::new();
        io::stdin().lock().read_to_end(&mut bytes).map(|_| bytes)
    } else {
        std::fs::read(file)
    };
    bytes.map_err(|error| Failure::new(Code::Usage, format!("cannot read {}: {error}", file.display())))
}

/// A program's file, as the assembler takes it.
pub(crate) fn root(file: &Path) -> Result<SourceFile, Failure> {
    Ok(SourceFile { name: file.display().to_string(), bytes: read(file)?, builtin: false })
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
/// that very name, one that differs in case does: the programs come from systems that do not.
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
    let name = path.file_name()?.to_str()?;
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let entries = std::fs::read_dir(folder).ok()?.flatten().map(|entry| entry.path());
    let same = |entry: &PathBuf| {
        entry
            .file_name()
            .and_then(|found| found.to_str())
            .is_some_and(|found| found.eq_ignore_ascii_case(name))
    };
    entries.filter(|entry| entry.is_file()).find(same)
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
