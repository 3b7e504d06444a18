//! Pseudo terminals: serial ports that exist in software only.

use std::fs::File;
use std::io::{self, Write};
use std::os::fd::OwnedFd;
use std::path::{Path, PathBuf};

use rustix::fs::{Mode, OFlags};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

use crate::protocol::BaudSource;

/// Why there is no pseudo terminal at a path.
#[derive(Debug, thiserror::Error)]
pub enum PtyError {
    /// Something stands at the path that is no leftover of ours.
    #[error("{0} exists; choose another path, or remove it if nothing uses it")]
    Exists(PathBuf),
    /// The link could not be made.
    #[error("cannot make the link {0}: {1}")]
    Link(PathBuf, #[source] io::Error),
    /// The system has no pseudo terminal for us.
    #[error("cannot open a pseudo terminal: {0}")]
    Open(#[from] io::Error),
    /// Every line is taken.
    #[error("all ports of the module are in use")]
    NoPort,
}

/// A pseudo terminal with a link to it, which goes when this goes.
pub struct Pty {
    link: PathBuf,
    /// What the link points to.
    name: PathBuf,
    /// Held open so that clients may come and go; a byte written here wakes the reading thread, and where there is no room
    /// for it the thread is awake.
    terminal: File,
}

impl Pty {
    /// Opens a pseudo terminal, raw, and links `path` to it; a link that points nowhere is replaced. Our side of it comes along:
    /// whoever reads there is woken by a byte when this is dropped.
    ///
    /// # Errors
    /// [`PtyError`] when the path is taken or there is no terminal to be had.
    pub fn open(path: &Path) -> Result<(Self, File), PtyError> {
        // First, lest the new terminal gets the number that the stale link points to.
        remove_stale_link(path)?;
        let (controller, terminal, name) = open().map_err(io::Error::from)?;
        std::os::unix::fs::symlink(&name, path).map_err(|error| PtyError::Link(path.to_owned(), error))?;
        let pty = Self { link: path.to_owned(), name, terminal: File::from(terminal) };
        Ok((pty, File::from(controller)))
    }
}

impl Drop for Pty {
    fn drop(&mut self) {
        // Unless somebody put something else there.
        if std::fs::read_link(&self.link).is_ok_and(|target| target == self.name) {
            let _ = std::fs::remove_file(&self.link);
        }
        let _ = self.terminal.write_all(&[0]);
    }
}

/// Says which baud rate the program at the other end of a pseudo terminal has set.
pub(crate) fn baud_source(controller: &File) -> io::Result<BaudSource> {
    let controller = controller.try_clone()?;
    // A rate of 0 hangs up, and is no rate.
    Ok(Box::new(move || Some(tcgetattr(&controller).ok()?.output_speed()).filter(|baud| *baud > 0)))
}

/// Controller and terminal, the terminal raw: it neither echoes nor rewrites a byte.
fn open() -> rustix::io::Result<(OwnedFd, OwnedFd, PathBuf)> {
    let controller = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY)?;
    grantpt(&controller)?;
    unlockpt(&controller)?;
    let name = ptsname(&controller, Vec::new())?;
    let terminal = rustix::fs::open(&*name, OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK, Mode::empty())?;
    let mut settings = tcgetattr(&terminal)?;
    settings.make_raw();
    tcsetattr(&terminal, OptionalActions::Now, &settings)?;
    Ok((controller, terminal, PathBuf::from(name.to_string_lossy().into_owned())))
}

/// A link that a server left behind when it was killed points nowhere; anything else is somebody's.
fn remove_stale_link(path: &Path) -> Result<(), PtyError> {
    let Ok(found) = path.symlink_metadata() else { return Ok(()) };
    if !found.is_symlink() || path.exists() {
        return Err(PtyError::Exists(path.to_owned()));
    }
    std::fs::remove_file(path).map_err(|error| PtyError::Link(path.to_owned(), error))
}
