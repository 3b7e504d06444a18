//! TMCL program text ⇄ program.
//!
//! - [`syntax`] turns bytes into a lossless tree: every file yields one, whatever is in it.
//! - [`assemble()`] turns a file and what it includes into a [`Program`] for a module.
//! - [`lint`] looks at a program's flow for what is legal but hardly meant.
//! - [`disassemble()`] turns instructions back into text that assembles to the same bytes.
//! - [`format()`] lays text out; comments are kept, and formatting twice is the same as once.
//! - [`image`] is the compiled file, eight bytes an instruction.
//!
//! Everything returns its value together with [`Diagnostic`]s and never fails outright. This crate must never do I/O: it
//! takes bytes and a [`Resolver`] for includes. It must never know the firmware; they agree through `tmcl-tables` and
//! through bytes.

pub mod assemble;
mod builtin;
mod code;
mod diagnostic;
mod disassemble;
mod format;
pub mod image;
mod instruction;
pub mod lint;
mod program;
mod resolver;
mod source;
pub mod syntax;

pub use assemble::{Assembly, assemble, assemble_commands};
pub use builtin::{BUILTIN_INCLUDES, builtin_include};
pub use code::{Code, UnknownCode};
pub use diagnostic::{Diagnostic, Label, Severity, Suggestion};
pub use disassemble::disassemble;
pub use format::format;
pub use instruction::Instruction;
pub use program::{ConstantDefinition, LabelDefinition, Program};
pub use resolver::{NoIncludes, Resolved, Resolver};
pub use source::{FileId, Position, SourceFile, Sources, Span};
