//! `tmcl store`: keeping parameters in the EEPROM.

use clap::Args;
use tmcl_config::{Item, items};

use crate::connection::ConnectionOptions;
use crate::exit::{Failures, Outcome};
use crate::parameters::{self, Storage};
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
    #[command(flatten)]
    pub(crate) connection: ConnectionOptions,
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
    for item in chosen {
        if parameters::storage(item) == Storage::Itself {
            print::note(&format!("`{}` is stored whenever it is written", item.name()));
            continue;
        }
        let stored = parameters::store(&mut client, item);
        if failures.note(stored.map_err(|error| parameters::refused(&item.name(), &error))).is_none()
            && options.all
        {
            break;
        }
    }
    failures.finish()
}
