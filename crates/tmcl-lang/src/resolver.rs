//! How the assembler gets at included files without doing I/O itself.

/// An included file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Resolved {
    /// What messages call it; two includes of the same file must yield the same name, or a cycle is not seen.
    pub name: String,
    /// What it holds.
    pub bytes: Vec<u8>,
}

/// Finds included files.
pub trait Resolver {
    /// The file that `includer` (its name, as this resolver or the caller gave it) means by `#include name`; None where
    /// there is none. The built-in include files are tried after that.
    ///
    /// # Errors
    /// Why a file that is there cannot be read, for people.
    fn resolve(&mut self, includer: &str, name: &str) -> Result<Option<Resolved>, String>;
}

/// A program that stands alone: nothing but the built-in files can be included.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoIncludes;

impl Resolver for NoIncludes {
    fn resolve(&mut self, _includer: &str, _name: &str) -> Result<Option<Resolved>, String> {
        Ok(None)
    }
}
