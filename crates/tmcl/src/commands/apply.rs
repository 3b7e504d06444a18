//! `tmcl apply`: bringing a configuration file into a module.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;
use tmcl_config::{Difference, Item, Left, Plan, Wishes, plan};

use crate::connection::ConnectionOptions;
use crate::exit::{Code, Failure, Failures, Outcome};
use crate::parameters::{self, Progress, Which, spelled};
use crate::print;

/// `tmcl apply`.
#[derive(Args)]
#[command(
    after_help = "The whole file is checked before anything is written. Only what differs is written, addresses and locks \
    last, and everything is read back. Nothing that could set the motor moving is written, and no lock is taken away. Exits \
    with 1 if the module holds something else in the end."
)]
pub(crate) struct Apply {
    /// The configuration file; - is stdin
    pub(crate) file: PathBuf,
    /// Store it in the EEPROM too
    #[arg(long)]
    pub(crate) store: bool,
    /// Write addresses, baud rates and whatever else the module is reached by, too
    #[arg(long = "connection")]
    pub(crate) connection_parameters: bool,
    /// Only say what would be written
    #[arg(long)]
    pub(crate) dry_run: bool,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) connection: ConnectionOptions,
}

/// Brings it in, and says what came of it.
pub(crate) fn run(options: &Apply) -> Outcome {
    let loaded = parameters::load(&options.file)?;
    let (mut client, module) = options.connection.connect()?;
    parameters::belongs_to(&loaded, module)?;
    let version = client.firmware_version().map_err(|error| crate::connection::failure(&error))?;
    let (major, minor) = (version.major, version.minor);
    if let Some(firmware) = loaded.config.firmware.as_deref()
        && firmware != format!("{major}.{minor:02}")
    {
        print::note(&format!(
            "the file is from firmware V{firmware}, and the module has V{major}.{minor:02}"
        ));
    }
    let wishes = Wishes { connection: options.connection_parameters };
    let mut progress = Progress::default();
    let outcome = if options.dry_run {
        let Plan { writes, left } = plan(&parameters::differences(&mut client, &loaded.config)?, wishes);
        progress.written = writes.into_iter().map(|(_, difference)| difference).collect();
        progress.left = left;
        Ok(())
    } else {
        parameters::apply(&mut client, &loaded.config, wishes, options.store, &mut progress)
    };
    if options.json {
        print::json(&Report::of(&progress, options.dry_run))?;
    } else {
        print_written(&progress.written)?;
    }
    say_left(&progress.left);
    conclude(progress, outcome)
}

/// What came of it, as JSON has it.
#[derive(Serialize)]
struct Report {
    /// Whether nothing was written, and `written` is what would be.
    dry_run: bool,
    written: Vec<Change>,
    left: Vec<LeftOut>,
    refused: Vec<Refusal>,
    mismatches: Vec<Mismatch>,
    unheard: Vec<Which>,
    /// How many parameters were stored.
    stored: usize,
}

/// What was written.
#[derive(Serialize)]
struct Change {
    #[serde(flatten)]
    which: Which,
    before: i64,
    after: i64,
}

/// What was not to be written.
#[derive(Serialize)]
struct LeftOut {
    #[serde(flatten)]
    mismatch: Mismatch,
    why: &'static str,
}

/// What the module refused.
#[derive(Serialize)]
struct Refusal {
    #[serde(flatten)]
    which: Which,
    error: String,
}

/// What the file says and what the module holds, as `tmcl diff` has it.
#[derive(Serialize)]
struct Mismatch {
    #[serde(flatten)]
    which: Which,
    file: i64,
    module: i64,
}

impl Report {
    fn of(progress: &Progress, dry_run: bool) -> Self {
        let change = |&Difference { item, file, module }: &Difference| Change {
            which: Which::of(item),
            before: module,
            after: file,
        };
        let left = |(left, Difference { item, file, module }): &(Left, Difference)| LeftOut {
            mismatch: Mismatch { which: Which::of(*item), file: *file, module: *module },
            why: why(*left),
        };
        let refusal = |(item, failure): &(Item, Failure)| Refusal {
            which: Which::of(*item),
            error: failure.message().to_owned(),
        };
        let mismatch =
            |&(item, file, module): &(Item, i64, i64)| Mismatch { which: Which::of(item), file, module };
        Self {
            dry_run,
            written: progress.written.iter().map(change).collect(),
            left: progress.left.iter().map(left).collect(),
            refused: progress.refused.iter().map(refusal).collect(),
            mismatches: progress.mismatches.iter().map(mismatch).collect(),
            unheard: progress.unheard.iter().copied().map(Which::of).collect(),
            stored: progress.stored,
        }
    }
}

fn print_written(written: &[Difference]) -> Outcome {
    let rows: Vec<_> = written
        .iter()
        .map(|&Difference { item, file, module }| [item.name(), spelled(item, module), spelled(item, file)])
        .collect();
    if rows.is_empty() {
        return Ok(());
    }
    Ok(print::listing(["name", "before", "after"], rows.into_iter())?)
}

fn say_left(left: &[(Left, Difference)]) {
    for (left, Difference { item, file, module }) in left {
        let (name, file, module) = (item.name(), spelled(*item, *file), spelled(*item, *module));
        let why = why(*left);
        print::note(&format!("`{name}` stays {module} and does not become {file}: {why}"));
    }
}

fn why(left: Left) -> &'static str {
    match left {
        Left::Connection => "the module is reached by it; --connection writes it too",
        Left::Lock => "a file takes no lock away",
    }
}

/// Says what there is to say, and how the command ends.
fn conclude(progress: Progress, outcome: Result<(), Failure>) -> Outcome {
    if progress.stored > 0 {
        let s = if progress.stored == 1 { "" } else { "s" };
        print::note(&format!("stored {} parameter{s}", progress.stored));
    }
    for item in &progress.unheard {
        print::note(&format!("`{}` was written, and the module does not answer here any more", item.name()));
    }
    for (item, wanted, found) in &progress.mismatches {
        let (wanted, found) = (spelled(*item, *wanted), spelled(*item, *found));
        print::error(&format!("`{}` holds {found} and not {wanted}", item.name()));
    }
    let mut failures = Failures::default();
    for (_, refusal) in progress.refused {
        failures.note::<()>(Err(refusal));
    }
    outcome?;
    match (failures.finish(), progress.mismatches.is_empty()) {
        (Ok(()), true) => Ok(()),
        _ => Err(Code::Findings.into()),
    }
}
