//! The stable codes of diagnostics.
//!
//! A code never changes its meaning; a retired one is not used again. The texts of `tmcl explain` are in `code/`.

use crate::diagnostic::Severity;

macro_rules! codes {
    ($($variant:ident = $id:literal, $summary:literal;)*) => {
        /// The code of a diagnostic.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Code {
            $(#[doc = concat!($id, ": ", $summary, ".")] $variant,)*
        }

        impl Code {
            /// Every code, errors first.
            pub const ALL: &[Self] = &[$(Self::$variant),*];

            /// What people and scripts know it by, such as `E0101`.
            #[must_use]
            pub const fn id(self) -> &'static str {
                match self { $(Self::$variant => $id),* }
            }

            /// What it says in general, in a line.
            #[must_use]
            pub const fn summary(self) -> &'static str {
                match self { $(Self::$variant => $summary),* }
            }

            /// What `tmcl explain` says: what it means, an example, and what to do.
            #[must_use]
            pub const fn explanation(self) -> &'static str {
                match self { $(Self::$variant => include_str!(concat!("code/", $id, ".md"))),* }
            }
        }
    };
}

codes! {
    UnexpectedCharacter = "E0001", "a character that has no meaning here";
    UnexpectedToken = "E0002", "something else is expected here";
    NumberTooLarge = "E0003", "a number that does not fit 32 bits";
    UnknownMnemonic = "E0101", "no such command";
    OperandCount = "E0102", "wrong number of operands";
    OperandKind = "E0103", "a keyword, number or label that does not fit this operand";
    UndefinedName = "E0104", "a name that is not defined above";
    UndefinedLabel = "E0105", "a label that is nowhere defined";
    DuplicateLabel = "E0106", "a label that is defined twice";
    OperandRange = "E0107", "a number that does not fit its field";
    CommandMissing = "E0201", "a command that the module lacks";
    UnknownParameter = "E0202", "a parameter that the module lacks";
    ReadOnlyParameter = "E0203", "a read-only parameter is written";
    WriteOnlyParameter = "E0204", "a write-only parameter is read";
    NotStorable = "E0205", "a parameter that is not kept in the EEPROM is stored or restored";
    ParameterRange = "E0206", "a value that the parameter does not take";
    UnknownPort = "E0207", "an input or output that the module lacks";
    UnknownCoordinate = "E0208", "a coordinate that the module lacks";
    UnknownInterrupt = "E0209", "an interrupt that the module lacks";
    UnknownMotor = "E0210", "a motor that the module lacks";
    ProgramTooLong = "E0211", "the program does not fit the program memory";
    UnknownModule = "E0212", "no module of that name";
    ValueRange = "E0213", "a value that the command does not take";
    IncludeNotFound = "E0301", "an included file that cannot be found or read";
    IncludeCycle = "E0302", "a file that includes itself";
    Unreachable = "W0001", "instructions that are never reached";
    RunsOff = "W0002", "the program can run past its last instruction";
    NestingTooDeep = "W0003", "subroutine calls can nest deeper than eight";
    Recursion = "W0004", "a subroutine can call itself";
    StrayInterruptReturn = "W0005", "RETI can be reached outside an interrupt routine";
    StraySubroutineReturn = "W0006", "RSUB can be reached outside a subroutine";
    InterruptWithoutVector = "W0007", "an interrupt is enabled that has no vector";
    InterruptsNeverOn = "W0008", "interrupts are enabled, but never as a whole";
    DivisionByZero = "W0009", "a division by the constant zero";
    WaitWithoutTimeout = "W0010", "a WAIT that may never end";
    UnusedLabel = "W0011", "a label that nothing names";
    UnusedConstant = "W0012", "a constant that nothing names";
    JumpBeyondProgram = "W0013", "a jump to where the program has no instruction";
    StrayComma = "W0014", "a comma after the mnemonic";
    SurplusOperand = "W0015", "an operand that the command does not take";
    SubroutineReturnInInterrupt = "W0016", "an interrupt routine can end with RSUB or STOP, or RETI inside a subroutine, or never return";
    NegativeTime = "W0017", "a negative time, which is no time";
}

/// No such code; the known ones are in [`Code::ALL`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no code `{0}`")]
pub struct UnknownCode(pub String);

impl Code {
    /// How bad it is.
    #[must_use]
    pub const fn severity(self) -> Severity {
        match self.id().as_bytes().first() {
            Some(b'E') => Severity::Error,
            _ => Severity::Warning,
        }
    }

    /// Whether it is reported unless somebody says otherwise.
    #[must_use]
    pub const fn is_on_by_default(self) -> bool {
        !matches!(self, Self::WaitWithoutTimeout)
    }
}

impl core::str::FromStr for Code {
    type Err = UnknownCode;

    fn from_str(text: &str) -> Result<Self, UnknownCode> {
        let found = Self::ALL.iter().find(|code| code.id().eq_ignore_ascii_case(text));
        found.copied().ok_or_else(|| UnknownCode(text.to_owned()))
    }
}

impl core::fmt::Display for Code {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.pad(self.id())
    }
}
