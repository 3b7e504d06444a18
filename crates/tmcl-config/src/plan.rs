//! In which order what differs is written, and what is not.

use tmcl_tables::{GlobalParameter, Role};

use crate::item::Item;

/// A parameter that a file wants to have another value than the module has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Difference {
    /// The parameter.
    pub item: Item,
    /// What the file says.
    pub file: i64,
    /// What the module says.
    pub module: i64,
}

/// What is to be written although it is not a matter of course.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wishes {
    /// Addresses and interfaces.
    pub connection: bool,
}

/// When something is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Phase {
    /// First, in the order of the tables.
    Setting,
    /// Then the addresses, which a host can follow, and then what may cut the connection.
    Connection,
    /// Then the locks, which would keep anything else from being written.
    Lock,
    /// Then whether the module answers at all.
    Silence,
}

/// Why something is left as it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Left {
    /// It may cut the connection, and nobody wished for that.
    Connection,
    /// The module is locked more than the file wants. Taking away a lock is no matter of a file: with one of them goes the
    /// program that it protects (TMCM-1311 §10.1, GP 81).
    Lock,
}

/// What to do about the differences.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Plan {
    /// What to write, in this order.
    pub writes: Vec<(Phase, Difference)>,
    /// What to leave.
    pub left: Vec<(Left, Difference)>,
}

/// What to do about `differences`.
#[must_use]
pub fn plan(differences: &[Difference], wishes: Wishes) -> Plan {
    let mut plan = Plan::default();
    for &difference in differences {
        match difference.item.role() {
            Role::Connection if !wishes.connection => plan.left.push((Left::Connection, difference)),
            Role::Lock if loosens(difference) => plan.left.push((Left::Lock, difference)),
            _ => plan.writes.push((phase(difference.item), difference)),
        }
    }
    plan.writes.sort_by_key(|(phase, difference)| (*phase, !is_address(difference.item)));
    plan
}

/// Whether a host that knows it has been written goes on talking to the module.
fn is_address(item: Item) -> bool {
    const ADDRESSES: [GlobalParameter; 4] = [
        GlobalParameter::SerialAddress,
        GlobalParameter::HostAddress,
        GlobalParameter::CanReplyId,
        GlobalParameter::CanId,
    ];
    is_one_of(item, &ADDRESSES)
}

fn phase(item: Item) -> Phase {
    match item.role() {
        Role::Lock => Phase::Lock,
        Role::Connection if is_one_of(item, &[GlobalParameter::SuppressReply]) => Phase::Silence,
        Role::Connection => Phase::Connection,
        Role::Setting | Role::State => Phase::Setting,
    }
}

fn is_one_of(item: Item, parameters: &[GlobalParameter]) -> bool {
    matches!(item, Item::Global(entry, number)
        if parameters.iter().any(|parameter| parameter.address() == (entry.bank, number)))
}

/// Whether a bit that forbids something would be taken away.
fn loosens(difference: Difference) -> bool {
    difference.module & !difference.file != 0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::name::Name;

    fn difference(name: &str, file: i64, module: i64) -> Difference {
        let item = Name::parse(name, &tmcl_tables::tmcm_1311::SPEC).expect("there is one").item;
        Difference { item, file, module }
    }

    fn names(plan: &Plan) -> Vec<String> {
        plan.writes.iter().map(|(_, difference)| difference.item.name()).collect()
    }

    #[test]
    fn what_may_cut_the_connection_comes_after_the_rest_and_locks_after_that() {
        let differences = [
            difference("baud_rate", 7, 0),
            difference("serial_address", 5, 1),
            difference("eeprom_lock", 1, 0),
            difference("host_address", 3, 2),
            difference("suppress_reply", 1, 0),
            difference("timer_0_period", 10, 0),
        ];
        let all = plan(&differences, Wishes { connection: true });
        assert_eq!(
            names(&all),
            [
                "timer_0_period",
                "serial_address",
                "host_address",
                "baud_rate",
                "eeprom_lock",
                "suppress_reply"
            ]
        );
        let few = plan(&differences, Wishes::default());
        assert_eq!(names(&few), ["timer_0_period", "eeprom_lock"]);
        assert_eq!(few.left.len(), 4);
    }

    #[test]
    fn a_lock_is_set_and_never_taken_away() {
        let kinds = |file, module| {
            let plan = plan(&[difference("code_protection", file, module)], Wishes::default());
            (plan.writes.len(), plan.left.first().map(|(left, _)| *left))
        };
        assert_eq!(kinds(3, 1), (1, None));
        for (file, module) in [(0, 1), (2, 3), (2, 1), (0, 2)] {
            assert_eq!(kinds(file, module), (0, Some(Left::Lock)));
        }
    }
}
