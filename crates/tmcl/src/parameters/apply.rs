//! Bringing a configuration into a module.

use tmcl_client::ClientError;
use tmcl_config::file::{Config, Entry};
use tmcl_config::{Difference, Item, Left, Phase, Plan, Wishes, plan};

use super::access::{Storage, read, refused, storage, store, write};
use crate::connection::{AnyClient, failure};
use crate::exit::Failure;

/// What came of it.
#[derive(Debug, Default)]
pub(crate) struct Progress {
    /// What was written.
    pub(crate) written: Vec<Difference>,
    /// What was not to be written.
    pub(crate) left: Vec<(Left, Difference)>,
    /// What the module refused to take or to store, and why.
    pub(crate) refused: Vec<(Item, Failure)>,
    /// What holds something else than was written: the parameter, what it should hold, and what it holds.
    pub(crate) mismatches: Vec<(Item, i64, i64)>,
    /// How many parameters were stored.
    pub(crate) stored: usize,
    /// What could not be read back, because the module is not reached as before any more.
    pub(crate) unheard: Vec<Item>,
}

/// What differs between a configuration and a module, in the order of the tables.
pub(crate) fn differences(client: &mut AnyClient, config: &Config) -> Result<Vec<Difference>, Failure> {
    let mut differences = Vec::new();
    for &Entry { item, value: file, .. } in &config.entries {
        let module = read(client, item).map_err(|error| failure(&error))?;
        if file != module {
            differences.push(Difference { item, file, module });
        }
    }
    Ok(differences)
}

/// Writes what differs, reads back, and stores where that is wanted. What may cut the connection comes last, and what the
/// module refuses does not keep the rest from being written. What was done stands in `progress`, also when the connection fails.
pub(crate) fn apply(
    client: &mut AnyClient,
    config: &Config,
    wishes: Wishes,
    to_store: bool,
    progress: &mut Progress,
) -> Result<(), Failure> {
    let Plan { writes, left } = plan(&differences(client, config)?, wishes);
    progress.left = left;
    let (settings, others): (Vec<_>, Vec<_>) =
        writes.into_iter().partition(|(phase, _)| *phase == Phase::Setting);
    let unwritten =
        write_settings(client, settings.into_iter().map(|(_, setting)| setting).collect(), progress)?;
    read_back(client, config, &unwritten, progress)?;
    if to_store {
        store_all(client, config, progress)?;
    }
    write_others(client, &others, progress)
}

/// Writes settings; those that are refused once more after the others, since one may depend on another. Returns the items
/// that were not written.
fn write_settings(
    client: &mut AnyClient,
    mut waiting: Vec<Difference>,
    progress: &mut Progress,
) -> Result<Vec<Item>, Failure> {
    loop {
        let before = waiting.len();
        let mut refusals = Vec::new();
        let mut again = Vec::new();
        for difference in waiting {
            match write(client, difference.item, difference.file) {
                Ok(()) => progress.written.push(difference),
                Err(error @ ClientError::Status { .. }) => {
                    refusals.push((difference.item, refused(&difference.item.name(), &error)));
                    again.push(difference);
                }
                Err(error) => return Err(failure(&error)),
            }
        }
        if again.is_empty() || again.len() == before {
            progress.refused.extend(refusals);
            return Ok(again.into_iter().map(|difference| difference.item).collect());
        }
        waiting = again;
    }
}

/// Reads the settings of the file back, also those that were right before: another one may have changed them.
fn read_back(
    client: &mut AnyClient,
    config: &Config,
    unwritten: &[Item],
    progress: &mut Progress,
) -> Result<(), Failure> {
    let settings = config.entries.iter().filter(|entry| entry.item.role() == tmcl_tables::Role::Setting);
    for entry in settings.filter(|entry| !unwritten.contains(&entry.item)) {
        let found = read(client, entry.item).map_err(|error| failure(&error))?;
        if found != entry.value {
            progress.mismatches.push((entry.item, entry.value, found));
        }
    }
    Ok(())
}

/// Stores what the file holds and the module does not store by itself.
fn store_all(client: &mut AnyClient, config: &Config, progress: &mut Progress) -> Result<(), Failure> {
    for item in
        config.entries.iter().map(|entry| entry.item).filter(|item| storage(*item) == Storage::Command)
    {
        match store(client, item) {
            Ok(()) => progress.stored += 1,
            Err(error @ ClientError::Status { .. }) => {
                progress.refused.push((item, refused(&item.name(), &error)));
            }
            Err(error) => return Err(failure(&error)),
        }
    }
    Ok(())
}

/// Writes addresses, interfaces and locks, then reads them back. A module that does not answer any more is not lost: it is
/// where the file says.
fn write_others(
    client: &mut AnyClient,
    others: &[(Phase, Difference)],
    progress: &mut Progress,
) -> Result<(), Failure> {
    let mut written = Vec::new();
    for &(phase, difference) in others {
        match write(client, difference.item, difference.file) {
            Ok(()) => {
                progress.written.push(difference);
                written.push((phase, difference));
            }
            // It may have been cut by what was written before.
            Err(error) => {
                progress.refused.push((difference.item, refused(&difference.item.name(), &error)));
            }
        }
    }
    let silent = written.iter().any(|(phase, _)| *phase == Phase::Silence);
    for (_, Difference { item, file, .. }) in written {
        if silent {
            progress.unheard.push(item);
            continue;
        }
        match read(client, item) {
            Ok(found) if found != file => progress.mismatches.push((item, file, found)),
            Ok(_) => {}
            Err(ClientError::NoReply { .. }) => progress.unheard.push(item),
            Err(error) => return Err(failure(&error)),
        }
    }
    Ok(())
}
