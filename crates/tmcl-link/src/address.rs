//! The text that says where a module is.

use std::fmt;
use std::str::FromStr;

/// Bits per second of a serial port whose address does not say: what modules are set to in the factory (TMCM-1311 §10.1).
pub const DEFAULT_BAUD_RATE: u32 = 9600;

/// Where a module is.
///
/// | text | link |
/// |---|---|
/// | `tcp:HOST:PORT`, `HOST:PORT` | a TCP socket; an IPv6 address stands in brackets: `[::1]:4000` |
/// | `serial:PORT`, `serial:PORT@BAUD` | a serial port or pseudo terminal |
/// | `PORT`, `PORT@BAUD` with a `/` or `\` in it, or `COM` and a number | the same |
///
/// The baud rate is [`DEFAULT_BAUD_RATE`] unless it is given; USB ports and pseudo terminals ignore it. A port whose name
/// has an `@` in it needs its baud rate said: what follows the last `@` is one. (decision)
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
        /// Bits per second.
        baud_rate: u32,
    },
}

/// Why a text is no address of a link.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AddressError {
    /// The text fits no form.
    #[error("\"{0}\" is no address of a module: write HOST:PORT, /dev/ttyACM0, /dev/ttyUSB0@115200 or COM3")]
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
}

impl FromStr for LinkAddress {
    type Err = AddressError;

    fn from_str(text: &str) -> Result<Self, AddressError> {
        if let Some(rest) = strip_scheme(text, "serial:") {
            parse_serial(text, rest)
        } else if let Some(rest) = strip_scheme(text, "tcp:") {
            parse_tcp(text, rest)
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
            Self::Serial { path, baud_rate } => write!(f, "serial:{path}@{baud_rate}"),
        }
    }
}

fn strip_scheme<'a>(text: &'a str, scheme: &str) -> Option<&'a str> {
    let (head, rest) = text.split_at_checked(scheme.len())?;
    head.eq_ignore_ascii_case(scheme).then_some(rest)
}

/// A path, or what Windows calls its ports.
fn looks_like_a_serial_port(text: &str) -> bool {
    let name = text.split_once('@').map_or(text, |(name, _)| name);
    let is_com = strip_scheme(name, "com")
        .is_some_and(|number| !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit()));
    is_com || text.contains(['/', '\\'])
}

fn parse_serial(text: &str, rest: &str) -> Result<LinkAddress, AddressError> {
    let (path, baud_rate) = match rest.rsplit_once('@') {
        None => (rest, DEFAULT_BAUD_RATE),
        Some((path, found)) => (path, parse_baud_rate(text, found)?),
    };
    if path.is_empty() {
        return Err(AddressError::Form(text.to_owned()));
    }
    Ok(LinkAddress::Serial { path: path.to_owned(), baud_rate })
}

fn parse_baud_rate(text: &str, found: &str) -> Result<u32, AddressError> {
    let error = || AddressError::BaudRate { text: text.to_owned(), found: found.to_owned() };
    found.parse().ok().filter(|rate| *rate > 0).ok_or_else(error)
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
    if host.is_empty() || host.contains(['[', ']']) {
        return Err(form());
    }
    let error = || AddressError::Port { text: text.to_owned(), found: port.to_owned() };
    let port = port.parse().ok().filter(|port| *port > 0).ok_or_else(error)?;
    Ok(LinkAddress::Tcp { host: host.to_owned(), port })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn tcp(host: &str, port: u16) -> Result<LinkAddress, AddressError> {
        Ok(LinkAddress::Tcp { host: host.to_owned(), port })
    }

    fn serial(path: &str, baud_rate: u32) -> Result<LinkAddress, AddressError> {
        Ok(LinkAddress::Serial { path: path.to_owned(), baud_rate })
    }

    #[test]
    fn sockets() {
        assert_eq!("tcp:localhost:4000".parse(), tcp("localhost", 4000));
        assert_eq!("127.0.0.1:4000".parse(), tcp("127.0.0.1", 4000));
        assert_eq!("TCP:[::1]:4000".parse(), tcp("::1", 4000));
        // A host may have the name of a port.
        assert_eq!("com3:4000".parse(), tcp("com3", 4000));
        assert_eq!("tcp:com3:4000".parse(), tcp("com3", 4000));
    }

    #[test]
    fn serial_ports() {
        assert_eq!("/dev/ttyACM0".parse(), serial("/dev/ttyACM0", DEFAULT_BAUD_RATE));
        assert_eq!("serial:/dev/ttyACM0@115200".parse(), serial("/dev/ttyACM0", 115_200));
        assert_eq!("./module".parse(), serial("./module", 9600));
        assert_eq!("serial:module".parse(), serial("module", 9600));
        assert_eq!("COM3".parse(), serial("COM3", 9600));
        assert_eq!("com12@250000".parse(), serial("com12", 250_000));
        assert_eq!(r"\\.\COM10".parse(), serial(r"\\.\COM10", 9600));
        assert_eq!("/dev/odd@name@9600".parse(), serial("/dev/odd@name", 9600));
        assert_eq!("/tmp/a:1".parse(), serial("/tmp/a:1", 9600));
    }

    #[test]
    fn errors_say_what_is_wrong() {
        let error = |text: &str| text.parse::<LinkAddress>().expect_err("no address").to_string();
        assert_eq!(
            error("module"),
            "\"module\" is no address of a module: write HOST:PORT, /dev/ttyACM0, /dev/ttyUSB0@115200 or COM3"
        );
        assert_eq!(
            error("localhost:"),
            "\"\" in \"localhost:\" is no TCP port: write HOST:PORT with a port from 1 to 65535"
        );
        assert_eq!(
            error("/dev/ttyACM0@fast"),
            "\"fast\" in \"/dev/ttyACM0@fast\" is no baud rate: write a number such as 9600 or 115200 after the @"
        );
        let all = [
            "",
            "tcp:",
            ":1",
            "[]:1",
            "[::1:4",
            "::1:4",
            "a:0",
            "a:65536",
            "serial:",
            "serial:@1",
            "COM",
            "COM1@0",
        ];
        for text in all {
            assert!(text.parse::<LinkAddress>().is_err(), "{text}");
        }
    }

    proptest! {
        /// What is printed can be typed.
        #[test]
        fn every_address_survives_being_printed(text: String) {
            if let Ok(address) = text.parse::<LinkAddress>() {
                prop_assert_eq!(address.to_string().parse(), Ok(address));
            }
        }

        #[test]
        fn so_do_likely_ones(text in "(tcp:|serial:)?[a-z/@:0-9\\[\\]]{0,12}[@:]?[0-9]{0,5}") {
            if let Ok(address) = text.parse::<LinkAddress>() {
                prop_assert_eq!(address.to_string().parse(), Ok(address));
            }
        }
    }
}
