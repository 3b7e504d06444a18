//! The commands that read and write what has a name.

use tmcl_config::Item;
use tmcl_tables::Command;
use tmcl_wire::Request;

/// The only motor (TMCM-1311 §5.7.1).
const MOTOR: u8 = 0;

/// The command that reads it.
pub(crate) fn reading(item: Item) -> Request {
    let (command, kind, motor) = match item {
        Item::Axis(spec) => (Command::GetAxisParameter, spec.number, MOTOR),
        Item::Global(entry, number) => (Command::GetGlobalParameter, number, entry.bank),
        Item::Coordinate(number) => (Command::GetCoordinate, number, MOTOR),
        Item::Port(port) => (Command::GetInput, port.number, port.bank),
    };
    Request::new(command, kind, motor, 0)
}

/// The command that writes it so that `value` is read afterwards.
pub(crate) fn writing(item: Item, value: i64) -> Request {
    let (command, kind, motor) = match item {
        Item::Axis(spec) => (Command::SetAxisParameter, spec.number, MOTOR),
        Item::Global(entry, number) => (Command::SetGlobalParameter, number, entry.bank),
        Item::Coordinate(number) => (Command::SetCoordinate, number, MOTOR),
        Item::Port(port) => (Command::SetOutput, port.number, port.bank),
    };
    Request::new(command, kind, motor, item.to_wire(value))
}
