//! What commands, parameters, ports and interrupts each TMCL module has.
//!
//! The tables under [`mod@tmcm_1311`], [`mod@tmcm_1640`] and [`mod@tmcm_1076`] are generated from `data/` by
//! `cargo xtask codegen`; the types that hold them are written by hand in this crate. Firmware, language tools, clients
//! and documentation all read the same tables, so that a number is typed once.
//!
//! Without the feature `texts` the tables keep what a module needs, numbers and mnemonics; what is for people is empty. A
//! controller has no flash to spare for it.
//!
//! This crate must never know what a parameter *does*, nor who asks.
#![no_std]
#![deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod command;
mod generated;
mod markdown;
mod module;
mod parameter;
mod texts;

pub use command::{
    CommandSpec, Group, Mode, Modes, ModuleCommand, MotorField, NamedType, Operand, TypeField, ValueField,
};
pub use generated::{
    Command, GlobalParameter, Interrupt, MODULES, STATUSES, Status, commands, tmcm_1076, tmcm_1311, tmcm_1640,
};
pub use markdown::{CommandsMarkdown, ParametersMarkdown, Selection};
pub use module::{
    Direction, GlobalSpec, InterruptSpec, ModuleSpec, PortSpec, StatusSpec, UnknownModule, module_by_id,
};
pub use parameter::{Access, BitField, NamedValue, ParameterSpec, Role, Source, ValueSet};

use texts::{list, text};
