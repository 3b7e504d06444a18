//! Parameters of a module as people write them, and where the module is.
//!
//! - [`Name`] is what stands for a parameter on a command line or in a file: `max_velocity`, `axis.4`, `0/66`,
//!   `variable.3`, `encoder_mode.null_active_high`; [`select`] also takes `max_*`.
//! - [`parse_value`] reads what it is to be set to: a number with or without its unit, or the name of a value.
//! - [`file::parse`] and [`file::write`] read and write the configuration of a module as a text.
//! - [`connection::parse`] reads `tmcl.toml`, which says where a module is, and [`connection`] what its settings take anywhere.
//! - [`plan`](plan()) says in which order to write what differs, and what not to write at all.
//!
//! This crate must never know a module that answers, a link or a file: it has texts, tables and numbers.

pub mod connection;
pub mod file;
mod finding;
mod item;
mod name;
mod plan;
mod suggest;
mod time;
mod value;
mod wildcard;

pub use item::{Item, items};
pub use name::{Name, NameError, select};
pub use plan::{Difference, Left, Phase, Plan, Wishes, plan};
pub use time::nanoseconds;
pub use value::{ValueError, described, parse_value};
