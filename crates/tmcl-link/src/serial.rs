//! Serial ports, USB ports that look like one, and pseudo terminals.

use std::io::{self, Read, Write};
use std::path::Path;
use std::time::Duration;

use serialport::{ClearBuffer, DataBits, ErrorKind, FlowControl, Parity, SerialPort, StopBits};

use crate::error::{Errors, is_timeout};
use crate::{Link, LinkAddress, LinkError};

/// How long the port may take nothing.
const WRITE_TIMEOUT: Duration = Duration::from_secs(5);

#[cfg(target_os = "linux")]
const PERMISSION_HINT: &str =
    "on most systems it is enough to be in its group: `sudo usermod -aG dialout $USER`, then log in again";
#[cfg(not(target_os = "linux"))]
const PERMISSION_HINT: &str = "look who owns it, and with which permissions";

/// A serial port: 8 data bits, no parity, 1 stop bit, no flow control (decision: the manuals do not say), and nobody else's
/// while it is open.
pub struct SerialLink {
    port: Box<dyn SerialPort>,
    errors: Errors,
}

impl SerialLink {
    /// Opens the port that the system calls `path`, at `baud_rate` bits per second. A pseudo terminal has no baud rate and
    /// takes any.
    ///
    /// # Errors
    /// [`LinkError`] when there is no such port, or it is somebody else's, or it does not know the baud rate.
    pub fn open(path: &str, baud_rate: u32) -> Result<Self, LinkError> {
        let errors = Errors::of(LinkAddress::Serial { path: path.to_owned(), baud_rate: Some(baud_rate) });
        let unlock = pseudo_terminal::Unlock::prepare(path);
        let port = serialport::new(path, pseudo_terminal::baud_rate(path, baud_rate))
            .data_bits(DataBits::Eight)
            .parity(Parity::None)
            .stop_bits(StopBits::One)
            .flow_control(FlowControl::None)
            .timeout(WRITE_TIMEOUT)
            .open()
            .map_err(|error| open_error(&errors, path, error))?;
        if let Some(unlock) = unlock {
            unlock.release();
        }
        Ok(Self { port, errors })
    }
}

impl Link for SerialLink {
    fn write(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        self.port.set_timeout(WRITE_TIMEOUT).map_err(|error| self.errors.write(error.into()))?;
        self.port.write_all(bytes).map_err(|error| self.errors.write(error))
    }

    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> Result<usize, LinkError> {
        if buffer.is_empty() {
            return Ok(0);
        }
        self.port.set_timeout(timeout).map_err(|error| self.errors.read(error.into()))?;
        loop {
            match self.port.read(buffer) {
                Ok(0) => return Err(self.errors.closed()),
                Ok(length) => return Ok(length),
                Err(error) if is_timeout(&error) => return Ok(0),
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(self.errors.read(error)),
            }
        }
    }

    fn discard_input(&mut self) -> Result<(), LinkError> {
        self.port.clear(ClearBuffer::Input).map_err(|error| self.errors.read(error.into()))
    }
}

impl std::fmt::Debug for SerialLink {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SerialLink").field("errors", &self.errors).finish_non_exhaustive()
    }
}

fn open_error(errors: &Errors, path: &str, error: serialport::Error) -> LinkError {
    match error.kind {
        ErrorKind::Io(io::ErrorKind::PermissionDenied) => errors.permission(PERMISSION_HINT),
        // The library says "no device" both when there is none and when somebody else has it.
        ErrorKind::NoDevice if Path::new(path).exists() => errors.in_use(),
        _ => errors.open(error.into()),
    }
}

/// What differs with a pseudo terminal.
#[cfg(target_os = "linux")]
mod pseudo_terminal {
    use std::os::fd::OwnedFd;

    use rustix::fs::{Mode, OFlags};

    /// Takes the kernel's exclusive mode off a pseudo terminal.
    ///
    /// That mode belongs to the terminal, not to who opened it. On a real port it ends with the last one who closes the
    /// port. A pseudo terminal is held open by its maker, so a client that was killed would lock everybody out until the
    /// maker ends. The advisory lock, which the library takes too, goes with the client.
    pub(super) struct Unlock(OwnedFd);

    impl Unlock {
        /// Opens the pseudo terminal, if that is what it is, before it is locked.
        pub(super) fn prepare(path: &str) -> Option<Self> {
            if !std::fs::canonicalize(path).ok()?.starts_with("/dev/pts") {
                return None;
            }
            let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
            rustix::fs::open(path, flags, Mode::empty()).ok().map(Self)
        }

        /// Unlocks.
        pub(super) fn release(self) {
            // At worst it stays locked, which is what was asked for in the first place.
            let _ = rustix::termios::ioctl_tiocnxcl(&self.0);
        }
    }

    /// Linux lets a pseudo terminal have any.
    pub(super) fn baud_rate(_path: &str, wanted: u32) -> u32 {
        wanted
    }
}

/// What differs with a pseudo terminal.
#[cfg(not(target_os = "linux"))]
mod pseudo_terminal {
    /// Nothing to unlock that we know of.
    pub(super) enum Unlock {}

    impl Unlock {
        pub(super) fn prepare(_path: &str) -> Option<Self> {
            None
        }

        pub(super) fn release(self) {
            match self {}
        }
    }

    /// macOS refuses every baud rate for a pseudo terminal, `/dev/ttys` and a number; 0 tells the library not to set one.
    pub(super) fn baud_rate(path: &str, wanted: u32) -> u32 {
        let is_pseudo = cfg!(target_os = "macos")
            && std::fs::canonicalize(path)
                .is_ok_and(|path| path.to_string_lossy().strip_prefix("/dev/ttys").is_some_and(is_number));
        if is_pseudo { 0 } else { wanted }
    }

    fn is_number(text: &str) -> bool {
        !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit())
    }
}
