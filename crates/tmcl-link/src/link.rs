//! What a client asks of a carrier.

use std::time::Duration;

use crate::LinkError;

/// A stream of bytes to a module and back.
///
/// Time is the link's business: a client passes durations and never looks at a clock, so that a link into a simulation can
/// let virtual time pass instead.
pub trait Link: Send {
    /// Writes all of `bytes`.
    ///
    /// # Errors
    /// [`LinkError`] when the other side is gone, or takes nothing for several seconds.
    fn write(&mut self, bytes: &[u8]) -> Result<(), LinkError>;

    /// Reads what has arrived, waiting for the first byte: at least one, at most `buffer.len()`; 0 when `timeout` passes
    /// without any, or `buffer` is empty.
    ///
    /// # Errors
    /// [`LinkError`] when the other side is gone.
    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> Result<usize, LinkError>;

    /// Forgets what has arrived and was not read; does not wait.
    ///
    /// # Errors
    /// [`LinkError`] when the other side is gone.
    fn discard_input(&mut self) -> Result<(), LinkError>;

    /// Lets time pass; what arrives meanwhile is kept.
    ///
    /// # Errors
    /// [`LinkError`] when the other side is gone, where the link notices.
    fn wait(&mut self, duration: Duration) -> Result<(), LinkError> {
        std::thread::sleep(duration);
        Ok(())
    }

    /// Whether time passes here only while somebody waits or reads, as in a simulation.
    fn has_own_time(&self) -> bool {
        false
    }
}

impl<L: Link + ?Sized> Link for Box<L> {
    fn write(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        (**self).write(bytes)
    }

    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> Result<usize, LinkError> {
        (**self).read(buffer, timeout)
    }

    fn discard_input(&mut self) -> Result<(), LinkError> {
        (**self).discard_input()
    }

    fn wait(&mut self, duration: Duration) -> Result<(), LinkError> {
        (**self).wait(duration)
    }

    fn has_own_time(&self) -> bool {
        (**self).has_own_time()
    }
}

impl<L: Link + ?Sized> Link for &mut L {
    fn write(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        (**self).write(bytes)
    }

    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> Result<usize, LinkError> {
        (**self).read(buffer, timeout)
    }

    fn discard_input(&mut self) -> Result<(), LinkError> {
        (**self).discard_input()
    }

    fn wait(&mut self, duration: Duration) -> Result<(), LinkError> {
        (**self).wait(duration)
    }

    fn has_own_time(&self) -> bool {
        (**self).has_own_time()
    }
}
