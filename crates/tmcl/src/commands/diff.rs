//! `tmcl diff`: what differs between a configuration file and a module, or between two files.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;
use tmcl_config::Item;
use tmcl_config::file::Config;

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

/// What is different. A file need not say everything.
#[derive(Serialize)]
struct Row {
    name: String,
    number: String,
    file: Option<i64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    module: Option<i64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    other: Option<i64>,
    #[serde(skip)]
    cells: [String; 2],
}

/// Compares and prints.
pub(crate) fn run(options: &Diff) -> Outcome {
    let loaded = parameters::load(&options.file)?;
    let rows: Vec<Row> = match &options.other {
        Some(other) => {
            let other = parameters::load(other)?;
            between(&loaded.config, &other.config)?
        }
        None => {
            let (mut client, module) = options.connection.connect()?;
            parameters::belongs_to(&loaded, module)?;
            let differences = parameters::differences(&mut client, &loaded.config)?;
            let rows = differences.iter().map(|found| row(found.item, Some(found.file), Some(found.module)));
            rows.collect()
        }
    };
    if options.json {
        print::json(&rows)?;
    } else if !rows.is_empty() {
        let cells = rows.iter().map(|row| {
            let [file, module] = row.cells.clone();
            [row.name.clone(), file, module]
        });
        let header =
            if options.other.is_some() { ["name", "first", "second"] } else { ["name", "file", "module"] };
        print::text(&parameters::to_text(&parameters::columns(header, usize::MAX, cells)))?;
    }
    if rows.is_empty() { Ok(()) } else { Err(Code::Findings.into()) }
}

fn row(item: Item, file: Option<i64>, module: Option<i64>) -> Row {
    let cell =
        |value: Option<i64>| value.map_or_else(|| "-".to_owned(), |value| parameters::spelled(item, value));
    Row {
        name: item.name(),
        number: item.number(),
        file,
        module,
        other: None,
        cells: [cell(file), cell(module)],
    }
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
    let pairs = tmcl_config::items(first.module).map(|item| (item, value(first, item), value(second, item)));
    let rows = pairs.filter(|(_, first, second)| first != second).map(|(item, first, second)| Row {
        module: None,
        other: second,
        ..row(item, first, second)
    });
    Ok(rows.collect())
}
