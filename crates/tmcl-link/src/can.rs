//! CAN: frames instead of bytes.
//!
//! - [`CanFrame`] is what a bus carries: an 11-bit identifier and up to eight bytes. [`CanLink`] carries it.
//! - [`slcan`] is the text in which serial adapters speak of frames, for both of its sides; [`SlcanLink`] is a bus behind such
//!   an adapter.
//! - [`SocketCan`] is a bus behind an interface of Linux.
//!
//! Nothing here knows what the bytes of a frame mean.

mod frame;
mod link;
pub mod slcan;
mod slcan_link;
mod socket;

pub use frame::{CanFrame, Data, FrameError, MAX_ID};
pub use link::CanLink;
pub use slcan_link::SlcanLink;
pub use socket::SocketCan;
