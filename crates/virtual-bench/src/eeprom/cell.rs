//! A cell of two slots: one that counts, and one that the next write goes to.
//!
//! A slot is a mark, its data, and a checksum of both and of where it lies. To write is: mark the other slot as being written,
//! write data and checksum, and set the mark that says it is newer than its neighbour. Before the last of these byte writes the
//! old slot counts, after it the new one. A byte torn by a power cut is noticed by the checksum, which notices every change of
//! a single byte, or by the mark; the slot does not count then.

use super::check::Fault;
use super::layout::{CRC, Region};
use super::medium::{ERASED, Medium};

/// Marks a slot that is being written, or whose writing was interrupted.
const WRITING: u8 = 0x0F;

/// Mark a slot that holds something; each is newer than the one before, and the first is newer than the last. Any two of
/// these marks differ in four bits or more.
const TURNS: [u8; 3] = [0x33, 0x55, 0x66];

/// What a slot holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Slot<const N: usize> {
    /// Nothing was ever written to it.
    Erased,
    /// What it shall hold did not arrive yet, or never will.
    Writing,
    /// An index into [`TURNS`], and data.
    Holds(usize, [u8; N]),
    /// Nobody knows.
    Damaged(Fault),
}

/// What a slot at an address holds.
pub(super) fn slot<const N: usize>(bytes: &[u8], address: usize) -> Slot<N> {
    let Some((&mark, rest)) = bytes.get(address..).and_then(<[u8]>::split_first) else { return Slot::Erased };
    let Some((data, rest)) = rest.split_first_chunk::<N>() else { return Slot::Erased };
    let Some(checksum) = rest.first_chunk() else { return Slot::Erased };
    match TURNS.iter().position(|turn| *turn == mark) {
        Some(turn) if checksum_of(address, mark, data) == *checksum => Slot::Holds(turn, *data),
        Some(_) => Slot::Damaged(Fault::Checksum),
        None if mark == WRITING => Slot::Writing,
        None if mark != ERASED => Slot::Damaged(Fault::Mark(mark)),
        None if *data == [ERASED; N] && *checksum == [ERASED; 2] => Slot::Erased,
        None => Slot::Damaged(Fault::NotErased),
    }
}

fn checksum_of(address: usize, mark: u8, data: &[u8]) -> [u8; 2] {
    let mut digest = CRC.digest();
    digest.update(&u32::try_from(address).unwrap_or(u32::MAX).to_be_bytes());
    digest.update(&[mark]);
    digest.update(data);
    digest.finalize().to_be_bytes()
}

/// The slot that counts, its turn and its data; `None` when the cell holds nothing.
fn newest<const N: usize>(bytes: &[u8], region: Region, cell: usize) -> Option<(usize, usize, [u8; N])> {
    let [first, second] = [0, 1].map(|index| match slot(bytes, region.address(cell, index)) {
        Slot::Holds(turn, data) => Some((index, turn, data)),
        Slot::Erased | Slot::Writing | Slot::Damaged(_) => None,
    });
    match (first, second) {
        (Some((_, older, _)), Some((_, turn, _))) if turn == next(older) => second,
        (Some(_), _) => first,
        (None, _) => second,
    }
}

fn next(turn: usize) -> usize {
    (turn + 1) % TURNS.len()
}

/// What a cell holds.
pub(super) fn read<const N: usize>(bytes: &[u8], region: Region, cell: usize) -> Option<[u8; N]> {
    newest(bytes, region, cell).map(|(_, _, data)| data)
}

/// Makes a cell hold `data`; nothing is written where it does already.
pub(super) fn write<const N: usize>(medium: &mut Medium, region: Region, cell: usize, data: [u8; N]) {
    let counts = newest(medium.bytes(), region, cell);
    if counts.is_some_and(|(_, _, holds)| holds == data) {
        return;
    }
    let (slot, turn) = counts.map_or((0, 0), |(slot, turn, _)| (1 - slot, next(turn)));
    let address = region.address(cell, slot);
    let mark = TURNS.get(turn).copied().unwrap_or(WRITING);
    medium.write(address, [WRITING]);
    medium.write(address + 1, data.into_iter().chain(checksum_of(address, mark, &data)));
    medium.write(address, [mark]);
}

/// Whether both slots of a cell can be as they are found.
pub(super) fn check<const N: usize>(
    bytes: &[u8],
    region: Region,
    cell: usize,
) -> impl Iterator<Item = (usize, Fault)> {
    let addresses = [0, 1].map(|index| region.address(cell, index));
    let slots = addresses.map(|address| slot::<N>(bytes, address));
    let twins = match slots {
        [Slot::Holds(first, _), Slot::Holds(second, _)] if first == second => {
            Some((addresses[0], Fault::Twins))
        }
        _ => None,
    };
    let damaged = addresses.into_iter().zip(slots).filter_map(|(address, slot)| match slot {
        Slot::Damaged(fault) => Some((address, fault)),
        Slot::Erased | Slot::Writing | Slot::Holds(..) => None,
    });
    damaged.chain(twins)
}
