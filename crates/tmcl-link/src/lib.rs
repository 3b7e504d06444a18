//! Links to TMCL modules: bytes out, bytes in, whatever carries them; or frames, on a CAN bus.
//!
//! - [`Link`] is what a client asks of a carrier of bytes: write all of this, read what comes within a time, forget the rest.
//!   [`TcpLink`] is a socket, [`SerialLink`] a serial port, a USB port that looks like one, or a pseudo terminal.
//! - [`can::CanLink`] is the same for frames. [`can::SlcanLink`] is an adapter on a serial port, [`can::SocketCan`] an interface
//!   of Linux.
//! - [`open`] and [`open_with`] open any of them by its address ([`LinkAddress`]): `tcp://localhost:4000`,
//!   `/dev/ttyACM0@115200`, `COM3`, `slcan:///dev/ttyACM0`, `can://can0`. [`ports`] lists what this computer has.
//! - [`FaultyLink`] is a line that loses, doubles, spoils and delays bytes, for the tests of those who use a link.
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
mod faulty;
mod link;
mod ports;
mod serial;
mod tcp;

pub use address::{
    AddressError, DEFAULT_ADAPTER_BAUD_RATE, DEFAULT_BAUD_RATE, DEFAULT_CAN_BIT_RATE, LinkAddress, Speeds,
};
pub use error::LinkError;
pub use faulty::{Counts, Direction, Faults, FaultyLink};
pub use link::Link;
pub use ports::{Port, PortKind, UsbDevice, ports};
pub use serial::SerialLink;
pub use tcp::TcpLink;

use can::{CanLink, SlcanLink, SocketCan};
use error::Errors;

/// What an address leads to.
pub enum Carrier {
    /// A carrier of bytes.
    Bytes(Box<dyn Link>),
    /// A carrier of frames.
    Frames(Box<dyn CanLink>),
}

impl std::fmt::Debug for Carrier {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Bytes(_) => "Bytes",
            Self::Frames(_) => "Frames",
        })
    }
}

/// Opens the carrier of bytes at `address`, in one of the forms that [`LinkAddress`] lists, at the factory's speed if the
/// address does not say.
///
/// # Errors
/// [`LinkError`] when the text is no address, or nothing can be opened there; [`LinkError::NoBytes`] when it is a CAN bus.
pub fn open(address: &str) -> Result<Box<dyn Link>, LinkError> {
    let address: LinkAddress = address.parse()?;
    if address.is_can() {
        return Err(Errors::of(address).no_bytes());
    }
    match open_with(address.clone(), Speeds::default())? {
        Carrier::Bytes(link) => Ok(link),
        Carrier::Frames(_) => Err(Errors::of(address).no_bytes()),
    }
}

/// Opens whatever is at `address`, at `speeds` where the address does not say.
///
/// # Errors
/// [`LinkError`] when nothing can be opened there.
pub fn open_with(address: LinkAddress, speeds: Speeds) -> Result<Carrier, LinkError> {
    Ok(match address.with_speeds(speeds) {
        LinkAddress::Tcp { host, port } => Carrier::Bytes(Box::new(TcpLink::connect(&host, port)?)),
        LinkAddress::Serial { path, baud_rate } => {
            Carrier::Bytes(Box::new(SerialLink::open(&path, baud_rate.unwrap_or(DEFAULT_BAUD_RATE))?))
        }
        LinkAddress::Slcan { path, bit_rate } => {
            let port = SerialLink::open(&path, speeds.baud_rate.unwrap_or(DEFAULT_ADAPTER_BAUD_RATE))?;
            let bit_rate = bit_rate.unwrap_or(DEFAULT_CAN_BIT_RATE);
            Carrier::Frames(Box::new(SlcanLink::open(port, &path, bit_rate)?))
        }
        LinkAddress::Can { interface } => Carrier::Frames(Box::new(SocketCan::open(&interface)?)),
    })
}
