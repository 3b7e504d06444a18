//! `tmcl store`: keeping parameters in the EEPROM.

use clap::Args;
use serde::Serialize;
use tmcl_config::{Item, items};

use crate::connection::ConnectionOptions;
use crate::exit::{Failures, Outcome};
use crate::parameters::{self, Storage, Which};
use crate::print;

/// `tmcl store`.
#[derive(Args)]
#[command(
    after_help = "Axis parameters, user variables and coordinates are stored as they are now. Global parameters of bank 0 are stored by the \
    module whenever they are written."
)]
pub(crate) struct Store {
    /// What to store, such as max_velocity, variable.3 or 'max_*'
    #[arg(required_unless_present = "all", conflicts_with = "all", value_name = "NAME")]
    pub(crate) names: Vec<String>,
    /// Store everything that can be stored
    #[arg(long)]
    pub(crate) all: bool,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) connection: ConnectionOptions,
}

/// What came of a parameter, as JSON has it.
#[derive(Serialize)]
struct Stored {
    #[serde(flatten)]
    which: Which,
    stored: bool,
}

/// Stores them. What is refused does not keep the others from being stored.
pub(crate) fn run(options: &Store) -> Outcome {
    let (mut client, module) = options.connection.connect()?;
    let storable = |item: Item| parameters::storage(item) != Storage::None;
    let chosen: Vec<Item> = if options.all {
        items(module).filter(|item| parameters::storage(*item) == Storage::Command).collect()
    } else {
        let names = parameters::named(&options.names, module, storable, "cannot be stored")?;
        names.iter().map(|name| name.item).collect()
    };
    let mut failures = Failures::default();
    let mut rows = Vec::new();
    for item in chosen {
        let which = Which::of(item);
        if parameters::storage(item) == Storage::Itself {
            print::note(&format!("`{}` is stored whenever it is written", item.name()));
            rows.push(Stored { which, stored: true });
            continue;
        }
        let result = parameters::store(&mut client, item);
        let result = result.map_err(|error| parameters::refused(&item.name(), &error));
        let stored = failures.note(result).is_some();
        rows.push(Stored { which, stored });
        if !stored && options.all {
            break;
        }
    }
    if options.json {
        print::json(&rows)?;
    }
    failures.finish()
}
