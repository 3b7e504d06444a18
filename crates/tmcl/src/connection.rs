//! Where a module is, as every command that talks to one is told: `--port` and its neighbours.
//!
//! The command line beats the environment, that beats `tmcl.toml`, and that beats what stands here. Each setting is looked up by
//! itself. `docs/host-tools.md` is the reference for people.

mod environment;
mod file;
mod place;

use std::fmt;
use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use tmcl_client::{AnyLink, Client, ClientError, Parties, Settings};
use tmcl_config::connection::{self, ConnectionSettings};
pub(crate) use tmcl_config::connection::{BaudRates, address};
use tmcl_link::Link;
use tmcl_tables::{GlobalParameter, ModuleSpec};

use crate::exit::{Code, Failure};
use place::Place;

/// Where `tmcl serve` listens when nothing is said.
const DEFAULT_PORT: &str = "tcp://127.0.0.1:5311";

/// Where the module is, and how patiently to talk to it; what nobody says is `None`.
#[derive(Args, Clone, Debug, Default, PartialEq, Eq)]
#[command(next_help_heading = "Connection")]
pub(crate) struct ConnectionOptions {
    /// Where the module is: /dev/ttyACM0, COM3, tcp://127.0.0.1:5311, slcan:///dev/ttyACM0, can://can0; virtual:tmcm-1311,
    /// virtual:tmcm-1311@ADDRESS or virtual:BENCH.toml for one in this process [default: tcp://127.0.0.1:5311]
    #[arg(short, long, value_name = "WHERE")]
    pub(crate) port: Option<String>,
    /// Bits per second of a serial port [default: 9600]
    #[arg(long, value_name = "RATE", value_parser = connection::baud_rates)]
    pub(crate) baud: Option<BaudRates>,
    /// The module's address; on CAN its identifier, to 0x7FF [default: 1]
    #[arg(long, value_name = "N", value_parser = connection::address)]
    pub(crate) address: Option<u16>,
    /// The address, or CAN identifier, that it replies to [default: 2]
    #[arg(long, value_name = "N", value_parser = connection::address)]
    pub(crate) host_address: Option<u16>,
    /// How long to wait for a reply: 500ms, 1s [default: 1s]
    #[arg(long, value_name = "TIME", value_parser = connection::timeout)]
    pub(crate) timeout: Option<Duration>,
    /// How often to ask again where that does no harm [default: 2]
    #[arg(long, value_name = "N", value_parser = connection::retries)]
    pub(crate) retries: Option<u32>,
}

/// A client on any kind of link.
pub(crate) type AnyClient = Client<AnyLink>;

impl ConnectionOptions {
    /// Opens the link and asks which module is there.
    pub(crate) fn connect(&self) -> Result<(AnyClient, &'static ModuleSpec), Failure> {
        self.resolve()?.connect()
    }

    /// Looks up what the command line does not say.
    pub(crate) fn resolve(&self) -> Result<Connection, Failure> {
        let environment = environment::read(|name| std::env::var_os(name))?;
        let folder = std::env::current_dir()
            .map_err(|error| Failure::new(Code::Usage, format!("there is no working directory: {error}")))?;
        let file =
            file::find(&folder).map(|path| file::read(&path).map(|layer| (path, layer))).transpose()?;
        Connection::of(self.clone(), environment, file)
    }

    /// This, and where it says nothing, `below`.
    fn over(self, below: Self) -> Self {
        Self {
            port: self.port.or(below.port),
            baud: self.baud.or(below.baud),
            address: self.address.or(below.address),
            host_address: self.host_address.or(below.host_address),
            timeout: self.timeout.or(below.timeout),
            retries: self.retries.or(below.retries),
        }
    }
}

impl From<ConnectionSettings> for ConnectionOptions {
    fn from(settings: ConnectionSettings) -> Self {
        let ConnectionSettings { port, baud, address, host_address, timeout, retries } = settings;
        Self { port, baud, address, host_address, timeout, retries }
    }
}

/// Who named the port.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Origin {
    CommandLine,
    Environment,
    File(PathBuf),
    Default,
}

impl fmt::Display for Origin {
    /// What follows an error about the port.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::CommandLine => Ok(()),
            Self::Environment => f.write_str(" (the environment variable TMCL_PORT names this port)"),
            Self::File(path) => write!(f, " ({} names this port)", path.display()),
            Self::Default => f.write_str(
                "\n\nThat is where `tmcl serve` listens, and nobody named another port: do so with --port, such as \
                 --port /dev/ttyACM0 or --port virtual:tmcm-1311, with TMCL_PORT, or in a file tmcl.toml",
            ),
        }
    }
}

/// Everything that is to be known before a link is opened.
#[derive(Clone, Debug)]
pub(crate) struct Connection {
    place: Place,
    origin: Origin,
    baud: Option<BaudRates>,
    settings: Settings,
    parties: Parties,
    /// Whether anybody said how long to wait.
    timeout_is_given: bool,
}

impl Connection {
    fn of(
        command_line: ConnectionOptions,
        environment: ConnectionOptions,
        file: Option<(PathBuf, ConnectionOptions)>,
    ) -> Result<Self, Failure> {
        let (path, file) = file.unzip();
        let file = file.unwrap_or_default();
        let origin = match path {
            _ if command_line.port.is_some() => Origin::CommandLine,
            _ if environment.port.is_some() => Origin::Environment,
            Some(path) if file.port.is_some() => Origin::File(path),
            _ => Origin::Default,
        };
        let (asked_address, asked_baud) = (command_line.address, command_line.baud.clone());
        let who_says = who_says(&command_line, &environment);
        let all = command_line.over(environment).over(file);
        let place = Place::parse(all.port.as_deref().unwrap_or(DEFAULT_PORT))
            .map_err(|message| Failure::new(Code::Usage, format!("{message}{}", origin.or_nothing())))?;
        let rate = place.baud_rate();
        if let (Some(rate), Some(asked)) =
            (rate, asked_baud.filter(|asked| Some(asked.rates()) != rate.map(|it| vec![it])))
        {
            let port = place.text();
            let message = format!(
                "the port {port} says {rate} bits per second, and --baud {asked}; leave one of them out"
            );
            return Err(Failure::new(Code::Usage, message));
        }
        let settings = Settings::default();
        let parties = Parties {
            // What the notation says of a virtual module is more than what a file says of modules in general.
            module: asked_address
                .or_else(|| place.address().map(u16::from))
                .or(all.address)
                .unwrap_or_else(|| settings.module_address.into()),
            host: all.host_address.unwrap_or_else(|| settings.host_address.into()),
        };
        for (value, name) in [(parties.module, who_says.address), (parties.host, who_says.host_address)] {
            place
                .takes(value)
                .map_err(|message| Failure::new(Code::Usage, format!("in {name}: {message}")))?;
        }
        let settings = parties.within(Settings {
            timeout: all.timeout.unwrap_or(settings.timeout),
            retries: all.retries.unwrap_or(settings.retries),
            ..settings
        });
        let timeout_is_given = all.timeout.is_some();
        Ok(Self { place, origin, baud: all.baud, settings, parties, timeout_is_given })
    }

    /// The port, as it was named.
    pub(crate) fn port(&self) -> &str {
        self.place.text()
    }

    /// Who talks to whom, and how patiently.
    pub(crate) fn settings(&self) -> Settings {
        self.settings
    }

    /// Whether an address can be meant on this kind of port.
    pub(crate) fn takes(&self, address: u16) -> Result<(), String> {
        self.place.takes(address)
    }

    /// Whether somebody said how long to wait.
    pub(crate) fn timeout_is_given(&self) -> bool {
        self.timeout_is_given
    }

    /// Whether time passes only while somebody waits for the module.
    pub(crate) fn is_virtual(&self) -> bool {
        self.place.is_virtual()
    }

    /// The rates to try at a serial port; none where the port has none.
    pub(crate) fn baud_rates(&self) -> Vec<u32> {
        if self.place.wants_baud_rate() {
            self.baud.as_ref().map(BaudRates::rates).unwrap_or_default()
        } else {
            Vec::new()
        }
    }

    /// Opens the link. Nothing is sent yet.
    pub(crate) fn open(&self) -> Result<AnyClient, Failure> {
        let rate = match self.baud_rates().as_slice() {
            [] => None,
            [rate] => Some(*rate),
            _ => {
                let message = "one rate is needed to talk to a module; `tmcl scan` tries several";
                return Err(Failure::new(Code::Usage, format!("in --baud: {message}")));
            }
        };
        self.open_at(rate)
    }

    /// Opens the link at a rate.
    pub(crate) fn open_at(&self, rate: Option<u32>) -> Result<AnyClient, Failure> {
        let link = self.place.open(rate, self.settings, self.parties);
        let link = link.map_err(|failure| failure.and_says(&self.origin.to_string()))?;
        Ok(Client::with_settings(link, self.settings))
    }

    /// Opens the link and asks which module is there.
    pub(crate) fn connect(&self) -> Result<(AnyClient, &'static ModuleSpec), Failure> {
        let mut client = self.open()?;
        let version = client.firmware_version().map_err(|error| told(&client, &error))?;
        let spec = version.module_spec().ok_or_else(|| {
            Failure::new(Code::Connection, format!("there are no tables for what answers here: {version}"))
        })?;
        Ok((client, spec))
    }
}

impl Origin {
    /// As [`fmt::Display`], where the port was somebody's choice.
    fn or_nothing(&self) -> String {
        if *self == Self::Default { String::new() } else { self.to_string() }
    }
}

/// Where an address was said, as an error names it.
struct WhoSays {
    address: &'static str,
    host_address: &'static str,
}

fn who_says(command_line: &ConnectionOptions, environment: &ConnectionOptions) -> WhoSays {
    let of = |it: fn(&ConnectionOptions) -> Option<u16>, names: [&'static str; 3]| match names {
        [option, ..] if it(command_line).is_some() => option,
        [_, variable, _] if it(environment).is_some() => variable,
        [.., key] => key,
    };
    WhoSays {
        address: of(|it| it.address, ["--address", "TMCL_ADDRESS", "`address` of tmcl.toml"]),
        host_address: of(
            |it| it.host_address,
            ["--host-address", "TMCL_HOST_ADDRESS", "`host_address` of tmcl.toml"],
        ),
    }
}

/// Goes on talking to a module whose address was changed by a write that it took.
pub(crate) fn follow(client: &mut AnyClient, bank: u8, number: u8, value: i64) -> Result<(), ClientError> {
    match GlobalParameter::from_address(bank, number) {
        Some(parameter) => Ok(client.follow(parameter, value)?),
        None => Ok(()),
    }
}

/// As [`failure`], with what went over the line.
pub(crate) fn told<L: Link>(client: &Client<L>, error: &ClientError) -> Failure {
    told_with(client, error, "")
}

/// As [`told`], with what there is to say about it.
pub(crate) fn told_with<L: Link>(client: &Client<L>, error: &ClientError, advice: &str) -> Failure {
    let failure = failure(error).and_says(advice);
    match (error, client.last_exchange()) {
        (ClientError::Link(_), _) | (_, None) => failure,
        (_, Some(exchange)) => failure.and_says(&format!("\n{exchange}")),
    }
}

/// How a command ends when the module does not do what it is asked.
pub(crate) fn failure(error: &ClientError) -> Failure {
    let code = match error {
        ClientError::Link(_) | ClientError::NoReply { .. } => Code::Connection,
        ClientError::Download { source, .. } | ClientError::DownloadEnd { source, .. } => {
            return Failure::new(failure(source).code(), error.to_string());
        }
        ClientError::Differs { .. } => Code::Findings,
        ClientError::Status { .. }
        | ClientError::UnknownStatus { .. }
        | ClientError::Stored { .. }
        | ClientError::Meaningless { .. }
        | ClientError::Executed { .. }
        | ClientError::NotStorable { .. } => Code::TmclStatus,
    };
    Failure::new(code, error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn port(name: &str) -> ConnectionOptions {
        ConnectionOptions { port: Some(name.to_owned()), ..ConnectionOptions::default() }
    }

    fn of(
        command_line: ConnectionOptions,
        environment: ConnectionOptions,
        file: ConnectionOptions,
    ) -> Connection {
        Connection::of(command_line, environment, Some((PathBuf::from("tmcl.toml"), file)))
            .expect("it is in order")
    }

    #[test]
    fn the_command_line_beats_the_environment_and_that_the_file() {
        let none = ConnectionOptions::default;
        let (a, b, c) = (|| port("tcp://a:1"), || port("tcp://b:2"), || port("tcp://c:3"));
        let found = |connection: Connection| (connection.port().to_owned(), connection.origin);
        assert_eq!(found(of(a(), b(), c())), ("tcp://a:1".to_owned(), Origin::CommandLine));
        assert_eq!(found(of(none(), b(), c())), ("tcp://b:2".to_owned(), Origin::Environment));
        let file = Origin::File(PathBuf::from("tmcl.toml"));
        assert_eq!(found(of(none(), none(), c())), ("tcp://c:3".to_owned(), file));
        assert_eq!(found(of(none(), none(), none())), (DEFAULT_PORT.to_owned(), Origin::Default));
    }

    #[test]
    fn each_setting_is_looked_up_by_itself() {
        let command_line = ConnectionOptions { address: Some(5), ..port("tcp://a:1") };
        let environment = ConnectionOptions { address: Some(6), retries: Some(0), ..port("tcp://b:2") };
        let file =
            ConnectionOptions { host_address: Some(9), retries: Some(7), ..ConnectionOptions::default() };
        let settings = of(command_line, environment, file).settings();
        let expected = Settings { module_address: 5, host_address: 9, retries: 0, ..Settings::default() };
        assert_eq!(settings, expected);
    }

    /// Whoever says it is named.
    #[test]
    fn identifiers_beyond_a_byte_are_for_can() {
        let asked = |port: &str, options: ConnectionOptions| {
            let options = ConnectionOptions { port: Some(port.to_owned()), ..options };
            Connection::of(options, ConnectionOptions::default(), None)
        };
        let address = || ConnectionOptions { address: Some(0x304), ..ConnectionOptions::default() };
        let host = || ConnectionOptions { host_address: Some(0x7FF), ..ConnectionOptions::default() };
        let both = ConnectionOptions { host_address: Some(0x7FF), ..address() };
        let found = asked("can://can0", both).expect("a bus takes both");
        assert_eq!(found.parties, Parties { module: 0x304, host: 0x7FF });
        assert_eq!((found.settings.module_address, found.settings.host_address), (4, 0xFF));
        let error =
            |port, options| asked(port, options).expect_err("a line takes a byte").message().to_owned();
        assert_eq!(
            error("/dev/ttyUSB0", address()),
            "in --address: 772 is too large for /dev/ttyUSB0, which takes 0 to 255; a CAN bus takes more"
        );
        assert!(
            error("tcp://a:1", host()).starts_with("in --host-address: 2047 is too large for tcp://a:1,")
        );
        let says = |environment, file| {
            let found = Connection::of(port("tcp://a:1"), environment, Some((PathBuf::new(), file)));
            found.expect_err("a line takes a byte").message().split(':').next().map(str::to_owned)
        };
        let none = ConnectionOptions::default;
        assert_eq!(says(address(), none()).as_deref(), Some("in TMCL_ADDRESS"));
        assert_eq!(says(none(), host()).as_deref(), Some("in `host_address` of tmcl.toml"));
    }

    #[test]
    fn a_virtual_module_is_talked_to_at_its_own_address() {
        let file = || ConnectionOptions { address: Some(9), ..ConnectionOptions::default() };
        let none = ConnectionOptions::default;
        let address = |connection: Connection| connection.settings().module_address;
        assert_eq!(address(of(port("virtual:tmcm-1311@5"), none(), file())), 5);
        assert_eq!(address(of(port("virtual:tmcm-1311"), none(), file())), 1);
        assert_eq!(address(of(port("tcp://a:1"), none(), file())), 9);
        let asked = ConnectionOptions { address: Some(7), ..port("virtual:tmcm-1311@5") };
        assert_eq!(address(of(asked, none(), file())), 7);
    }
}
