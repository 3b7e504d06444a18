//! The compiled file, as the vendor's IDE writes it: eight bytes an instruction, the last being the sum of the seven.
//!
//! The file is the program and nothing else: it has no header and names no module (decisions: this layout is what a stock
//! client reads and sends as it stands).

use crate::instruction::Instruction;

/// The bytes of an instruction in the file.
const RECORD: usize = 8;

/// Why bytes are no compiled program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ImageError {
    /// A compiled program has eight bytes an instruction.
    #[error("{0} bytes are no whole number of instructions; each has 8")]
    Length(usize),
    /// The eighth byte is not the sum of the seven.
    #[error(
        "instruction {address} is damaged: its bytes add up to {expected:#04x}, but {found:#04x} stands there"
    )]
    Checksum {
        /// Which instruction.
        address: usize,
        /// The sum of its seven bytes.
        expected: u8,
        /// The eighth byte.
        found: u8,
    },
}

/// The compiled file of a program.
#[must_use]
pub fn encode(instructions: &[Instruction]) -> Vec<u8> {
    let mut file = Vec::with_capacity(instructions.len() * RECORD);
    for instruction in instructions {
        let bytes = instruction.to_bytes();
        file.extend(bytes);
        file.push(sum(bytes));
    }
    file
}

/// The program in a compiled file; an empty file is an empty program.
///
/// # Errors
/// [`ImageError`] when it is none: the first damaged instruction is named, and a file that was cut off is refused as a whole.
pub fn decode(bytes: &[u8]) -> Result<Vec<Instruction>, ImageError> {
    let (records, rest) = bytes.as_chunks::<RECORD>();
    if !rest.is_empty() {
        return Err(ImageError::Length(bytes.len()));
    }
    records.iter().enumerate().map(|(address, record)| instruction(address, *record)).collect()
}

fn instruction(address: usize, record: [u8; RECORD]) -> Result<Instruction, ImageError> {
    let [a, b, c, d, e, f, g, found] = record;
    let bytes = [a, b, c, d, e, f, g];
    let expected = sum(bytes);
    if found != expected {
        return Err(ImageError::Checksum { address, expected, found });
    }
    Ok(Instruction::from_bytes(bytes))
}

/// The low eight bits of the sum.
fn sum(bytes: [u8; 7]) -> u8 {
    bytes.iter().fold(0, |sum: u8, byte| sum.wrapping_add(*byte))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn eight_bytes_an_instruction() {
        // MVP ABS, 0, 90000 of TMCM-1311 §5.7.4, and ROL 0, -1.
        let instructions = [
            Instruction { command: 4, kind: 0, motor: 0, value: 90_000 },
            Instruction { command: 2, kind: 0, motor: 0, value: -1 },
        ];
        let file = [4, 0, 0, 0, 1, 0x5f, 0x90, 0xf4, 2, 0, 0, 0xff, 0xff, 0xff, 0xff, 0xfe];
        assert_eq!(encode(&instructions), file);
        assert_eq!(decode(&file), Ok(instructions.to_vec()));
    }

    #[test]
    fn an_empty_file_is_an_empty_program() {
        assert_eq!(encode(&[]), []);
        assert_eq!(decode(&[]), Ok(Vec::new()));
    }

    #[test]
    fn a_file_that_was_cut_off_is_refused() {
        assert_eq!(decode(&[28, 0, 0, 0, 0, 0, 0]), Err(ImageError::Length(7)));
        assert_eq!(decode(&[28, 0, 0, 0, 0, 0, 0, 28, 28]), Err(ImageError::Length(9)));
    }

    #[test]
    fn the_damaged_instruction_is_named() {
        let mut file = encode(&[Instruction::STOP; 3]);
        file[15] = 0x1d;
        let error = decode(&file).unwrap_err();
        assert_eq!(error, ImageError::Checksum { address: 1, expected: 0x1c, found: 0x1d });
        assert_eq!(
            error.to_string(),
            "instruction 1 is damaged: its bytes add up to 0x1c, but 0x1d stands there"
        );
    }

    proptest! {
        #[test]
        fn what_was_written_is_read(bytes in prop::collection::vec(any::<[u8; 7]>(), 0..50)) {
            let instructions: Vec<_> = bytes.into_iter().map(Instruction::from_bytes).collect();
            prop_assert_eq!(decode(&encode(&instructions)), Ok(instructions));
        }

        #[test]
        fn any_one_damaged_byte_is_found(
            bytes in prop::collection::vec(any::<[u8; 7]>(), 1..20),
            place: prop::sample::Index,
            by in 1..=255_u8,
        ) {
            let instructions: Vec<_> = bytes.into_iter().map(Instruction::from_bytes).collect();
            let mut file = encode(&instructions);
            let place = place.index(file.len());
            file[place] = file[place].wrapping_add(by);
            let is_named = matches!(decode(&file), Err(ImageError::Checksum { address, .. }) if address == place / 8);
            prop_assert!(is_named);
        }
    }
}
