//! QEMU with an image of the firmware whose time runs: a module on a desk.

use std::io::{self, Read, Write};
use std::os::fd::{AsFd, AsRawFd};
use std::os::unix::net::UnixStream;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Stdio};

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
}

/// The harness of a chip whose time runs. The chip needs it to the end.
pub struct Harness {
    input: ChildStdin,
    output: ChildStdout,
}

impl Harness {
    /// The client at the module's port has left: when this returns, what it left half-said is forgotten, and the port is in the
    /// mode it was in at power-on. A chip that is gone has forgotten it, too.
    pub fn client_left(&mut self) {
        let told = self.input.write_all(b"X");
        let _ = told.and_then(|()| self.output.read_exact(&mut [0]));
    }
}

impl DeskModule {
    /// Starts an image whose flash and EEPROM are kept in a file, which is made if there is none and is refused if it is another
    /// module's. The line of the module's port comes along, and the harness.
    ///
    /// # Errors
    /// [`DeskError`] where the image, its memory or QEMU is not to be had.
    pub fn start(
        image: &Path,
        module: &str,
        memory: &Path,
    ) -> Result<(Self, UnixStream, Harness), DeskError> {
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
            .stdout(Stdio::piped())
            // A signal from the terminal is for us to hear. We end QEMU, and where we are killed, the kernel does.
            .process_group(0)
            .spawn()
            .map_err(EmulatorError::Missing)?;
        let (input, output) = (qemu.stdin.take(), qemu.stdout.take());
        let module = Self { qemu };
        let (Some(mut input), Some(output)) = (input, output) else {
            return Err(EmulatorError::Silent(io::ErrorKind::BrokenPipe.into()).into());
        };
        // F: time runs. QEMU that does not start hangs up, and says why.
        input.write_all(b"F").map_err(EmulatorError::Silent)?;
        Ok((module, ours, Harness { input, output }))
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
