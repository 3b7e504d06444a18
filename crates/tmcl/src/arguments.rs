//! The command line, from which completions and man pages are made too.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use tmcl_tables::ModuleSpec;

use crate::module_name;

#[derive(Parser)]
#[command(
    name = "tmcl",
    version,
    about = "The open implementation of TMCL, the Trinamic Motion Control Language"
)]
#[command(
    after_help = "Exit codes: 0 ok, 1 findings or failed expectation, 2 usage, 3 connection, 4 TMCL error status, \
    42 timeout."
)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Subcommand)]
pub(crate) enum Command {
    /// Run a virtual module on TCP ports and pseudo terminals
    Serve(Serve),
    /// List the modules
    Modules(Modules),
    /// List a module's axis and global parameters
    Params(Params),
    /// List a module's commands
    Commands(Commands),
    /// Print a shell's completion script
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// Print the man page, or write all of them to a folder
    Man {
        /// The folder to write `tmcl.1`, `tmcl-serve.1`, … to
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
    },
}

/// `tmcl serve`.
#[derive(Args)]
#[command(
    after_help = "Without --tcp and --pty it listens at 127.0.0.1:5311. A module has four ports: each pseudo terminal \
    holds one, each TCP client holds one while it stays. SIGINT and SIGTERM end it."
)]
pub(crate) struct Serve {
    /// The module, and its serial address where it is not to be 1
    #[arg(value_name = "MODULE[@ADDRESS]", value_parser = module_name::setup)]
    pub(crate) module: module_name::VirtualModule,
    /// Listen here; port 0 picks a free one, no host means 127.0.0.1; may be given several times
    #[arg(long, value_name = "HOST:PORT", value_parser = tcp_address)]
    pub(crate) tcp: Vec<String>,
    /// Open a pseudo terminal and link PATH to it; may be given several times
    #[arg(long, value_name = "PATH")]
    pub(crate) pty: Vec<PathBuf>,
    /// How fast virtual time runs, 1 being real time
    #[arg(long, value_name = "FACTOR", default_value = "1", value_parser = speed)]
    pub(crate) speed: f64,
}

/// `tmcl modules`.
#[derive(Args)]
pub(crate) struct Modules {
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// `tmcl params`.
#[derive(Args)]
pub(crate) struct Params {
    /// The module
    #[arg(value_parser = module_name::spec)]
    pub(crate) module: &'static ModuleSpec,
    /// Only the axis parameters
    #[arg(long, conflicts_with = "bank")]
    pub(crate) axis: bool,
    /// Only the global parameters of this bank
    #[arg(long, value_name = "N")]
    pub(crate) bank: Option<u8>,
    #[command(flatten)]
    pub(crate) format: Format,
}

/// `tmcl commands`.
#[derive(Args)]
pub(crate) struct Commands {
    /// The module
    #[arg(value_parser = module_name::spec)]
    pub(crate) module: &'static ModuleSpec,
    #[command(flatten)]
    pub(crate) format: Format,
}

/// How tables are printed; as columns when nothing is said.
#[derive(Args)]
#[group(multiple = false)]
pub(crate) struct Format {
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Print Markdown, with everything the tables say
    #[arg(long)]
    pub(crate) markdown: bool,
}

fn tcp_address(text: &str) -> Result<String, String> {
    let (host, port) = text.rsplit_once(':').unwrap_or(("127.0.0.1", text));
    match port.parse::<u16>() {
        Ok(port) if !host.is_empty() => Ok(format!("{host}:{port}")),
        _ => Err("a host and a port from 0 to 65535 are expected, such as 127.0.0.1:5311".to_owned()),
    }
}

fn speed(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(speed) if speed.is_finite() && speed > 0.0 => Ok(speed),
        _ => Err("a positive number is expected, such as 1, 0.1 or 20".to_owned()),
    }
}
