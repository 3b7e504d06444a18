//! Commands of direct mode as text: assembled for the module, sent, and what comes back in words. `tmcl exec`, `tmcl shell`
//! and `tmcl run` share it.

mod commands;
mod exchange;
mod item;
mod language;
mod meaning;
mod refusal;

pub(crate) use commands::{lines, reason, understood};
pub(crate) use exchange::{Answer, Exchange, ask, hexadecimal, send};
pub(crate) use item::{reading, writing};
pub(crate) use language::{Entered, Language, Prepared, Spoken};
pub(crate) use meaning::Meaning;
pub(crate) use refusal::{addresses, refusal};
