//! What goes wrong on a link, and what was tried.

use std::io;

use crate::AddressError;

/// Why a link cannot be opened or used. Every message says which link, in a form that [`crate::open`] takes.
#[derive(Debug, thiserror::Error)]
pub enum LinkError {
    /// The text is no address.
    #[error(transparent)]
    Address(#[from] AddressError),
    /// The host's name means nothing.
    #[error("cannot find the host of {address}: {source}")]
    Resolve {
        /// The link.
        address: String,
        /// What the system says.
        source: io::Error,
    },
    /// There is nothing there, or it does not work.
    #[error("cannot open {address}: {source}")]
    Open {
        /// The link.
        address: String,
        /// What the system says.
        source: io::Error,
    },
    /// The port is there, and not for this user.
    #[error("cannot open {address}: you may not use this port; {hint}")]
    Permission {
        /// The link.
        address: String,
        /// What helps on this system.
        hint: &'static str,
    },
    /// The port is there, and somebody else has it.
    #[error("cannot open {address}: another program has it open")]
    InUse {
        /// The link.
        address: String,
    },
    /// There are frames, and the caller wants bytes.
    #[error("{address} is a CAN bus, which carries frames and no bytes")]
    NoBytes {
        /// The link.
        address: String,
    },
    /// This system has no such thing.
    #[error("cannot open {address}: {reason}")]
    Unsupported {
        /// The link.
        address: String,
        /// What is missing, and what to do instead.
        reason: &'static str,
    },
    /// A CAN adapter says that it will not.
    #[error("the CAN adapter at {address} refuses to {what}")]
    Refused {
        /// The link.
        address: String,
        /// What it was asked to do.
        what: &'static str,
    },
    /// The system does not tell which ports there are.
    #[error("cannot list the ports of this computer: {source}")]
    List {
        /// What the system says.
        source: io::Error,
    },
    /// The other side closed the connection, or the cable was pulled out.
    #[error("{address} was closed by the other side")]
    Closed {
        /// The link.
        address: String,
    },
    /// Reading failed.
    #[error("cannot read from {address}: {source}")]
    Read {
        /// The link.
        address: String,
        /// What the system says.
        source: io::Error,
    },
    /// Writing failed.
    #[error("cannot write to {address}: {source}")]
    Write {
        /// The link.
        address: String,
        /// What the system says.
        source: io::Error,
    },
}

/// The errors of one open link.
#[derive(Clone, Debug)]
pub(crate) struct Errors {
    address: String,
}

impl Errors {
    /// Errors that name this address.
    pub(crate) fn of(address: impl std::fmt::Display) -> Self {
        Self { address: address.to_string() }
    }

    pub(crate) fn resolve(&self, source: io::Error) -> LinkError {
        LinkError::Resolve { address: self.address.clone(), source }
    }

    pub(crate) fn open(&self, source: io::Error) -> LinkError {
        LinkError::Open { address: self.address.clone(), source }
    }

    pub(crate) fn permission(&self, hint: &'static str) -> LinkError {
        LinkError::Permission { address: self.address.clone(), hint }
    }

    pub(crate) fn in_use(&self) -> LinkError {
        LinkError::InUse { address: self.address.clone() }
    }

    pub(crate) fn no_bytes(&self) -> LinkError {
        LinkError::NoBytes { address: self.address.clone() }
    }

    #[cfg(not(target_os = "linux"))]
    pub(crate) fn unsupported(&self, reason: &'static str) -> LinkError {
        LinkError::Unsupported { address: self.address.clone(), reason }
    }

    pub(crate) fn refused(&self, what: &'static str) -> LinkError {
        LinkError::Refused { address: self.address.clone(), what }
    }

    pub(crate) fn closed(&self) -> LinkError {
        LinkError::Closed { address: self.address.clone() }
    }

    pub(crate) fn read(&self, source: io::Error) -> LinkError {
        if is_end(&source) {
            return self.closed();
        }
        LinkError::Read { address: self.address.clone(), source }
    }

    pub(crate) fn write(&self, source: io::Error) -> LinkError {
        if is_end(&source) {
            return self.closed();
        }
        LinkError::Write { address: self.address.clone(), source }
    }
}

/// Whether the system says in its own way that nobody is there any more.
fn is_end(error: &io::Error) -> bool {
    use io::ErrorKind::{
        BrokenPipe, ConnectionAborted, ConnectionReset, NotConnected, UnexpectedEof, WriteZero,
    };
    matches!(
        error.kind(),
        BrokenPipe | ConnectionAborted | ConnectionReset | NotConnected | UnexpectedEof | WriteZero
    )
}

/// Whether nothing came in time; systems differ in how they say so.
pub(crate) fn is_timeout(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::TimedOut | io::ErrorKind::WouldBlock)
}
