//! `tmcl get`: what parameters hold.

use clap::Args;
use tmcl_config::described;

use crate::connection::{ConnectionOptions, failure};
use crate::exit::Outcome;
use crate::parameters::{self, Row, unit};
use crate::print;

/// `tmcl get`.
#[derive(Args)]
#[command(
    after_help = "A name is an identifier (max_velocity, timer_0_period), the number of an axis parameter (4 or axis.4), bank \
    and number of a global parameter (0/66), variable.N, coordinate.N, input.N, ain.N or output.N. Bit fields follow behind a \
    dot: encoder_mode.null_active_high. With * and ? a name stands for all that are like it. docs/parameters.md says more."
)]
pub(crate) struct Get {
    /// What to read, such as actual_position, 0/66 or 'max_*'
    #[arg(required = true, value_name = "NAME")]
    pub(crate) names: Vec<String>,
    /// Print only the values, one a line
    #[arg(long, conflicts_with = "json")]
    pub(crate) raw: bool,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) connection: ConnectionOptions,
}

/// Reads and prints them.
pub(crate) fn run(options: &Get) -> Outcome {
    let (mut client, module) = options.connection.connect()?;
    let names = parameters::named(&options.names, module, |item| item.access().read, "can only be written")?;
    let items = names.iter().map(|name| name.item);
    let closed_loop = parameters::closed_loop(&mut client, module, items)?;
    let mut values = Vec::new();
    for name in names {
        let value = parameters::read(&mut client, name.item).map_err(|error| failure(&error))?;
        values.push((name, name.extract(value)));
    }
    if options.json {
        let rows: Vec<_> = values.iter().map(|(name, value)| Row::new(name, *value, closed_loop)).collect();
        return Ok(print::json(&rows)?);
    }
    if options.raw {
        return Ok(print::text(&values.iter().map(|(_, value)| format!("{value}\n")).collect::<String>())?);
    }
    let rows = values.iter().map(|(name, value)| {
        let unit = unit(name, closed_loop).to_owned();
        [name.to_string(), value.to_string(), unit, described(name, *value)]
    });
    Ok(print::text(&print::columns(["name", "value", "unit", "meaning"], Some(1), rows))?)
}
