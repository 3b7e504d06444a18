//! `tmcl diff`: what differs between a configuration file and a module, or between two files.

use std::path::PathBuf;

use clap::Args;
use serde_json::{Value, json};
use tmcl_config::file::Config;
use tmcl_config::{Difference, Item, items};

use crate::connection::ConnectionOptions;
use crate::exit::{Code, Failure, Outcome};
use crate::{parameters, print};

/// `tmcl diff`.
#[derive(Args)]
#[command(
    after_help = "Only what the file names is compared with the module. Exits with 1 if something differs."
)]
pub(crate) struct Diff {
    /// The configuration file; - is stdin
    pub(crate) file: PathBuf,
    /// Another one to compare it with, in place of a module
    pub(crate) other: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) connection: ConnectionOptions,
}

/// What is different: what the one and the other say. A file need not say anything.
type Row = (Item, [Option<i64>; 2]);

/// Compares and prints.
pub(crate) fn run(options: &Diff) -> Outcome {
    let loaded = parameters::load(&options.file)?;
    let (sides, rows) = if let Some(other) = &options.other {
        (["first", "second"], between(&loaded.config, &parameters::load(other)?.config)?)
    } else {
        let (mut client, module) = options.connection.connect()?;
        parameters::belongs_to(&loaded, module)?;
        let differences = parameters::differences(&mut client, &loaded.config)?;
        let row = |Difference { item, file, module }| (item, [Some(file), Some(module)]);
        (["file", "module"], differences.into_iter().map(row).collect())
    };
    if options.json {
        print::json(&rows.iter().map(|row| to_json(row, sides)).collect::<Vec<_>>())?;
    } else if !rows.is_empty() {
        let header = ["name", sides[0], sides[1]];
        print::listing(header, rows.iter().map(cells))?;
    }
    if rows.is_empty() { Ok(()) } else { Err(Code::Findings.into()) }
}

fn cells((item, values): &Row) -> [String; 3] {
    let [one, other] =
        values.map(|value| value.map_or_else(|| "-".to_owned(), |value| parameters::spelled(*item, value)));
    [item.name(), one, other]
}

fn to_json((item, [one, other]): &Row, [left, right]: [&str; 2]) -> Value {
    json!({ "name": item.name(), "number": item.number(), left: one, right: other })
}

/// What two files say differently, or only one of them.
fn between(first: &Config, second: &Config) -> Result<Vec<Row>, Failure> {
    if first.module != second.module {
        let message =
            format!("the first file is for a {}, the second for a {}", first.module.name, second.module.name);
        return Err(Failure::new(Code::Usage, message));
    }
    let value = |config: &Config, item: Item| {
        config.entries.iter().find(|entry| entry.item == item).map(|entry| entry.value)
    };
    let pairs = items(first.module).map(|item| (item, [value(first, item), value(second, item)]));
    Ok(pairs.filter(|(_, [first, second])| first != second).collect())
}
