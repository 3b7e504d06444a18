//! A request in words, for messages.

use std::fmt;

use tmcl_tables::{Command, CommandSpec, Operand};
use tmcl_wire::Request;

/// A request as program text writes it; a command that only a host sends, by its name and number.
#[derive(Clone, Copy, Debug)]
pub struct Described(pub Request);

impl fmt::Display for Described {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(request) = self;
        match Command::try_from(request.command).map(Command::spec) {
            Ok(spec) if !spec.mnemonic.is_empty() => self.as_text(f, spec),
            Ok(spec) => {
                write!(f, "\"{}\" (command {}", spec.name, spec.number)?;
                self.fields(f)
            }
            Err(number) => {
                write!(f, "unknown command {number} (")?;
                write!(f, "type {}, motor {}, value {})", request.kind, request.motor, request.value)
            }
        }
    }
}

impl Described {
    fn as_text(&self, f: &mut fmt::Formatter<'_>, spec: &CommandSpec) -> fmt::Result {
        f.write_str(spec.mnemonic)?;
        for (index, operand) in spec.operands.iter().enumerate() {
            f.write_str(if index == 0 { " " } else { ", " })?;
            match operand {
                Operand::Type => self.write_type(f, spec)?,
                Operand::Motor => write!(f, "{}", self.0.motor)?,
                Operand::Value => write!(f, "{}", self.0.value)?,
            }
        }
        Ok(())
    }

    fn write_type(&self, f: &mut fmt::Formatter<'_>, spec: &CommandSpec) -> fmt::Result {
        let named = spec.types.iter().find(|named| named.value == self.0.kind);
        match named.filter(|named| !named.keyword.is_empty()) {
            Some(named) => f.write_str(named.keyword),
            None => write!(f, "{}", self.0.kind),
        }
    }

    fn fields(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(Request { kind, motor, value, .. }) = self;
        let fields = [("type", i64::from(*kind)), ("motor", i64::from(*motor)), ("value", i64::from(*value))];
        for (name, number) in fields.iter().filter(|(_, number)| *number != 0) {
            write!(f, ", {name} {number}")?;
        }
        f.write_str(")")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_read_like_program_text() {
        let text =
            |command, kind, motor, value| Described(Request { command, kind, motor, value }).to_string();
        assert_eq!(text(5, 4, 0, 51_200), "SAP 4, 0, 51200");
        assert_eq!(text(6, 1, 0, 0), "GAP 1, 0");
        assert_eq!(text(4, 1, 0, -1000), "MVP REL, 0, -1000");
        assert_eq!(text(3, 0, 0, 0), "MST 0");
        assert_eq!(text(134, 0, 0, 17), "\"Read program memory\" (command 134, value 17)");
        assert_eq!(text(131, 0, 0, 0), "\"Reset application\" (command 131)");
        assert_eq!(text(200, 1, 2, 3), "unknown command 200 (type 1, motor 2, value 3)");
    }
}
