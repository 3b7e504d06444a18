//! What a client asks of a carrier of frames.

use std::time::Duration;

use super::CanFrame;
use crate::LinkError;

/// A CAN bus, as [`crate::Link`] is a stream of bytes.
pub trait CanLink: Send {
    /// From now on only data frames with this 11-bit identifier are received. The others pass by, and however many they are,
    /// no wait becomes longer for them. At first every data frame with 11 bits is received.
    ///
    /// # Errors
    /// [`LinkError`] when the system will not.
    fn accept_only(&mut self, id: u16) -> Result<(), LinkError>;

    /// Sends a frame.
    ///
    /// # Errors
    /// [`LinkError`] when the interface is gone or down, or takes nothing for several seconds.
    fn send(&mut self, frame: CanFrame) -> Result<(), LinkError>;

    /// The next frame; `None` when `timeout` passes without one.
    ///
    /// # Errors
    /// [`LinkError`] when the interface is gone or down, or an adapter says that it did not send the last frame.
    fn receive(&mut self, timeout: Duration) -> Result<Option<CanFrame>, LinkError>;

    /// Forgets what has arrived and was not received; does not wait.
    ///
    /// # Errors
    /// [`LinkError`] when the interface is gone.
    fn discard(&mut self) -> Result<(), LinkError>;

    /// Lets time pass; what arrives meanwhile is kept.
    ///
    /// # Errors
    /// [`LinkError`] when the interface is gone, where the link notices.
    fn wait(&mut self, duration: Duration) -> Result<(), LinkError> {
        std::thread::sleep(duration);
        Ok(())
    }
}

impl<C: CanLink + ?Sized> CanLink for Box<C> {
    fn accept_only(&mut self, id: u16) -> Result<(), LinkError> {
        (**self).accept_only(id)
    }

    fn send(&mut self, frame: CanFrame) -> Result<(), LinkError> {
        (**self).send(frame)
    }

    fn receive(&mut self, timeout: Duration) -> Result<Option<CanFrame>, LinkError> {
        (**self).receive(timeout)
    }

    fn discard(&mut self) -> Result<(), LinkError> {
        (**self).discard()
    }

    fn wait(&mut self, duration: Duration) -> Result<(), LinkError> {
        (**self).wait(duration)
    }
}
