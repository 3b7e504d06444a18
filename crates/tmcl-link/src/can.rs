//! CAN: frames instead of bytes.
//!
//! - [`CanFrame`] is what a bus carries: an 11-bit identifier and up to eight bytes.
//! - [`slcan`] is the text in which serial adapters speak of frames, for both of its sides.
//!
//! Nothing here knows what the bytes of a frame mean.

mod frame;
pub mod slcan;

pub use frame::{CanFrame, Data, FrameError, MAX_ID};
