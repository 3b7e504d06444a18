//! Where a module is and how patiently to talk to it, as people write it: in `tmcl.toml`, and the values of the settings anywhere.
//!
//! What a port's notation means is not known here, nor where the file lies: a text goes in.

mod parse;
mod values;

pub use parse::parse;
pub use values::{BaudRates, address, baud_rates, retries, timeout};

use std::time::Duration;

/// What `tmcl.toml` says; what it does not say is `None`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ConnectionSettings {
    /// Where the module is, in the notation of `--port`.
    pub port: Option<String>,
    /// Bits per second of a serial port.
    pub baud: Option<BaudRates>,
    /// The module's address, or its identifier on a CAN bus: 0 to 0x7FF.
    pub address: Option<u16>,
    /// The address, or identifier, that it replies to: 0 to 0x7FF.
    pub host_address: Option<u16>,
    /// How long to wait for a reply: 1 ms to 1 h.
    pub timeout: Option<Duration>,
    /// How often to ask again: 0 to 100.
    pub retries: Option<u32>,
}
