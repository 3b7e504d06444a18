//! TMCL on the wire: requests and replies, as serial datagrams, as CAN frames and as ASCII lines.
//!
//! - [`Request`] and [`Reply`] are what travels, whatever carries it.
//! - [`serial`] is their nine-byte form, with [`Decoder`] to find requests in a stream of bytes.
//! - [`can`] is their seven- or eight-byte form.
//! - [`ascii`] is the form that people type.
//!
//! This crate must never know what a command does: numbers go through unjudged. It does no I/O, allocates nothing and
//! never panics, whatever bytes arrive; time is an argument.
#![no_std]
#![deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic)]

pub mod ascii;
pub mod can;
mod decoder;
mod message;
pub mod serial;

pub use decoder::{Decoder, Event, Listener};
pub use message::{Reply, Request};
