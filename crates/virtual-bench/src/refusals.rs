//! The instructions of a program that its module refused: which, why, how often, and when first.

use std::collections::BTreeMap;

use module_firmware::Refusal;
use tmcl_tables::Status;

/// What is remembered of an instruction that was refused with a status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RefusedInstruction {
    /// Its address.
    pub address: u16,
    /// The status.
    pub status: Status,
    /// When it was refused first, in virtual time.
    pub first_ns: u64,
    /// How often it was.
    pub count: u64,
}

/// Every refused instruction since the bench was made, in the order of addresses. The bench saw them: a power cycle does not
/// make them undone.
#[derive(Clone, Debug, Default)]
pub(crate) struct Refusals(BTreeMap<(u16, u8), RefusedInstruction>);

impl Refusals {
    pub(crate) fn add(&mut self, refusal: Refusal, now_ns: u64) {
        let Refusal { address, status } = refusal;
        let new = RefusedInstruction { address, status, first_ns: now_ns, count: 0 };
        self.0.entry((address, status.number())).or_insert(new).count += 1;
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = RefusedInstruction> + '_ {
        self.0.values().copied()
    }
}
