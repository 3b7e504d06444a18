//! `tmcl restore`: what the EEPROM holds.

use clap::Args;
use serde::Serialize;
use tmcl_config::{Item, items};

use crate::connection::ConnectionOptions;
use crate::exit::{Failures, Outcome};
use crate::parameters::{self, Storage, Which};
use crate::print;

/// `tmcl restore`.
#[derive(Args)]
#[command(
    after_help = "Axis parameters, user variables and coordinates get back what was stored last. Global parameters of bank 0 hold nothing \
    else, since they are stored whenever they are written."
)]
pub(crate) struct Restore {
    /// What to bring back, such as max_velocity, variable.3 or 'max_*'
    #[arg(required_unless_present = "all", conflicts_with = "all", value_name = "NAME")]
    pub(crate) names: Vec<String>,
    /// Bring back everything but what could set the motor moving
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
struct Restored {
    #[serde(flatten)]
    which: Which,
    /// Whether it holds what is stored.
    restored: bool,
}

/// Brings them back.
pub(crate) fn run(options: &Restore) -> Outcome {
    let (mut client, module) = options.connection.connect()?;
    let storable = |item: Item| parameters::storage(item) != Storage::None;
    let chosen: Vec<Item> = if options.all {
        let (moving, chosen): (Vec<_>, Vec<_>) = items(module)
            .filter(|item| parameters::storage(*item) == Storage::Command)
            .partition(|item| item.starts_motion());
        for item in moving {
            print::note(&format!("`{}` is left as it is, since it can set the motor moving", item.name()));
        }
        chosen
    } else {
        let names = parameters::named(&options.names, module, storable, "cannot be stored")?;
        names.iter().map(|name| name.item).collect()
    };
    let mut failures = Failures::default();
    let mut rows = Vec::new();
    for item in chosen {
        if parameters::storage(item) == Storage::Itself {
            print::note(&format!(
                "`{}` is stored whenever it is written, and holds what is stored",
                item.name()
            ));
            rows.push(Restored { which: Which::of(item), restored: true });
            continue;
        }
        let result = parameters::restore(&mut client, item);
        let result = result.map_err(|error| parameters::refused(&item.name(), &error));
        rows.push(Restored { which: Which::of(item), restored: failures.note(result).is_some() });
    }
    if options.json {
        print::json(&rows)?;
    }
    failures.finish()
}
