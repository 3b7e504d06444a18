//! `tmcl dump`: the configuration of a module as a text.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;
use tmcl_config::file::{self, Header};
use tmcl_config::{Item, Name, items};
use tmcl_tables::Role;

use crate::connection::{ConnectionOptions, failure};
use crate::exit::{Code, Failure, Outcome};
use crate::parameters::{self, Row};
use crate::print;

/// Who writes configuration files.
pub(crate) const WRITER: &str = concat!("tmcl ", env!("CARGO_PKG_VERSION"));

/// `tmcl dump`.
#[derive(Args)]
#[command(
    after_help = "A configuration is what can be read and written, and is neither a measurement nor a command: settings, \
    addresses, locks, user variables 0 to 55, and coordinates. Without names it is all of it."
)]
pub(crate) struct Dump {
    /// Only these, such as 'max_*'
    #[arg(value_name = "NAME")]
    pub(crate) names: Vec<String>,
    /// Write it to a file
    #[arg(short, long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    /// Print JSON; a file is written as ever
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) connection: ConnectionOptions,
}

/// The configuration, as JSON has it.
#[derive(Serialize)]
struct Report {
    module: &'static str,
    firmware: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    file: Option<String>,
    parameters: Vec<Row>,
}

/// Reads and prints it.
pub(crate) fn run(options: &Dump) -> Outcome {
    let (mut client, module) = options.connection.connect()?;
    let version = client.firmware_version().map_err(|error| failure(&error))?;
    let chosen: Vec<Item> = if options.names.is_empty() {
        items(module).filter(|item| is_shown(*item)).collect()
    } else {
        let names = parameters::named(&options.names, module, is_shown, "is no part of a configuration")?;
        items(module).filter(|item| names.iter().any(|name| name.item == *item)).collect()
    };
    let closed_loop = parameters::closed_loop(&mut client, module, chosen.iter().copied())?;
    let values = parameters::read_all(&mut client, chosen)?;
    let header = Header { module, firmware: (version.major, version.minor), writer: WRITER };
    let text = file::write(header, &values);
    if let Some(path) = &options.out {
        std::fs::write(path, text).map_err(|error| {
            Failure::new(Code::Usage, format!("cannot write {}: {error}", path.display()))
        })?;
    } else if !options.json {
        return Ok(print::text(&text)?);
    }
    if options.json {
        print::json(&Report {
            module: module.id,
            firmware: format!("V{}.{:02}", version.major, version.minor),
            file: options.out.as_ref().map(|path| path.display().to_string()),
            parameters: values
                .iter()
                .map(|&(item, value)| Row::new(&Name::of(item), value, closed_loop))
                .collect(),
        })?;
    }
    Ok(())
}

/// What stands in a file, if only in a comment.
pub(crate) fn is_shown(item: Item) -> bool {
    item.is_configuration() || item.role() == Role::Setting
}
