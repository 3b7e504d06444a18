//! The file that is the memory of a module on a desk: for one kind of module, and for one process at a time.
//!
//! The module's own bytes lie at its start. At its end, far beyond them, this side notes the module's name, so that no module
//! wakes up with another's values. A file without a note, as chips leave it that a harness drives, is the first module's that
//! takes it.

use std::fs::{self, File, FileType};
use std::io;
use std::os::unix::fs::{FileExt, FileTypeExt, MetadataExt};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use rustix::fs::{FlockOperation, flock, major, minor};
use rustix::io::Errno;

/// What the board has, of which the module uses the first 128 KiB (firmware/mps2-an385/src/psram.rs).
const MEMORY_BYTES: u64 = 16 << 20;

/// The last of them: the name, filled up with zeros.
const NAME_BYTES: usize = 16;
const NAME_AT: u64 = MEMORY_BYTES - NAME_BYTES as u64;

/// How names begin.
const FAMILY: &str = "tmcm-";

/// How long a chip that is being ended may take to let go of its memory.
const PATIENCE: Duration = Duration::from_secs(1);

/// How often it is asked.
const RETRY: Duration = Duration::from_millis(10);

/// Why a file is no memory to start a module with.
#[derive(Debug, thiserror::Error)]
pub enum MemoryError {
    /// It is a folder, a device or the like.
    #[error(
        "{path} is {kind}; a module's memory is a regular file, and one that is not there is made: name another with --memory",
        path = .0.display(), kind = .1)]
    Kind(PathBuf, &'static str),
    /// It has another size.
    #[error(
        "{path} has {size} bytes; a module's memory has {MEMORY_BYTES} (16 MiB), or none when it is new: name another with --memory",
        path = .0.display(), size = .1)]
    Size(PathBuf, u64),
    /// Another process has it; the number is that of the one that locked it, where it is known and still there.
    #[error("{path} is in use by another process{process}; end that, or name another file with --memory",
        path = .0.display(), process = .1.map(|process| format!(", {process}")).unwrap_or_default())]
    InUse(PathBuf, Option<u32>),
    /// It is another module's.
    #[error(
        "{path} is the memory of a {found}, and not of a {module}: name another with --memory",
        path = .0.display(), found = .1, module = .2)]
    Module(PathBuf, String, String),
    /// It is no memory, though as large as one.
    #[error(
        "{path} is no memory of a {module}: at its end is no module's name; name another with --memory",
        path = .0.display(), module = .1)]
    Unknown(PathBuf, String),
    /// It cannot be opened, read or written.
    #[error("{path}: {error}; --memory names another file", path = .0.display(), error = .1)]
    File(PathBuf, io::Error),
}

/// Opens the memory of a module, which is made if there is none. It is locked as long as the file, or a copy of its handle, is open.
///
/// # Errors
/// [`MemoryError`] where the file is not to be had.
pub(crate) fn open(path: &Path, module: &str) -> Result<File, MemoryError> {
    let failure = |error| MemoryError::File(path.to_owned(), error);
    if let Some(kind) = path.metadata().ok().and_then(|found| unfit(found.file_type())) {
        return Err(MemoryError::Kind(path.to_owned(), kind));
    }
    let file =
        File::options().create(true).truncate(false).read(true).write(true).open(path).map_err(failure)?;
    lock(&file, path)?;
    match file.metadata().map_err(failure)?.len() {
        0 => {}
        MEMORY_BYTES => {
            let found = name(&file).map_err(failure)?;
            if found == module {
                return Ok(file);
            }
            if found.starts_with(FAMILY) {
                return Err(MemoryError::Module(path.to_owned(), found, module.to_owned()));
            }
            if !found.is_empty() {
                return Err(MemoryError::Unknown(path.to_owned(), module.to_owned()));
            }
        }
        size => return Err(MemoryError::Size(path.to_owned(), size)),
    }
    note(&file, module).map_err(failure)?;
    Ok(file)
}

/// The name at the end, without zeros.
fn name(file: &File) -> io::Result<String> {
    let mut name = [0; NAME_BYTES];
    file.read_exact_at(&mut name, NAME_AT)?;
    Ok(String::from_utf8_lossy(&name).trim_end_matches('\0').to_owned())
}

/// One write, which also makes a new file as large as it has to be: it never is without a name.
fn note(file: &File, module: &str) -> io::Result<()> {
    let mut name = [0; NAME_BYTES];
    for (place, byte) in name.iter_mut().zip(module.bytes()) {
        *place = byte;
    }
    file.write_all_at(&name, NAME_AT)
}

/// What it is, where it is no regular file. Opening a pipe would wait for somebody at its other end.
fn unfit(kind: FileType) -> Option<&'static str> {
    if kind.is_file() {
        return None;
    }
    Some(match kind {
        kind if kind.is_dir() => "a folder",
        kind if kind.is_fifo() => "a pipe",
        kind if kind.is_socket() => "a socket",
        _ => "a device",
    })
}

fn lock(file: &File, path: &Path) -> Result<(), MemoryError> {
    let started = Instant::now();
    loop {
        match flock(file, FlockOperation::NonBlockingLockExclusive) {
            Ok(()) => return Ok(()),
            Err(Errno::WOULDBLOCK) if started.elapsed() < PATIENCE => std::thread::sleep(RETRY),
            Err(Errno::WOULDBLOCK) => return Err(MemoryError::InUse(path.to_owned(), holder(file))),
            Err(error) => return Err(MemoryError::File(path.to_owned(), error.into())),
        }
    }
}

/// Who has locked a file, where the system says so (proc(5), /proc/locks): `1: FLOCK ADVISORY WRITE 4711 08:01:1234 0 EOF`.
fn holder(file: &File) -> Option<u32> {
    let file = file.metadata().ok()?;
    let place = format!("{:02x}:{:02x}:{}", major(file.dev()), minor(file.dev()), file.ino());
    let locks = fs::read_to_string("/proc/locks").ok()?;
    locks.lines().find_map(|line| {
        let mut words = line.split_whitespace().skip(1);
        let (kind, process) = (words.next()?, words.nth(2)?);
        let found = kind == "FLOCK" && words.next()? == place && Path::new("/proc").join(process).exists();
        found.then(|| process.parse().ok())?
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A path of its own for each test, at which is nothing.
    fn path(test: &str) -> PathBuf {
        let path = std::env::temp_dir().join(format!("emulated-module-{test}-{}.psram", std::process::id()));
        let _ = fs::remove_file(&path);
        path
    }

    fn refusal(path: &Path, module: &str) -> String {
        open(path, module).unwrap_err().to_string().replace(&path.display().to_string(), "FILE")
    }

    #[test]
    fn a_memory_is_for_one_kind_of_module() {
        let path = path("kinds");
        drop(open(&path, "tmcm-1311").unwrap());
        assert_eq!(path.metadata().unwrap().len(), MEMORY_BYTES);
        assert_eq!(
            refusal(&path, "tmcm-1640"),
            "FILE is the memory of a tmcm-1311, and not of a tmcm-1640: name another with --memory"
        );
        drop(open(&path, "tmcm-1311").unwrap());
        fs::remove_file(&path).unwrap();
    }

    #[test]
    fn a_memory_without_a_name_gets_the_first_and_keeps_what_it_has() {
        let path = path("nameless");
        let file = File::create_new(&path).unwrap();
        file.write_all_at(b"records", 0).unwrap();
        file.set_len(MEMORY_BYTES).unwrap();
        let opened = open(&path, "tmcm-1640").unwrap();
        let mut start = [0; 7];
        opened.read_exact_at(&mut start, 0).unwrap();
        assert_eq!(&start, b"records");
        assert_eq!(name(&opened).unwrap(), "tmcm-1640");
        note(&opened, "\u{1F980}").unwrap();
        drop(opened);
        assert_eq!(
            refusal(&path, "tmcm-1640"),
            "FILE is no memory of a tmcm-1640: at its end is no module's name; name another with --memory"
        );
        fs::remove_file(&path).unwrap();
    }

    #[test]
    fn what_is_no_memory_is_refused_as_it_is() {
        assert_eq!(
            refusal(&std::env::temp_dir(), "tmcm-1311"),
            "FILE is a folder; a module's memory is a regular file, and one that is not there is made: name another with --memory"
        );
        let path = path("short");
        fs::write(&path, "short").unwrap();
        assert_eq!(
            refusal(&path, "tmcm-1311"),
            "FILE has 5 bytes; a module's memory has 16777216 (16 MiB), or none when it is new: name another with --memory"
        );
        assert_eq!(fs::read(&path).unwrap(), b"short");
        fs::remove_file(&path).unwrap();
    }

    #[test]
    fn a_memory_is_for_one_process() {
        let path = path("lock");
        let file = open(&path, "tmcm-1311").unwrap();
        let error = open(&path, "tmcm-1311").unwrap_err();
        // Where the file system has numbers of its own, nobody can be named.
        let MemoryError::InUse(_, process) = error else { panic!("{error}") };
        assert!(process.is_none_or(|process| process == std::process::id()), "{process:?}");
        drop(file);
        drop(open(&path, "tmcm-1311").unwrap());
        fs::remove_file(&path).unwrap();
    }
}
