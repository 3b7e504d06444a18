//! The program in memory that is written byte by byte: two places for each instruction, of which one stands.
//!
//! A place is the seven bytes of the instruction and a tag: two bits that count writes (1, 2, 3, 1 …; 0 stands for nothing)
//! and a checksum of six. A write goes to the place that does not stand: first its tag is taken away, then come the
//! instruction and the new tag. Whenever the power fails, the old instruction or the new one stands.

use embedded_storage::Storage as ByteStorage;
use module_firmware::{ERASED, Instruction, StorageError};

use crate::header;

/// Where the program begins, in bytes.
pub(crate) const START: u32 = header::BYTES;

/// Bytes that an instruction takes: two places.
pub(crate) const SLOT: u32 = 2 * PLACE;

const PLACE: u32 = 8;
const TAG: u32 = 7;

/// Nothing stands here.
const NOTHING: u8 = 0;

/// What a place holds: an instruction, and the count of the write.
type Held = Option<(Instruction, u8)>;

/// The instruction at an address; one that was never written, or is damaged in both places, is erased.
pub(crate) fn read(eeprom: &mut impl ByteStorage, address: u16) -> Result<Instruction, StorageError> {
    let places = places(eeprom, address)?;
    Ok(standing(places).and_then(|index| places.get(index).copied().flatten()).map_or(ERASED, |held| held.0))
}

/// Writes an instruction.
pub(crate) fn write(
    eeprom: &mut impl ByteStorage,
    address: u16,
    instruction: Instruction,
) -> Result<(), StorageError> {
    let places = places(eeprom, address)?;
    let standing = standing(places);
    let count =
        standing.and_then(|index| places.get(index).copied().flatten()).map_or(1, |held| after(held.1));
    let place = match standing {
        Some(0) => offset(address) + PLACE,
        _ => offset(address),
    };
    put(eeprom, place + TAG, &[NOTHING])?;
    put(eeprom, place, &instruction)?;
    put(eeprom, place + TAG, &[tag(&instruction, count)])
}

/// Makes every instruction read as erased. What is erased already is not written again.
pub(crate) fn erase(eeprom: &mut impl ByteStorage, instructions: u16) -> Result<(), StorageError> {
    for address in 0..instructions {
        let places = places(eeprom, address)?;
        for (place, held) in (0..).step_by(PLACE as usize).zip(places) {
            if held.is_some() {
                put(eeprom, offset(address) + place + TAG, &[NOTHING])?;
            }
        }
    }
    Ok(())
}

/// Makes a memory that may hold anything read as erased.
pub(crate) fn format(eeprom: &mut impl ByteStorage, instructions: u16) -> Result<(), StorageError> {
    for address in 0..instructions {
        for place in [0, PLACE] {
            put(eeprom, offset(address) + place + TAG, &[NOTHING])?;
        }
    }
    Ok(())
}

fn offset(address: u16) -> u32 {
    START + SLOT * u32::from(address)
}

fn put(eeprom: &mut impl ByteStorage, offset: u32, bytes: &[u8]) -> Result<(), StorageError> {
    eeprom.write(offset, bytes).map_err(|_| StorageError::Medium)
}

fn places(eeprom: &mut impl ByteStorage, address: u16) -> Result<[Held; 2], StorageError> {
    let mut bytes = [0; SLOT as usize];
    eeprom.read(offset(address), &mut bytes).map_err(|_| StorageError::Medium)?;
    let [a, b, c, d, e, f, g, first, h, i, j, k, l, m, n, second] = bytes;
    Ok([held([a, b, c, d, e, f, g], first), held([h, i, j, k, l, m, n], second)])
}

fn held(instruction: Instruction, found: u8) -> Held {
    let count = found >> 6;
    (count != 0 && tag(&instruction, count) == found).then_some((instruction, count))
}

/// Which of two places stands: the one that was written last.
fn standing([first, second]: [Held; 2]) -> Option<usize> {
    match (first, second) {
        (None, None) => None,
        (Some(_), None) => Some(0),
        (None, Some(_)) => Some(1),
        (Some((_, first)), Some((_, second))) => Some(usize::from(after(first) == second)),
    }
}

/// The count after this one.
fn after(count: u8) -> u8 {
    if count == 3 { 1 } else { count + 1 }
}

fn tag(instruction: &Instruction, count: u8) -> u8 {
    (count << 6) | checksum(instruction, count)
}

/// CRC-6 of ITU-T G.704 over the count and the instruction.
fn checksum(instruction: &Instruction, count: u8) -> u8 {
    let bytes = core::iter::once(&count).chain(instruction);
    bytes.fold(0, |crc, byte| REMAINDERS.get(usize::from((crc << 2) ^ byte)).copied().unwrap_or(0))
}

/// What a byte leaves of the checksum, by table: an instruction is looked at every 50 µs where it is executed in place.
static REMAINDERS: [u8; 256] = remainders();

#[expect(clippy::indexing_slicing, reason = "computed when compiled")]
const fn remainders() -> [u8; 256] {
    let mut table = [0; 256];
    let mut byte = 0;
    while byte < table.len() {
        // The six bits of the checksum stand highest.
        let mut remainder = byte as u8;
        let mut bit = 0;
        while bit < 8 {
            let carry = remainder & 0x80 != 0;
            remainder <<= 1;
            if carry {
                remainder ^= 0x03 << 2;
            }
            bit += 1;
        }
        table[byte] = remainder >> 2;
        byte += 1;
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Blank EEPROMs read as ones, FRAMs and the emulator's memory as zeros.
    #[test]
    fn blank_memory_holds_nothing() {
        for blank in [0x00, 0xFF] {
            assert_eq!(held([blank; 7], blank), None);
        }
    }

    #[test]
    fn the_table_does_what_the_polynomial_does() {
        let check = b"123456789".iter();
        let crc = check.fold(0, |crc: u8, byte| REMAINDERS[usize::from((crc << 2) ^ byte)]);
        let bitwise = b"123456789".iter().fold(0_u8, |crc, byte| {
            (0..8).rev().fold(crc, |crc, bit| {
                let carry = (crc >> 5) ^ ((byte >> bit) & 1);
                let shifted = (crc << 1) & 0x3F;
                if carry == 0 { shifted } else { shifted ^ 0x03 }
            })
        });
        assert_eq!(crc, bitwise);
    }

    #[test]
    fn a_tag_fits_its_own_instruction_and_no_neighbour() {
        let instruction = [4, 1, 0, 0, 0, 0x12, 0x34];
        for count in 1..=3 {
            assert_eq!(held(instruction, tag(&instruction, count)), Some((instruction, count)));
            for bit in 0..56 {
                let mut other = instruction;
                other[bit / 8] ^= 1 << (bit % 8);
                assert_eq!(held(other, tag(&instruction, count)), None, "bit {bit}");
            }
        }
    }
}
