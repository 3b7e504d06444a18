//! Which lines `tmcl serve` connects the modules to, and what is wrong with them.

use tmcl_tables::GlobalParameter;
use virtual_bench::config::{Interface, ModuleConfig};
use virtual_bench::{Bench, BenchConfig, PORTS, Wiring};

use crate::arguments::{Baud, Serve};
use crate::exit::{Code, Failure};
use crate::{print, virtual_link};

/// The rate of a terminal that nobody has set, as of a module that nobody has.
const DEFAULT_BAUD: u32 = 9600;

/// How the modules are connected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Lines {
    /// What --tcp and --pty are.
    pub(super) serial: Wiring,
    /// Whether there is a CAN bus.
    pub(super) can: bool,
}

impl Lines {
    /// What the options say of these modules.
    pub(super) fn of(options: &Serve, config: &BenchConfig) -> Result<Self, Failure> {
        let can = !options.slcan.is_empty() || !options.can.is_empty();
        let serial_is_used = !options.tcp.is_empty() || !options.pty.is_empty();
        check_ports(options)?;
        if can {
            check_can(&config.modules)?;
        }
        let several = config.modules.len() > 1;
        if can && serial_is_used && (several || options.baud.is_some()) {
            return Err(usage(
                "modules are on RS485 (--tcp, --pty) or on CAN (--slcan, --can), as GP 88 says; only a single module \
                 without --baud can be at both, as if by USB",
            ));
        }
        if can && options.baud.is_some() {
            return Err(usage("--baud is the rate of RS485; that of a CAN bus is set by the host"));
        }
        if options.baud == Some(Baud::Auto) && (!options.tcp.is_empty() || options.pty.is_empty()) {
            return Err(usage(
                "--baud auto follows the program at a --pty; a TCP client has no rate to follow",
            ));
        }
        let baud = options.baud.map(|baud| match baud {
            Baud::Auto => DEFAULT_BAUD,
            Baud::Fixed(baud) => baud,
        });
        let is_bus = several || baud.is_some();
        Ok(Self { serial: if is_bus { Wiring::Rs485 { baud } } else { Wiring::Usb }, can })
    }

    /// The interface that the modules are preset to.
    pub(super) fn interface(self) -> Option<Interface> {
        match self.serial {
            _ if self.can => Some(Interface::Can),
            Wiring::Rs485 { .. } => Some(Interface::Rs485),
            Wiring::Usb | Wiring::Can { .. } => None,
        }
    }

    /// The baud rate of a serial line, where it has one.
    pub(super) fn baud(self) -> Option<u32> {
        match self.serial {
            Wiring::Rs485 { baud } => baud,
            Wiring::Usb | Wiring::Can { .. } => None,
        }
    }

    /// Says what is likely to go wrong between these modules.
    pub(super) fn warn(self, bench: &Bench, config: &BenchConfig, follows_terminal: bool) {
        let (address, host) = match self.can {
            true => (GlobalParameter::CanId, GlobalParameter::CanReplyId),
            false => (GlobalParameter::SerialAddress, GlobalParameter::HostAddress),
        };
        let members: Vec<_> = bench
            .modules()
            .zip(&config.modules)
            .map(|(id, module)| Member {
                name: &module.name,
                address: virtual_link::address(bench, id, address),
                host: virtual_link::address(bench, id, host),
            })
            .collect();
        for (index, member) in members.iter().enumerate() {
            self.warn_of_twins(member, members.get(index + 1..).unwrap_or_default());
        }
        if let Some(confused) =
            members.iter().find(|member| members.iter().any(|other| other.takes_replies_for(member)))
        {
            self.warn_of_replies(confused, config.bus.modules_hear_replies);
        }
        if let Some(baud) = self.baud().filter(|_| !follows_terminal) {
            for (id, module) in bench.modules().zip(&config.modules) {
                warn_of_rate(&module.name, bench.baud_rate(id), baud);
            }
        }
    }

    /// The first of those behind it with the same address.
    fn warn_of_twins(self, member: &Member<'_>, others: &[Member<'_>]) {
        if let Some(twin) = others.iter().find(|other| other.address == member.address) {
            let what = self.address_word();
            let happens = match self.can {
                true => "both answer every request",
                false => "both answer at once, and the host understands neither",
            };
            let (name, twin, address) = (member.name, twin.name, member.address);
            print::note(&format!("{name} and {twin} have the same {what} {address}: {happens}"));
        }
    }

    fn warn_of_replies(self, member: &Member<'_>, hear_replies: bool) {
        let what = self.address_word();
        let (bus, will) = match (self.can, hear_replies) {
            (_, true) => ("on this bus", "takes"),
            (true, false) => ("on a real CAN bus", "would take"),
            (false, false) => ("on a two-wire bus", "would take"),
        };
        let (name, address) = (member.name, member.address);
        print::note(&format!(
            "{bus} {name} ({what} {address}) {will} other modules' replies to host {address} for requests"
        ));
    }

    fn address_word(self) -> &'static str {
        if self.can { "CAN ID" } else { "address" }
    }
}

/// A module on the bus.
struct Member<'m> {
    name: &'m str,
    address: u8,
    /// Where its replies go.
    host: u8,
}

impl Member<'_> {
    /// Whether replies of this module to its host reach `other` by its address.
    fn takes_replies_for(&self, other: &Member<'_>) -> bool {
        self.name != other.name && self.host == other.address
    }
}

fn warn_of_rate(name: &str, module: Option<u32>, line: u32) {
    if let Some(module) = module.filter(|module| *module != line) {
        print::note(&format!("{name} is at {module} baud (GP 65), the line at {line}: it hears nothing"));
    }
}

/// Each pseudo terminal and CAN bus holds a port of the modules, and TCP clients want one too.
fn check_ports(options: &Serve) -> Result<(), Failure> {
    let held = options.pty.len() + options.slcan.len() + options.can.len();
    if held + usize::from(!options.tcp.is_empty()) > PORTS {
        return Err(usage(&format!(
            "a module has {PORTS} ports: each --pty, --slcan and --can holds one, and --tcp needs one for its clients"
        )));
    }
    Ok(())
}

fn check_can(modules: &[ModuleConfig]) -> Result<(), Failure> {
    let (bank, number) = GlobalParameter::CanId.address();
    let without = modules.iter().find(|module| module.kind.spec().global_parameter(bank, number).is_none());
    match without {
        None => Ok(()),
        Some(module) => {
            let message = format!(
                "{} is a {}, which has no CAN: --slcan and --can are for modules that have, such as the TMCM-1311",
                module.name,
                module.kind.spec().name
            );
            Err(usage(&message))
        }
    }
}

fn usage(message: &str) -> Failure {
    Failure::new(Code::Usage, message)
}
