//! Parameters of a module: reading, writing, and bringing a whole configuration into it.
//!
//! What they are called and what they may hold is the business of `tmcl-config`; here is where a module answers.

mod access;
mod apply;
mod files;
mod row;
mod spark;
#[cfg(test)]
mod tests;

pub(crate) use access::{
    Storage, closed_loop, read, read_all, refused, restore, spelled, storage, store, write,
};
pub(crate) use apply::{Progress, apply, differences};
pub(crate) use files::{belongs_to, load};
pub(crate) use row::{Row, Which, unit};
pub(crate) use spark::spark;

use tmcl_config::{Item, Name, NameError, select};
use tmcl_tables::ModuleSpec;

use crate::exit::{Code, Failure};

/// The parameters that the command line names, all of which have to be `usable`, else they are `complaint`.
pub(crate) fn named(
    texts: &[String],
    module: &'static ModuleSpec,
    usable: impl Fn(Item) -> bool,
    complaint: &str,
) -> Result<Vec<Name>, Failure> {
    let names = select(texts, module, &usable).map_err(|error| wrong_name(&error))?;
    match names.iter().find(|name| !usable(name.item)) {
        Some(name) => Err(Failure::new(Code::Usage, format!("`{name}` {complaint}"))),
        None => Ok(names),
    }
}

/// How a command ends when there is no such parameter.
pub(crate) fn wrong_name(error: &NameError) -> Failure {
    Failure::new(Code::Usage, error.to_string())
}
