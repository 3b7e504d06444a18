//! What can be wrong with an image, and how it is found.

use module_firmware::RecordKey;

use super::layout::{
    CRC, ERASURE, FORMAT, HEADER, IMAGE_LENGTH, INSTRUCTION, PROGRAM, RECORD, RECORDS, SIGNATURE, records,
};
use super::medium::Medium;
use super::storage::{Erasing, erasing};
use super::{Eeprom, cell};
use crate::ModuleKind;

/// What is wrong with an image.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ImageError {
    /// Too short, or too long.
    #[error("its length in bytes is {0} instead of {IMAGE_LENGTH}")]
    Length(usize),
    /// It does not begin as every image does.
    #[error("at byte 0: it does not begin with \"OpenTMCL\"")]
    Signature,
    /// The header's checksum does not fit.
    #[error("at byte 11: the checksum of the header is wrong")]
    Header,
    /// It is of another version of the format.
    #[error("it has format {0}, and format {FORMAT} is known here")]
    Format(u8),
    /// It is for a module that there is no virtual one of.
    #[error("it is for a module with the number {0}, of which there is no virtual one here")]
    Module(u16),
    /// What it holds is not what was written.
    #[error("{}", listed(.0))]
    Damaged(Vec<Damage>),
}

impl ImageError {
    /// Whether the image may be as good as ever, and somebody else can read it.
    #[must_use]
    pub fn is_foreign(&self) -> bool {
        matches!(self, Self::Format(_) | Self::Module(_))
    }
}

/// The first few, and how many more.
fn listed(damages: &[Damage]) -> String {
    const SHOWN: usize = 3;
    let mut text: Vec<_> = damages.iter().take(SHOWN).map(ToString::to_string).collect();
    if let more @ 1.. = damages.len().saturating_sub(SHOWN) {
        text.push(format!("and {more} more"));
    }
    text.join("; ")
}

/// Something that is damaged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("at byte {address}, {place}: {fault}")]
pub struct Damage {
    /// Where it begins.
    pub address: usize,
    /// What lies there.
    pub place: Place,
    /// What is wrong with it.
    pub fault: Fault,
}

/// What lies at a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// What is being erased.
    Erasure,
    /// A record.
    Record(RecordKey),
    /// An instruction of the program.
    Instruction(u16),
}

impl core::fmt::Display for Place {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Erasure => write!(f, "the note of what is being erased"),
            Self::Record(RecordKey::Axis(number)) => write!(f, "axis parameter {number}"),
            Self::Record(RecordKey::Global(bank, number)) => {
                write!(f, "global parameter {number} in bank {bank}")
            }
            Self::Record(RecordKey::Coordinate(number)) => write!(f, "coordinate {number}"),
            Self::Instruction(address) => write!(f, "instruction {address}"),
        }
    }
}

/// How a slot of a cell can be damaged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Fault {
    /// The checksum does not fit.
    #[error("the checksum is wrong")]
    Checksum,
    /// A mark that no slot has.
    #[error("{0:#04x} is no mark that a write leaves")]
    Mark(u8),
    /// It is marked as erased and is not.
    #[error("it is erased in part")]
    NotErased,
    /// Two slots of a cell that claim to be equally new.
    #[error("its two copies are equally new")]
    Twins,
}

/// An image that is as it should be.
pub(super) fn open(image: &[u8]) -> Result<Eeprom, ImageError> {
    let kind = read_header(image)?;
    let medium = Medium::from_image(image).ok_or(ImageError::Length(image.len()))?;
    let damages = damages(medium.bytes());
    if damages.is_empty() { Ok(Eeprom { kind, medium }) } else { Err(ImageError::Damaged(damages)) }
}

/// Its header is looked at first: another version may have another length.
fn read_header(image: &[u8]) -> Result<ModuleKind, ImageError> {
    let header = image.first_chunk::<HEADER>().ok_or(ImageError::Length(image.len()))?;
    let [signature @ .., format, high, low, checksum_high, checksum_low] = header;
    if signature != SIGNATURE {
        return Err(ImageError::Signature);
    }
    let [said @ .., _, _] = header;
    if CRC.checksum(said).to_be_bytes() != [*checksum_high, *checksum_low] {
        return Err(ImageError::Header);
    }
    if *format != FORMAT {
        return Err(ImageError::Format(*format));
    }
    let number = u16::from_be_bytes([*high, *low]);
    let kind = ModuleKind::ALL.into_iter().find(|kind| kind.spec().number == number);
    kind.ok_or(ImageError::Module(number))
}

/// All that is damaged, in the order of what lies there. What is being erased may be anything.
fn damages(bytes: &[u8]) -> Vec<Damage> {
    let erasing = erasing(bytes);
    let erasure =
        cell::check::<RECORD>(bytes, ERASURE, 0).map(|(address, fault)| (Place::Erasure, address, fault));
    let records = records().enumerate().filter(|_| erasing != Some(Erasing::Records));
    let records = records.flat_map(|(cell, key)| {
        let faults = cell::check::<RECORD>(bytes, RECORDS, cell);
        faults.map(move |(address, fault)| (Place::Record(key), address, fault))
    });
    let instructions = (0..).take(PROGRAM.cells).filter(|_| erasing != Some(Erasing::Program));
    let instructions = instructions.flat_map(|number: u16| {
        let faults = cell::check::<INSTRUCTION>(bytes, PROGRAM, usize::from(number));
        faults.map(move |(address, fault)| (Place::Instruction(number), address, fault))
    });
    let found = erasure.chain(records).chain(instructions);
    found.map(|(place, address, fault)| Damage { address, place, fault }).collect()
}
