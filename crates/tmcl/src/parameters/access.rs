//! One parameter of a module.

use tmcl_client::ClientError;
use tmcl_config::Item;
use tmcl_tables::{ModuleSpec, Status};

use crate::connection::{AnyClient, failure, follow};
use crate::exit::Failure;

/// Reads it.
pub(crate) fn read(client: &mut AnyClient, item: Item) -> Result<i64, ClientError> {
    let bits = match item {
        Item::Axis(spec) => client.get_axis_parameter(spec.number),
        Item::Global(entry, number) => client.get_global_parameter(entry.bank, number),
        Item::Coordinate(number) => client.get_coordinate(number),
        Item::Port(port) => client.get_input(port.bank, port.number),
    }?;
    Ok(item.from_wire(bits))
}

/// Reads several.
pub(crate) fn read_all(
    client: &mut AnyClient,
    items: impl IntoIterator<Item = Item>,
) -> Result<Vec<(Item, i64)>, Failure> {
    let value = |item| read(client, item).map(|value| (item, value)).map_err(|error| failure(&error));
    items.into_iter().map(value).collect()
}

/// Writes it so that `value` is read afterwards. The client follows a change of addresses.
pub(crate) fn write(client: &mut AnyClient, item: Item, value: i64) -> Result<(), ClientError> {
    let bits = item.to_wire(value);
    match item {
        Item::Axis(spec) => client.set_axis_parameter(spec.number, bits)?,
        Item::Global(entry, number) => client.set_global_parameter(entry.bank, number, bits)?,
        Item::Coordinate(number) => client.set_coordinate(number, bits)?,
        Item::Port(port) => client.set_output(port.number, bits)?,
    }
    match item {
        Item::Global(entry, number) => follow(client, entry.bank, number, value),
        _ => Ok(()),
    }
}

/// How a value gets into the EEPROM.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Storage {
    /// It does not.
    None,
    /// With every write.
    Itself,
    /// With a command of its own.
    Command,
}

/// How a parameter gets into the EEPROM: bank 0 is stored as it is written (TMCM-1311 §5.7.11).
pub(crate) fn storage(item: Item) -> Storage {
    match item {
        _ if !item.access().store => Storage::None,
        Item::Global(entry, _) if entry.bank == 0 => Storage::Itself,
        _ => Storage::Command,
    }
}

/// Stores it as it is.
pub(crate) fn store(client: &mut AnyClient, item: Item) -> Result<(), ClientError> {
    match item {
        Item::Axis(spec) => client.store_axis_parameter(spec.number),
        Item::Global(entry, number) => client.store_global_parameter(entry.bank, number),
        Item::Coordinate(number) => client.store_coordinate(number),
        Item::Port(_) => Ok(()),
    }
}

/// Brings back what is stored.
pub(crate) fn restore(client: &mut AnyClient, item: Item) -> Result<(), ClientError> {
    match item {
        Item::Axis(spec) => client.restore_axis_parameter(spec.number),
        Item::Global(entry, number) => client.restore_global_parameter(entry.bank, number),
        Item::Coordinate(number) => client.restore_coordinate(number),
        Item::Port(_) => Ok(()),
    }
}

/// Whether the module is in closed loop, where one of `items` has another unit then.
pub(crate) fn closed_loop(
    client: &mut AnyClient,
    module: &'static ModuleSpec,
    mut items: impl Iterator<Item = Item>,
) -> Result<bool, Failure> {
    match Item::by_id(module, "closed_loop_mode") {
        Some(mode) if items.any(Item::has_two_units) => {
            Ok(read(client, mode).map_err(|error| failure(&error))? != 0)
        }
        _ => Ok(false),
    }
}

/// A value as `tmcl set` takes it: its name, or the number.
pub(crate) fn spelled(item: Item, value: i64) -> String {
    let named = item.values().iter().find(|named| named.value == value);
    named.map_or_else(|| value.to_string(), |named| named.id.to_owned())
}

/// What went wrong with a parameter, and what helps where that is known.
pub(crate) fn refused(name: &str, error: &ClientError) -> Failure {
    let advice = match error {
        ClientError::Status { status: Status::EepromLocked, .. } => {
            "; `tmcl set eeprom_lock=unlocked` takes the lock away"
        }
        _ => "",
    };
    Failure::new(failure(error).code(), format!("`{name}`: {error}{advice}"))
}
