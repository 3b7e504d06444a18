//! Mnemonics.

use tmcl_tables::{Command, CommandSpec};

/// What is written in place of a mnemonic where an instruction is four numbers.
pub(crate) const DATA: &str = "DATA";

/// The command that program text calls so, in any case.
pub(crate) fn command(mnemonic: &str) -> Option<&'static CommandSpec> {
    let mut commands = Command::ALL.iter().map(|command| command.spec());
    commands.find(|spec| !spec.mnemonic.is_empty() && spec.mnemonic.eq_ignore_ascii_case(mnemonic))
}
