//! Commands of direct mode as text: assembled for the module, sent, and what comes back in words. `tmcl exec` and `tmcl shell`
//! share it.

mod exchange;
mod item;
mod language;
mod meaning;
mod refusal;

pub(crate) use exchange::{Answer, Exchange, send};
pub(crate) use item::{reading, writing};
pub(crate) use language::{Entered, Language, Prepared, Spoken};
pub(crate) use meaning::Meaning;
pub(crate) use refusal::refusal;
