//! What the assembler makes of a text.

use tmcl_tables::ModuleSpec;

use crate::instruction::Instruction;
use crate::source::Span;

/// A label and what became of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LabelDefinition {
    /// As it was written where it is defined.
    pub name: String,
    /// Where it is defined.
    pub span: Span,
    /// The instruction it stands before.
    pub address: u16,
    /// How many instructions name it.
    pub uses: u32,
}

/// A definition of a constant; a name that is defined again has several.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ConstantDefinition {
    /// As it was written where it is defined.
    pub name: String,
    /// Where it is defined.
    pub span: Span,
    /// Its value.
    pub value: i64,
    /// How many operands and other definitions name it.
    pub uses: u32,
}

/// An assembled program.
#[derive(Clone, Debug)]
pub struct Program {
    /// The module it was assembled for.
    pub module: &'static ModuleSpec,
    /// What is downloaded, from address 0 on.
    pub instructions: Vec<Instruction>,
    /// Where each instruction was written; a STOP that the assembler appended has the end of the text.
    pub origins: Vec<Span>,
    /// Whether the last instruction is a STOP that the assembler appended.
    pub appended_stop: bool,
    /// The labels, in the order of their definitions.
    pub labels: Vec<LabelDefinition>,
    /// The constants, in the order of their definitions, those of built-in include files only where they are used.
    pub constants: Vec<ConstantDefinition>,
}

impl Program {
    /// Where the instruction at an address was written.
    #[must_use]
    pub fn origin(&self, address: u16) -> Option<Span> {
        self.origins.get(usize::from(address)).copied()
    }

    /// The label nearest above an address, and how far above.
    #[must_use]
    pub fn label_at(&self, address: u16) -> Option<(&LabelDefinition, u16)> {
        let above = self.labels.iter().filter(|label| label.address <= address);
        above.max_by_key(|label| label.address).map(|label| (label, address - label.address))
    }
}
