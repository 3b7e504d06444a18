//! Text to tree. Every file yields a tree; what makes no sense is reported and skipped, and no byte is lost: the texts of
//! [`File::tokens`] one after the other are the file.
//!
//! ```text
//! line      = label* statement? comment?
//! label     = NAME ':'
//! statement = NAME ','? (operand (',' operand)*)?     an instruction
//!           | NAME '=' operand                        a constant
//!           | '#include' path
//! operand   = '-'? (NUMBER | NAME)
//! ```
//!
//! Numbers are decimal, `$1F` or `0x1F`; names are ASCII letters, digits and `_`, not beginning with a digit, in any case;
//! comments begin with `//` or `;` and end with the line. A path in quotes ends with them, another one where a comment or
//! the end of the line begins. Lines end with `\n`, `\r\n` or `\r`.

mod command;
mod complaint;
mod lexer;
mod number;
mod parser;
mod token;
mod tree;

pub(crate) use command::{DATA, command};
pub use lexer::lex;
pub(crate) use lexer::{BYTE_ORDER_MARK, is_space};
pub use parser::{Parse, parse};
pub use token::{Token, TokenKind};
pub use tree::{Constant, File, Include, InstructionSyntax, Line, Name, Operand, OperandKind, Statement};
