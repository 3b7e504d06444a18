//! Locks that a process loses when it ends, however it ends.

pub(super) use system::{try_now, wait};

#[cfg(unix)]
mod system {
    use std::fs::File;
    use std::io;

    use rustix::fs::{FlockOperation, flock};
    use rustix::io::Errno;

    /// Waits for whoever has it.
    pub(in super::super) fn wait(file: &File) -> io::Result<()> {
        Ok(flock(file, FlockOperation::LockExclusive)?)
    }

    /// False when somebody else has it.
    pub(in super::super) fn try_now(file: &File) -> io::Result<bool> {
        match flock(file, FlockOperation::NonBlockingLockExclusive) {
            Ok(()) => Ok(true),
            Err(Errno::WOULDBLOCK) => Ok(false),
            Err(error) => Err(error.into()),
        }
    }
}

#[cfg(not(unix))]
mod system {
    //! No locks: two servers in one folder are not noticed.

    use std::fs::File;
    use std::io;

    pub(in super::super) fn wait(_file: &File) -> io::Result<()> {
        Ok(())
    }

    pub(in super::super) fn try_now(_file: &File) -> io::Result<bool> {
        Ok(true)
    }
}
