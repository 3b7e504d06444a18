//! QEMU with an image of the firmware whose time runs: a module on a desk.

use std::io::{self, Write};
use std::os::fd::{AsFd, AsRawFd};
use std::os::unix::net::UnixStream;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Stdio};

use rustix::io::{FdFlags, fcntl_setfd};

use crate::chip::{self, Counting, EmulatorError};
use crate::memory::{self, MemoryError};

/// Why there is no module on a desk.
#[derive(Debug, thiserror::Error)]
pub enum DeskError {
    /// There is no image to run.
    #[error("{0} is missing: `cargo xtask firmware` builds it")]
    Image(PathBuf),
    /// There is no such memory to be had.
    #[error(transparent)]
    Memory(#[from] MemoryError),
    /// QEMU does not start.
    #[error(transparent)]
    Emulator(#[from] EmulatorError),
}

/// A module on an emulated chip whose time is the clock's. Dropping it pulls the plug.
pub struct DeskModule {
    qemu: Child,
    /// The harness listens there as long as QEMU runs.
    _harness: ChildStdin,
}

impl DeskModule {
    /// Starts an image whose flash and EEPROM are kept in a file, which is made if there is none and is refused if it is another
    /// module's. The line of the module's port comes along.
    ///
    /// # Errors
    /// [`DeskError`] where the image, its memory or QEMU is not to be had.
    pub fn start(image: &Path, module: &str, memory: &Path) -> Result<(Self, UnixStream), DeskError> {
        if !image.exists() {
            return Err(DeskError::Image(image.to_owned()));
        }
        let lock = memory::open(memory, module)?;
        let failure = |error| EmulatorError::File(memory.to_owned(), error);
        let (ours, theirs) = UnixStream::pair().map_err(failure)?;
        // QEMU gets the line, and the lock, which so lasts as long as it uses the memory.
        inherit(&theirs).and_then(|()| inherit(&lock)).map_err(failure)?;
        let mut qemu = chip::command(image, memory, Counting::Clock)
            .arg("-chardev")
            .arg(format!("socket,id=tmcl,fd={}", theirs.as_raw_fd()))
            .args(["-serial", "chardev:tmcl"])
            // The harness of the image is at QEMU's standard input.
            .args(["-chardev", "stdio,id=harness,signal=off", "-serial", "chardev:harness"])
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            // A signal from the terminal is for us to hear. We end QEMU, and where we are killed, the kernel does.
            .process_group(0)
            .spawn()
            .map_err(EmulatorError::Missing)?;
        let Some(mut harness) = qemu.stdin.take() else {
            return Err(EmulatorError::Silent(io::ErrorKind::BrokenPipe.into()).into());
        };
        // F: time runs. QEMU that does not start hangs up, and says why.
        let told = harness.write_all(b"F").map_err(EmulatorError::Silent);
        let module = Self { qemu, _harness: harness };
        told?;
        Ok((module, ours))
    }
}

impl Drop for DeskModule {
    fn drop(&mut self) {
        let _ = self.qemu.kill();
        let _ = self.qemu.wait();
    }
}

/// A handle for the programs that are started from now on.
fn inherit(handle: &impl AsFd) -> io::Result<()> {
    Ok(fcntl_setfd(handle, FdFlags::empty())?)
}
