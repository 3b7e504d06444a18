//! `tmcl scan`: who is on this bus.

use std::time::Duration;

use clap::Args;
use serde::Serialize;
use tmcl_client::{Client, ClientError, FirmwareVersion, Heard, Parties, Presence};

use super::asm::counted;
use crate::connection::{self, AnyClient, Connection, ConnectionOptions, failure};
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
    /// The addresses to ask: 1-20, or 1,5,7-9; on CAN up to 0x7FF
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
struct Addresses(Vec<u16>);

/// Somebody.
#[derive(Serialize)]
struct Found {
    address: u16,
    module: String,
    firmware: String,
    /// The host address that it replies to.
    host_address: u16,
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
    if let Some(Err(message)) = addresses.last().map(|last| connection.takes(*last)) {
        return Err(Failure::new(Code::Usage, format!("in --addresses: {message}")).into());
    }
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
    fn of(version: Option<FirmwareVersion>, address: u16, host_address: u16, baud: Option<u32>) -> Self {
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
    address: u16,
    timeout: Duration,
) -> Result<Option<(Option<FirmwareVersion>, u16)>, ClientError> {
    let host = client.parties().host;
    let presence = match probe(client, Parties { module: address, host }, timeout)? {
        Presence::Unclear(Heard::Other { host: other, module })
            if u16::from(module) == address && u16::from(other) != host =>
        {
            let host = other.into();
            let presence = probe(client, Parties { module: address, host }, timeout)?;
            return Ok(Some((version(presence), host)));
        }
        presence => presence,
    };
    Ok(match presence {
        Presence::Module(_) | Presence::Silent(_) => Some((version(presence), host)),
        Presence::Nobody | Presence::Unclear(_) => None,
    })
}

/// Asks on behalf of a host that waits for nothing else: a module that does not answer owes nothing.
fn probe(client: &mut AnyClient, parties: Parties, timeout: Duration) -> Result<Presence, ClientError> {
    let settings = parties.within(client.settings());
    client.link_mut().turn_to(parties)?;
    Client::with_settings(client.link_mut(), settings).probe(settings.module_address, timeout)
}

fn version(presence: Presence) -> Option<FirmwareVersion> {
    match presence {
        Presence::Module(version) => Some(version),
        Presence::Silent(_) | Presence::Nobody | Presence::Unclear(_) => None,
    }
}

/// `1-20`, `1,5,7-9`.
fn addresses(text: &str) -> Result<Addresses, String> {
    const EXPECTED: &str = "addresses from 0 to 255 are expected, or identifiers on a CAN bus, up to 0x7FF (2047), such \
                            as 1-20 or 1,5,7-9";
    let mut all = std::collections::BTreeSet::new();
    for part in text.split(',') {
        let (first, last) = part.split_once('-').or_else(|| part.split_once("..=")).unwrap_or((part, part));
        match (connection::address(first.trim()), connection::address(last.trim())) {
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
        assert_eq!(addresses("0x7fe-0x7ff"), Ok(Addresses(vec![0x7FE, 0x7FF])));
        assert_eq!(addresses("1..=255").map(|all| all.0.len()), Ok(255));
        for wrong in ["", "9-7", "1-2048", "a", "1,,2", "-5"] {
            assert!(addresses(wrong).is_err(), "{wrong}");
        }
    }
}
