//! The text in which serial CAN adapters speak of frames: LAWICEL's protocol of the CAN232 and CANUSB, called slcan.
//!
//! A host sends lines that end with CR; the adapter answers each with CR when it is done, with BEL when it is not, and sends
//! a line of its own for every frame that it hears.
//!
//! | host | means | answer |
//! |---|---|---|
//! | `S0` … `S8` | bit rate, [`BitRate`] | CR |
//! | `sXXYY` | bit rate as two registers of the SJA1000 | CR |
//! | `O`, `L`, `C` | open the bus, open it to listen only, close it | CR |
//! | `tIIILDD…` | frame with 11-bit identifier, length and data, in hexadecimal | `z` CR |
//! | `TIIIIIIIILDD…` | the same with 29 bits | `Z` CR |
//! | `rIIIL`, `RIIIIIIIIL` | the same without data: a request for a frame | `z` CR, `Z` CR |
//! | `F` | status flags | `FXX` CR |
//! | `V`, `N` | version, serial number | `VXXXX` CR, `NXXXX` CR |
//! | `Z0`, `Z1` | frames that are heard carry no time stamp, or one: 4 digits, milliseconds from 0 to 59 999 | CR |
//!
//! [`Command`] and [`CommandDecoder`] are the adapter's side, [`Reply`] and [`ReplyDecoder`] the host's. Both decoders take
//! bytes one by one, and after whatever noise they are in step again at the next CR.

mod bit_rate;
mod command;
mod line;
mod packet;
mod reply;

pub use bit_rate::BitRate;
pub use command::{Command, CommandDecoder, CommandError};
pub use packet::{MAX_EXTENDED_ID, Packet};
pub use reply::{Reply, ReplyDecoder};

/// Ends a line; alone, the answer "done".
pub const CR: u8 = b'\r';

/// The answer "not done".
pub const BEL: u8 = 0x07;
