//! From a line of text to a command. The names of the built-in include files are defined, and those that the user defines.

use tmcl_lang::{Code, Diagnostic, Resolved, Resolver, Severity, SourceFile, Sources, assemble_commands};
use tmcl_tables::ModuleSpec;
use tmcl_wire::Request;

use crate::program::{diagnostics, files::BesideIncluder};

/// What the text that stands around a line is called. Nobody gets to see it.
const AROUND: &str = "";

/// What the text around includes a line as.
const LINE: &str = "line";

/// What can be said to a module.
#[derive(Clone, Debug)]
pub(crate) struct Language {
    module: &'static ModuleSpec,
    /// The constants that were defined so far, as they were written.
    definitions: String,
}

/// Where a line comes from, for messages.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spoken<'a> {
    /// What messages call the text.
    pub(crate) name: &'a str,
    /// Which of its lines this is, from 1.
    pub(crate) number: usize,
    /// The line.
    pub(crate) text: &'a str,
}

/// What a line is.
#[derive(Debug)]
pub(crate) enum Entered {
    /// A command.
    Command(Prepared),
    /// A constant, which counts from now on; or nothing but a comment.
    Nothing,
}

/// A command that can be sent.
#[derive(Debug)]
pub(crate) struct Prepared {
    /// What is sent.
    pub(crate) request: Request,
    /// What the tables have against it, for people; empty where they agree.
    pub(crate) doubts: String,
}

impl Language {
    pub(crate) fn of(module: &'static ModuleSpec) -> Self {
        Self { module, definitions: String::new() }
    }

    /// Assembles a line. An error is what is to be printed, diagnostics with the place they are about.
    ///
    /// What the module's tables have against a command, such as a parameter that they do not know, is no error: the module may
    /// be newer than the tables, and has the last word.
    pub(crate) fn understand(&mut self, line: Spoken<'_>) -> Result<Entered, String> {
        let around =
            format!("#include TMCLParam.tmc\n#include Interrupts.inc\n{}#include {LINE}\n", self.definitions);
        let root = SourceFile { name: AROUND.to_owned(), bytes: around.into_bytes(), builtin: false };
        let assembly = assemble_commands(root, self.module, &mut OneLine::of(line));
        let rendered = |errors: bool| -> String {
            let chosen = assembly.diagnostics.iter().filter(|diagnostic| {
                diagnostic.severity() == Severity::Error && is_doubt(diagnostic, &assembly.sources) != errors
            });
            chosen.map(|diagnostic| diagnostics::render(diagnostic, &assembly.sources)).collect()
        };
        let errors = rendered(true);
        if !errors.is_empty() {
            return Err(errors);
        }
        match assembly.program.instructions.as_slice() {
            [] => {
                if !assembly.program.labels.is_empty() {
                    return Err(sentence(line, "a label belongs into a program: no command is behind it"));
                }
                self.definitions += line.text;
                self.definitions.push('\n');
                Ok(Entered::Nothing)
            }
            [only] => Ok(Entered::Command(Prepared {
                request: Request::from_bytes(only.to_bytes()),
                doubts: rendered(false),
            })),
            _ => Err(sentence(line, "one command is expected on a line")),
        }
    }
}

fn sentence(line: Spoken<'_>, message: &str) -> String {
    format!("{}:{}: {message}\n\n", line.name, line.number)
}

/// Whether the command is what was written, and only the tables of the module have something against it.
fn is_doubt(diagnostic: &Diagnostic, sources: &Sources) -> bool {
    match diagnostic.code {
        Code::UnknownParameter
        | Code::ReadOnlyParameter
        | Code::WriteOnlyParameter
        | Code::NotStorable
        | Code::UnknownPort
        | Code::UnknownCoordinate
        | Code::UnknownInterrupt
        | Code::UnknownMotor => true,
        // A value that does not fit 32 bits became another one.
        Code::ParameterRange | Code::ValueRange => {
            let text = String::from_utf8_lossy(sources.bytes(diagnostic.primary.span));
            text.parse::<i32>().is_ok() || text.parse::<u32>().is_ok()
        }
        _ => false,
    }
}

/// Gives the line where the text around includes it, and files where the line does.
struct OneLine {
    line: Resolved,
}

impl OneLine {
    /// The line, at its place in the text that it comes from.
    fn of(line: Spoken<'_>) -> Self {
        let above = "\n".repeat(line.number.saturating_sub(1));
        let bytes = format!("{above}{}\n", line.text).into_bytes();
        Self { line: Resolved { name: line.name.to_owned(), bytes } }
    }
}

impl Resolver for OneLine {
    fn resolve(&mut self, includer: &str, name: &str) -> Result<Option<Resolved>, String> {
        match (includer, name) {
            (AROUND, LINE) => Ok(Some(self.line.clone())),
            (AROUND, _) => Ok(None),
            _ => BesideIncluder.resolve(includer, name),
        }
    }
}

#[cfg(test)]
mod tests {
    use tmcl_tables::{tmcm_1076, tmcm_1311};

    use super::*;

    fn entered(language: &mut Language, text: &str) -> Result<Entered, String> {
        language.understand(Spoken { name: "<here>", number: 3, text })
    }

    fn bytes(language: &mut Language, text: &str) -> [u8; 7] {
        match entered(language, text) {
            Ok(Entered::Command(command)) => {
                assert_eq!(command.doubts, "", "{text}");
                command.request.to_bytes()
            }
            other => panic!("{text}: {other:?}"),
        }
    }

    #[test]
    fn commands_with_the_names_of_the_built_in_files() {
        let mut language = Language::of(&tmcm_1311::SPEC);
        assert_eq!(bytes(&mut language, "MVP ABS, 0, 51200"), [4, 0, 0, 0, 0, 0xC8, 0]);
        assert_eq!(
            bytes(&mut language, "gap apactualposition, Motor0 // where is it?"),
            [6, 1, 0, 0, 0, 0, 0]
        );
        assert_eq!(bytes(&mut language, "DATA 136, 1, 0, 0"), [136, 1, 0, 0, 0, 0, 0]);
        assert!(matches!(entered(&mut language, "Turn = 51200"), Ok(Entered::Nothing)));
        assert!(matches!(entered(&mut language, "// nothing"), Ok(Entered::Nothing)));
        assert_eq!(bytes(&mut language, "MVP REL, 0, -Turn"), [4, 1, 0, 0xFF, 0xFF, 0x38, 0]);
        assert_eq!(bytes(&mut Language::of(&tmcm_1076::SPEC), "SAP 6, 0, 31"), [5, 6, 0, 0, 0, 0, 31]);
    }

    #[test]
    fn what_the_tables_doubt_is_sent_nevertheless() {
        let mut language = Language::of(&tmcm_1311::SPEC);
        for text in
            ["GAP 250, 0", "GAP 29, 0", "SAP 140, 0, 9", "SAP 1, 0, -2147483648", "GAP 1, 3", "SIO 9, 2, 1"]
        {
            match entered(&mut language, text) {
                Ok(Entered::Command(command)) => {
                    assert!(text.contains("-2147483648") || !command.doubts.is_empty());
                }
                other => panic!("{text}: {other:?}"),
            }
        }
    }

    #[test]
    fn errors_name_the_place() {
        let mut language = Language::of(&tmcm_1311::SPEC);
        let wrong = [
            "MPV ABS, 0, 1",
            "GAP",
            "GAP Speed, 0",
            "JA 5",
            "Loop:",
            "SAP 140, 0, 5000000000",
            "SAP 140, 0, -4000000000",
        ];
        for text in wrong {
            let error = entered(&mut language, text).expect_err(text);
            assert!(error.contains("<here>:3"), "{error}");
        }
    }

    proptest::proptest! {
        #![proptest_config(proptest::prelude::ProptestConfig::with_cases(32))]

        #[test]
        fn any_line_is_understood_or_refused(text in "\\PC{0,40}") {
            let _ = entered(&mut Language::of(&tmcm_1311::SPEC), &text);
        }
    }
}
