//! `tmcl scan`: who is on this bus.

use std::time::Duration;

use clap::Args;
use serde::Serialize;
use tmcl_client::{ClientError, FirmwareVersion, Heard, Presence};

use super::asm::counted;
use crate::connection::{AnyClient, Connection, ConnectionOptions, failure};
use crate::exit::{Code, Failure, Outcome};
use crate::print;

/// Bits of a request and its reply on a serial line, with start and stop bits.
const BITS: u32 = 2 * 9 * 10;

/// What a module and the computer may take besides.
const PATIENCE: Duration = Duration::from_millis(50);

/// `tmcl scan`.
#[derive(Args)]
#[command(
    after_help = "Every address is asked for its firmware version, which changes nothing in a module. --timeout says how long \
    each is waited for; without it, as long as the line needs, and 50 ms more. --baud takes several rates here, \
    as in 9600,115200, and `all`. Exits with 3 if nobody answers."
)]
pub(crate) struct Scan {
    /// The addresses to ask: 1-20, or 1,5,7-9
    #[arg(long, value_name = "RANGE", default_value = "1-255", value_parser = addresses)]
    addresses: Addresses,
    /// Print JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    connection: ConnectionOptions,
}

/// Ascending, each once.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Addresses(Vec<u8>);

/// Somebody.
#[derive(Serialize)]
struct Found {
    address: u8,
    module: String,
    firmware: String,
    /// The host address that it replies to.
    host_address: u8,
    #[serde(skip_serializing_if = "Option::is_none")]
    baud: Option<u32>,
}

/// Looks for modules.
pub(crate) fn run(options: &Scan) -> Outcome {
    let connection = options.connection.resolve()?;
    let rates = connection.baud_rates();
    let rates: Vec<Option<u32>> =
        if rates.is_empty() { vec![None] } else { rates.into_iter().map(Some).collect() };
    let Addresses(addresses) = &options.addresses;
    let bar = print::progress(rates.len() * addresses.len(), "addresses asked");
    let mut found = Vec::new();
    for rate in rates {
        let mut client = connection.open_at(rate)?;
        for address in addresses {
            let answer =
                asked(&mut client, *address, timeout(&connection, rate)).map_err(|error| failure(&error))?;
            found.extend(
                answer.map(|(version, host_address)| Found::of(version, *address, host_address, rate)),
            );
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    print(&found, options.json)?;
    if found.is_empty() {
        let count = counted(addresses.len(), "address").replace("addresss", "addresses");
        let message = format!("nobody answered at {}, {count} asked", connection.port());
        return Err(Failure::new(Code::Connection, message).into());
    }
    Ok(())
}

fn print(found: &[Found], json: bool) -> std::io::Result<()> {
    if json {
        return print::json(&found);
    }
    if found.is_empty() {
        return Ok(());
    }
    let row = |it: &Found| {
        let baud = it.baud.map_or_else(|| "-".to_owned(), |baud| baud.to_string());
        [it.address.to_string(), it.module.clone(), it.firmware.clone(), it.host_address.to_string(), baud]
    };
    print::table(["address", "module", "firmware", "replies to", "baud"], found.iter().map(row))
}

impl Found {
    fn of(version: Option<FirmwareVersion>, address: u8, host_address: u8, baud: Option<u32>) -> Self {
        let name = |version: FirmwareVersion| {
            version.module_spec().map_or_else(|| version.module.to_string(), |spec| spec.name.to_owned())
        };
        let module = version.map_or_else(|| "does not say".to_owned(), name);
        let firmware = version.map_or_else(String::new, |it| format!("V{}.{:02}", it.major, it.minor));
        Self { address, module, firmware, host_address, baud }
    }
}

fn timeout(connection: &Connection, rate: Option<u32>) -> Duration {
    if connection.timeout_is_given() {
        return connection.settings().timeout;
    }
    let line = rate.map_or(Duration::ZERO, |rate| Duration::from_secs(1) * BITS / rate.max(1));
    line + PATIENCE
}

/// Asks one address; a module may reply to another host than us, and is asked again as that.
fn asked(
    client: &mut AnyClient,
    address: u8,
    timeout: Duration,
) -> Result<Option<(Option<FirmwareVersion>, u8)>, ClientError> {
    let host = client.settings().host_address;
    let presence = match client.probe(address, timeout)? {
        Presence::Unclear(Heard::Other { host: other, module }) if module == address && other != host => {
            client.settings_mut().host_address = other;
            let presence = client.probe(address, timeout);
            client.settings_mut().host_address = host;
            return Ok(Some((version(presence?), other)));
        }
        presence => presence,
    };
    Ok(match presence {
        Presence::Module(_) | Presence::Silent(_) => Some((version(presence), host)),
        Presence::Nobody | Presence::Unclear(_) => None,
    })
}

fn version(presence: Presence) -> Option<FirmwareVersion> {
    match presence {
        Presence::Module(version) => Some(version),
        Presence::Silent(_) | Presence::Nobody | Presence::Unclear(_) => None,
    }
}

/// `1-20`, `1,5,7-9`.
fn addresses(text: &str) -> Result<Addresses, String> {
    const EXPECTED: &str = "addresses from 0 to 255 are expected, such as 1-20 or 1,5,7-9";
    let mut all = std::collections::BTreeSet::new();
    for part in text.split(',') {
        let (first, last) = part.split_once('-').or_else(|| part.split_once("..=")).unwrap_or((part, part));
        match (first.trim().parse::<u8>(), last.trim().parse::<u8>()) {
            (Ok(first), Ok(last)) if first <= last => all.extend(first..=last),
            _ => return Err(EXPECTED.to_owned()),
        }
    }
    Ok(Addresses(all.into_iter().collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_of_addresses() {
        assert_eq!(addresses("5"), Ok(Addresses(vec![5])));
        assert_eq!(addresses("7-9,1,8"), Ok(Addresses(vec![1, 7, 8, 9])));
        assert_eq!(addresses("1..=255").map(|all| all.0.len()), Ok(255));
        for wrong in ["", "9-7", "1-256", "a", "1,,2", "-5"] {
            assert!(addresses(wrong).is_err(), "{wrong}");
        }
    }
}
