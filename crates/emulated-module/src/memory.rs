//! The file that is the memory of a module on a desk: for one process at a time.

use std::fs::{self, File, FileType};
use std::io;
use std::os::unix::fs::{FileTypeExt, MetadataExt};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use rustix::fs::{FlockOperation, flock, major, minor};
use rustix::io::Errno;

/// What the board has, of which the module uses the first 128 KiB (firmware/mps2-an385/src/psram.rs).
const MEMORY_BYTES: u64 = 16 << 20;

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
    /// It cannot be opened, read or written.
    #[error("{path}: {error}; --memory names another file", path = .0.display(), error = .1)]
    File(PathBuf, io::Error),
}

/// Opens a memory, which is made if there is none. It is locked as long as the file, or a copy of its handle, is open.
///
/// # Errors
/// [`MemoryError`] where the file is not to be had.
pub(crate) fn open(path: &Path) -> Result<File, MemoryError> {
    let failure = |error| MemoryError::File(path.to_owned(), error);
    if let Some(kind) = path.metadata().ok().and_then(|found| unfit(found.file_type())) {
        return Err(MemoryError::Kind(path.to_owned(), kind));
    }
    let file =
        File::options().create(true).truncate(false).read(true).write(true).open(path).map_err(failure)?;
    lock(&file, path)?;
    match file.metadata().map_err(failure)?.len() {
        0 | MEMORY_BYTES => Ok(file),
        size => Err(MemoryError::Size(path.to_owned(), size)),
    }
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
