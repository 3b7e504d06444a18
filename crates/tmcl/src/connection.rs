//! Where a module is, as every command that talks to one is told: `--port` and its neighbours.

use std::time::Duration;

use clap::Args;
use tmcl_client::{Client, ClientError, Settings};
use tmcl_link::Link;
use tmcl_tables::ModuleSpec;
use virtual_bench::{Bench, BenchConfig, ModuleId};

use crate::exit::{Code, Failure};
use crate::module_name;
use crate::virtual_link::VirtualLink;

/// What stands before the name of a module that is to run in this process.
const VIRTUAL: &str = "virtual:";

/// Where the module is, and how patiently to talk to it.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Connection")]
pub(crate) struct ConnectionOptions {
    /// Where the module is: /dev/ttyACM0, COM3, tcp://127.0.0.1:5311, or virtual:tmcm-1311 for one in this process
    #[arg(short, long, value_name = "WHERE", default_value = "tcp://127.0.0.1:5311")]
    pub(crate) port: String,
    /// The module's address
    #[arg(long, value_name = "N", default_value = "1")]
    pub(crate) address: u8,
    /// The address that the module sends its replies to
    #[arg(long, value_name = "N", default_value = "2")]
    pub(crate) host_address: u8,
    /// How long to wait for a reply, in milliseconds
    #[arg(long, value_name = "MS", default_value = "1000")]
    pub(crate) timeout: u32,
    /// How often to ask again where that does no harm
    #[arg(long, value_name = "N", default_value = "2")]
    pub(crate) retries: u32,
}

/// A client on any kind of link.
pub(crate) type AnyClient = Client<Box<dyn Link>>;

impl ConnectionOptions {
    /// Opens the link. Nothing is sent yet.
    pub(crate) fn open(&self) -> Result<AnyClient, Failure> {
        let link = match self.port.strip_prefix(VIRTUAL) {
            Some(module) => virtual_module(module)?,
            None => tmcl_link::open(&self.port)
                .map_err(|error| Failure::new(Code::Connection, error.to_string()))?,
        };
        let settings = Settings {
            module_address: self.address,
            host_address: self.host_address,
            timeout: Duration::from_millis(self.timeout.into()),
            retries: self.retries,
        };
        Ok(Client::with_settings(link, settings))
    }

    /// Opens the link and asks which module is there.
    pub(crate) fn connect(&self) -> Result<(AnyClient, &'static ModuleSpec), Failure> {
        let mut client = self.open()?;
        let version = client.firmware_version().map_err(|error| failure(&error))?;
        let spec = version.module_spec().ok_or_else(|| {
            Failure::new(Code::Connection, format!("there are no tables for what answers here: {version}"))
        })?;
        Ok((client, spec))
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

fn virtual_module(name: &str) -> Result<Box<dyn Link>, Failure> {
    let module = module_name::setup(name)
        .map_err(|error| Failure::new(Code::Usage, format!("in --port {VIRTUAL}{name}: {error}")))?;
    let mut config = BenchConfig::default_for(module.kind);
    if let Some(first) = config.modules.first_mut() {
        first.address = module.address;
    }
    Ok(Box::new(VirtualLink::new(Bench::new(&config), ModuleId(0))))
}
