//! The notation of `--port`.

use std::path::{Path, PathBuf};

use tmcl_client::{AnyLink, Client, OpenOptions, Parties, Settings};
use tmcl_link::can::MAX_ID;
use tmcl_link::{AddressError, LinkAddress, Speeds};
use tmcl_tables::GlobalParameter;
use virtual_bench::config::ModuleConfig;
use virtual_bench::{Bench, BenchConfig, ModuleId};

use crate::bench_file;
use crate::exit::{Code, Failure};
use crate::module_name;
use crate::virtual_link::VirtualLink;

/// What stands before a module that is to run in this process.
pub(super) const VIRTUAL: &str = "virtual:";

/// How long a virtual module has been switched on when it is talked to: its first measurements are done.
const POWER_ON_NS: u64 = 10_000_000;

/// Where a module is.
#[derive(Clone, Debug)]
pub(super) struct Place {
    text: String,
    kind: Kind,
}

#[derive(Clone, Debug)]
enum Kind {
    /// Behind something that the client opens.
    Link(LinkAddress),
    /// On a bench in this process.
    Virtual(Box<Virtual>),
}

#[derive(Clone, Debug)]
struct Virtual {
    config: BenchConfig,
    module: usize,
}

/// Whether what follows `virtual:` names a bench file.
pub(super) fn is_bench(text: &str) -> bool {
    let (file, _) = split_bench(text);
    Path::new(file).extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"))
        || file.contains(['/', '\\'])
}

/// `FILE.toml#NAME`; the file itself may have a `#` in its name.
fn split_bench(text: &str) -> (&str, Option<&str>) {
    match text.rsplit_once('#') {
        Some((file, name)) if !name.contains(['/', '\\', '.']) => (file, Some(name)),
        _ => (text, None),
    }
}

impl Place {
    /// Understands the notation; a bench file is read at once.
    pub(super) fn parse(text: &str) -> Result<Self, String> {
        let kind = match text.strip_prefix(VIRTUAL) {
            Some(rest) if is_bench(rest) => Kind::Virtual(Box::new(on_bench(rest)?)),
            Some(rest) => {
                Kind::Virtual(Box::new(alone(rest).map_err(|error| format!("in the port {text}: {error}"))?))
            }
            None => Kind::Link(text.parse().map_err(in_words)?),
        };
        Ok(Self { text: text.to_owned(), kind })
    }

    pub(super) fn text(&self) -> &str {
        &self.text
    }

    pub(super) fn is_virtual(&self) -> bool {
        matches!(self.kind, Kind::Virtual(_))
    }

    /// Whether `--baud` means something here, and the notation does not say it already.
    pub(super) fn wants_baud_rate(&self) -> bool {
        matches!(
            self.kind,
            Kind::Link(LinkAddress::Serial { baud_rate: None, .. } | LinkAddress::Slcan { .. })
        )
    }

    /// The rate that the notation says.
    pub(super) fn baud_rate(&self) -> Option<u32> {
        match self.kind {
            Kind::Link(LinkAddress::Serial { baud_rate, .. }) => baud_rate,
            _ => None,
        }
    }

    /// The address of a virtual module.
    pub(super) fn address(&self) -> Option<u8> {
        let Kind::Virtual(place) = &self.kind else { return None };
        place.config.modules.get(place.module).map(address)
    }

    /// Whether an address can be meant there: on a CAN bus it is an identifier.
    pub(super) fn takes(&self, address: u16) -> Result<(), String> {
        let is_can = matches!(&self.kind, Kind::Link(address) if address.is_can());
        let most = if is_can { MAX_ID } else { u8::MAX.into() };
        if address <= most {
            return Ok(());
        }
        let text = &self.text;
        Err(format!("{address} is too large for {text}, which takes 0 to {most}; a CAN bus takes more"))
    }

    /// Opens the link. A rate that the notation says is not said again.
    pub(super) fn open(
        &self,
        rate: Option<u32>,
        settings: Settings,
        parties: Parties,
    ) -> Result<AnyLink, Failure> {
        match &self.kind {
            Kind::Virtual(place) => {
                let mut bench = Bench::new(&place.config);
                bench.advance_by(POWER_ON_NS);
                Ok(AnyLink::Bytes(Box::new(VirtualLink::new(bench, ModuleId(place.module)))))
            }
            Kind::Link(address) => {
                let speeds = Speeds { baud_rate: rate, can_bit_rate: None };
                let options = OpenOptions { settings, speeds, can: parties.ids() };
                tmcl_client::open(&address.to_string(), options)
                    .map(Client::into_link)
                    .map_err(|error| Failure::new(Code::Connection, error.to_string()))
            }
        }
    }
}

fn in_words(error: AddressError) -> String {
    match error {
        AddressError::Form(_) => format!("{error}, or virtual:tmcm-1311 for a module in this process"),
        error => error.to_string(),
    }
}

fn alone(name: &str) -> Result<Virtual, module_name::NameError> {
    let module = module_name::setup(name)?;
    let mut config = BenchConfig::default_for(module.kind);
    if let Some(first) = config.modules.first_mut() {
        first.address = module.address;
    }
    Ok(Virtual { config, module: 0 })
}

fn on_bench(text: &str) -> Result<Virtual, String> {
    let (file, name) = split_bench(text);
    let config =
        bench_file::load(None, Some(&PathBuf::from(file))).map_err(|failure| failure.message().to_owned())?;
    let Some(name) = name else { return Ok(Virtual { config, module: 0 }) };
    let names: Vec<&str> = config.modules.iter().map(|module| module.name.as_str()).collect();
    match names.iter().position(|known| *known == name) {
        Some(module) => Ok(Virtual { config, module }),
        None => Err(format!("there is no module `{name}` in {file}; there are {}", names.join(", "))),
    }
}

/// What it is set to, or else what it comes from the factory with.
fn address(module: &ModuleConfig) -> u8 {
    let (bank, number) = GlobalParameter::SerialAddress.address();
    let factory =
        module.kind.spec().global_parameter(bank, number).map_or(1, |entry| entry.parameter.default);
    module.address.unwrap_or_else(|| u8::try_from(factory).unwrap_or(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn benches_and_modules_are_told_apart() {
        for bench in ["lift.toml", "./lift", "../lift.toml#m2", r"C:\lift.TOML", "a#b.toml"] {
            assert!(is_bench(bench), "{bench}");
        }
        for module in ["tmcm-1311", "1311@5", "tmcm-1640#x"] {
            assert!(!is_bench(module), "{module}");
        }
        assert_eq!(split_bench("a#b.toml"), ("a#b.toml", None));
        assert_eq!(split_bench("a#b.toml#m1"), ("a#b.toml", Some("m1")));
    }

    #[test]
    fn a_rate_belongs_to_a_serial_port_that_says_none() {
        let wants_baud_rate = |text: &str| Place::parse(text).expect("it is a place").wants_baud_rate();
        assert!(wants_baud_rate("/dev/ttyUSB0"));
        assert!(wants_baud_rate("COM3"));
        assert!(!wants_baud_rate("/dev/ttyUSB0@115200"));
        assert!(wants_baud_rate("slcan:///dev/ttyACM0@500000"), "the adapter's port has one too");
        assert!(!wants_baud_rate("can://can0"));
        assert!(!wants_baud_rate("tcp://localhost:5311"));
        assert!(!wants_baud_rate("localhost:5311"));
        assert!(!wants_baud_rate("virtual:tmcm-1311"));
    }

    #[test]
    fn what_is_no_place_is_refused() {
        let error = |text: &str| Place::parse(text).expect_err("it is no place");
        assert!(error("module").contains("is no address of a module"), "{}", error("module"));
        assert_eq!(
            error("virtual:tmcm-1312"),
            "in the port virtual:tmcm-1312: no such module; there are tmcm-1076, tmcm-1311, tmcm-1640"
        );
        assert!(error("virtual:nothing.toml").starts_with("cannot read the bench file nothing.toml: "));
    }
}
