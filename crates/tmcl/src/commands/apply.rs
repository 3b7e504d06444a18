//! `tmcl apply`: bringing a configuration file into a module.

use std::path::PathBuf;

use clap::Args;
use tmcl_config::{Difference, Left, Wishes, plan};

use crate::connection::ConnectionOptions;
use crate::exit::{Code, Failures, Outcome};
use crate::parameters::{self, Progress, spelled};
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
    if options.dry_run {
        let plan = plan(&parameters::differences(&mut client, &loaded.config)?, wishes);
        say_left(&plan.left);
        return print_written(plan.writes.iter().map(|(_, difference)| difference));
    }
    report(parameters::apply(&mut client, &loaded.config, wishes, options.store)?)
}

fn print_written<'d>(written: impl Iterator<Item = &'d Difference>) -> Outcome {
    let rows: Vec<_> = written
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
        let why = match left {
            Left::Connection => "the module is reached by it; --connection writes it too",
            Left::Lock => "a file takes no lock away",
        };
        print::note(&format!("`{name}` stays {module} and does not become {file}: {why}"));
    }
}

fn report(progress: Progress) -> Outcome {
    print_written(progress.written.iter())?;
    say_left(&progress.left);
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
    for refusal in progress.refused {
        failures.note::<()>(Err(refusal));
    }
    match (failures.finish(), progress.mismatches.is_empty()) {
        (Ok(()), true) => Ok(()),
        _ => Err(Code::Findings.into()),
    }
}
