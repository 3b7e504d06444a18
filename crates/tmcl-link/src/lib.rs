//! Links to TMCL modules: bytes out, bytes in, whatever carries them.
//!
//! - [`Link`] is what a client asks of a carrier: write all of this, read what comes within a time, forget the rest.
//! - [`TcpLink`] is a socket, [`SerialLink`] a serial port, a USB port that looks like one, or a pseudo terminal.
//! - [`open`] opens either by its address ([`LinkAddress`]): `tcp:localhost:4000`, `/dev/ttyACM0@115200`, `COM3`.
//!
//! This crate must never know what the bytes mean.
#![allow(
    clippy::disallowed_methods,
    clippy::disallowed_types,
    reason = "an edge: sockets, serial ports and the waiting for them live here"
)]

mod address;
pub mod can;
mod error;
mod link;
mod serial;
mod tcp;

pub use address::{AddressError, DEFAULT_BAUD_RATE, LinkAddress};
pub use error::LinkError;
pub use link::Link;
pub use serial::SerialLink;
pub use tcp::TcpLink;

/// Opens the link at `address`, in one of the forms that [`LinkAddress`] lists.
///
/// # Errors
/// [`LinkError`] when the text is no address, or nothing can be opened there.
pub fn open(address: &str) -> Result<Box<dyn Link>, LinkError> {
    Ok(match address.parse()? {
        LinkAddress::Tcp { host, port } => Box::new(TcpLink::connect(&host, port)?),
        LinkAddress::Serial { path, baud_rate } => Box::new(SerialLink::open(&path, baud_rate)?),
    })
}
