//! The text that says where a module is.

use std::fmt;
use std::str::FromStr;

use crate::can::slcan::BitRate;

/// Bits per second of a serial port when nobody says: what modules are set to in the factory (TMCM-1311 §10.1).
pub const DEFAULT_BAUD_RATE: u32 = 9600;

/// Bits per second between a computer and a serial CAN adapter when nobody says. Most sit on USB, where it means nothing.
pub const DEFAULT_ADAPTER_BAUD_RATE: u32 = 115_200;

/// Bits per second of a CAN bus when nobody says: what modules are set to in the factory (TMCM-1311 §5.7.36, parameter 69).
pub const DEFAULT_CAN_BIT_RATE: BitRate = BitRate::Kbit1000;

/// Where a module is.
///
/// | text | link |
/// |---|---|
/// | `tcp://HOST:PORT`, `HOST:PORT` | a TCP socket; an IPv6 address stands in brackets: `[::1]:4000` |
/// | `serial:PORT`, `serial:PORT@BAUD` | a serial port or pseudo terminal |
/// | `PORT`, `PORT@BAUD` with a `/` or `\` in it, or `COM` and a number | the same |
/// | `slcan://PORT`, `slcan://PORT@BITRATE` | a CAN bus, through an adapter on a serial port that speaks [`crate::can::slcan`] |
/// | `can://INTERFACE` | a CAN bus, through an interface of Linux such as `can0`, set up by the system |
///
/// The slashes behind a scheme may be left out, and a scheme may be written in capitals. What is not given is taken from
/// [`Speeds`]: the baud rate, which USB ports and pseudo terminals ignore, and the bit rate of the CAN bus. A port whose name
/// has an `@` in it needs its rate said: what follows the last `@` is one. (decision)
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LinkAddress {
    /// A TCP socket.
    Tcp {
        /// The host's name or number, an IPv6 address without brackets.
        host: String,
        /// The port.
        port: u16,
    },
    /// A serial port.
    Serial {
        /// What the system calls it.
        path: String,
        /// Bits per second, if the address says.
        baud_rate: Option<u32>,
    },
    /// A CAN bus behind an adapter on a serial port.
    Slcan {
        /// What the system calls the port.
        path: String,
        /// The bus's bits per second, if the address says.
        bit_rate: Option<BitRate>,
    },
    /// A CAN bus behind an interface of the system.
    Can {
        /// What the system calls it.
        interface: String,
    },
}

/// What an address may leave to the caller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Speeds {
    /// Bits per second of a serial port; when `None`, [`DEFAULT_BAUD_RATE`], and [`DEFAULT_ADAPTER_BAUD_RATE`] for the port of
    /// a CAN adapter.
    pub baud_rate: Option<u32>,
    /// Bits per second of a CAN bus; when `None`, [`DEFAULT_CAN_BIT_RATE`]. An interface of the system has one already, and
    /// it is not changed.
    pub can_bit_rate: Option<BitRate>,
}

/// Why a text is no address of a link.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AddressError {
    /// The text fits no form.
    #[error(
        "\"{0}\" is no address of a module: write tcp://HOST:PORT, /dev/ttyACM0, /dev/ttyUSB0@115200, COM3, \
         slcan:///dev/ttyACM0 or can://can0"
    )]
    Form(String),
    /// What stands where a TCP port belongs is none.
    #[error("\"{found}\" in \"{text}\" is no TCP port: write HOST:PORT with a port from 1 to 65535")]
    Port {
        /// The whole text.
        text: String,
        /// What stands where the port belongs.
        found: String,
    },
    /// What follows the `@` is no baud rate.
    #[error("\"{found}\" in \"{text}\" is no baud rate: write a number such as 9600 or 115200 after the @")]
    BaudRate {
        /// The whole text.
        text: String,
        /// What stands where the baud rate belongs.
        found: String,
    },
    /// What follows the `@` is no bit rate that an adapter can be set to.
    #[error(
        "\"{found}\" in \"{text}\" is no bit rate of a CAN bus: write 10000, 20000, 50000, 100000, 125000, 250000, \
         500000, 800000 or 1000000 after the @"
    )]
    BitRate {
        /// The whole text.
        text: String,
        /// What stands where the bit rate belongs.
        found: String,
    },
    /// No interface of Linux is called so.
    #[error(
        "\"{found}\" in \"{text}\" is no CAN interface: write its name, up to 15 characters, as in can://can0"
    )]
    Interface {
        /// The whole text.
        text: String,
        /// What stands where the interface belongs.
        found: String,
    },
}

impl LinkAddress {
    /// The address with everything said that it left to the caller.
    #[must_use]
    pub fn with_speeds(self, speeds: Speeds) -> Self {
        match self {
            Self::Serial { path, baud_rate } => {
                let rate = baud_rate.or(speeds.baud_rate).unwrap_or(DEFAULT_BAUD_RATE);
                Self::Serial { path, baud_rate: Some(rate) }
            }
            Self::Slcan { path, bit_rate } => {
                let rate = bit_rate.or(speeds.can_bit_rate).unwrap_or(DEFAULT_CAN_BIT_RATE);
                Self::Slcan { path, bit_rate: Some(rate) }
            }
            Self::Tcp { .. } | Self::Can { .. } => self,
        }
    }

    /// Whether frames travel there, and no bytes.
    #[must_use]
    pub const fn is_can(&self) -> bool {
        matches!(self, Self::Slcan { .. } | Self::Can { .. })
    }
}

impl FromStr for LinkAddress {
    type Err = AddressError;

    fn from_str(text: &str) -> Result<Self, AddressError> {
        if let Some(rest) = strip_scheme(text, "serial:") {
            parse_serial(text, rest)
        } else if let Some(rest) = strip_scheme(text, "tcp:") {
            parse_tcp(text, rest)
        } else if let Some(rest) = strip_scheme(text, "slcan:") {
            parse_slcan(text, rest)
        } else if let Some(rest) = strip_scheme(text, "can:") {
            parse_interface(text, rest)
        } else if looks_like_a_serial_port(text) {
            parse_serial(text, text)
        } else {
            parse_tcp(text, text)
        }
    }
}

impl fmt::Display for LinkAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Tcp { host, port } if host.contains(':') => write!(f, "tcp:[{host}]:{port}"),
            Self::Tcp { host, port } => write!(f, "tcp:{host}:{port}"),
            Self::Serial { path, baud_rate } => {
                write!(f, "serial:{}{path}", slashes(path))?;
                baud_rate.map_or(Ok(()), |rate| write!(f, "@{rate}"))
            }
            Self::Slcan { path, bit_rate } => {
                write!(f, "slcan:{}{path}", slashes(path))?;
                bit_rate.map_or(Ok(()), |rate| write!(f, "@{}", rate.bits_per_second()))
            }
            Self::Can { interface } => write!(f, "can:{interface}"),
        }
    }
}

/// What keeps the first slashes of a path from being taken for those behind a scheme.
fn slashes(path: &str) -> &'static str {
    if path.starts_with("//") { "//" } else { "" }
}

/// What follows a scheme and its slashes.
fn strip_scheme<'a>(text: &'a str, scheme: &str) -> Option<&'a str> {
    let rest = strip_prefix(text, scheme)?;
    Some(rest.strip_prefix("//").unwrap_or(rest))
}

fn strip_prefix<'a>(text: &'a str, prefix: &str) -> Option<&'a str> {
    let (head, rest) = text.split_at_checked(prefix.len())?;
    head.eq_ignore_ascii_case(prefix).then_some(rest)
}

/// A path, or what Windows calls its ports.
fn looks_like_a_serial_port(text: &str) -> bool {
    let name = text.split_once('@').map_or(text, |(name, _)| name);
    let is_com = strip_prefix(name, "com")
        .is_some_and(|number| !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit()));
    is_com || text.contains(['/', '\\'])
}

fn parse_serial(text: &str, rest: &str) -> Result<LinkAddress, AddressError> {
    let (path, rate) = parse_port(text, rest)?;
    let error = |found: &str| AddressError::BaudRate { text: text.to_owned(), found: found.to_owned() };
    let parse = |found: &str| found.parse().ok().filter(|rate| *rate > 0).ok_or_else(|| error(found));
    Ok(LinkAddress::Serial { path: path.to_owned(), baud_rate: rate.map(parse).transpose()? })
}

fn parse_slcan(text: &str, rest: &str) -> Result<LinkAddress, AddressError> {
    let (path, rate) = parse_port(text, rest)?;
    let error = |found: &str| AddressError::BitRate { text: text.to_owned(), found: found.to_owned() };
    let known = |found: &str| BitRate::from_bits_per_second(found.parse().ok()?);
    let parse = |found: &str| known(found).ok_or_else(|| error(found));
    Ok(LinkAddress::Slcan { path: path.to_owned(), bit_rate: rate.map(parse).transpose()? })
}

/// A serial port, and what follows its `@`.
fn parse_port<'a>(text: &str, rest: &'a str) -> Result<(&'a str, Option<&'a str>), AddressError> {
    let (path, rate) = match rest.rsplit_once('@') {
        None => (rest, None),
        Some((path, rate)) => (path, Some(rate)),
    };
    if path.is_empty() {
        return Err(AddressError::Form(text.to_owned()));
    }
    Ok((path, rate))
}

fn parse_interface(text: &str, rest: &str) -> Result<LinkAddress, AddressError> {
    // What Linux lets an interface be called.
    let is_name =
        matches!(rest.len(), 1..=15) && !rest.contains(['/', ':']) && !rest.contains(char::is_whitespace);
    if !is_name || rest == "." || rest == ".." {
        return Err(AddressError::Interface { text: text.to_owned(), found: rest.to_owned() });
    }
    Ok(LinkAddress::Can { interface: rest.to_owned() })
}

fn parse_tcp(text: &str, rest: &str) -> Result<LinkAddress, AddressError> {
    let form = || AddressError::Form(text.to_owned());
    let (host, port) = rest.rsplit_once(':').ok_or_else(form)?;
    let host = match host.strip_prefix('[') {
        Some(inner) => inner.strip_suffix(']').ok_or_else(form)?,
        // More colons are an IPv6 address without brackets, and where it ends is anybody's guess.
        None if host.contains(':') => return Err(form()),
        None => host,
    };
    if host.is_empty() || host.contains(['[', ']', '/']) {
        return Err(form());
    }
    let error = || AddressError::Port { text: text.to_owned(), found: port.to_owned() };
    let port = port.parse().ok().filter(|port| *port > 0).ok_or_else(error)?;
    Ok(LinkAddress::Tcp { host: host.to_owned(), port })
}

#[cfg(test)]
mod tests;
