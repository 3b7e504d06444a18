//! `tmcl explain`: what a diagnostic's code means.

use serde::Serialize;
use tmcl_lang::{Code, Severity};

use crate::arguments::Explain;
use crate::exit::Outcome;
use crate::print;

#[derive(Serialize)]
struct CodeJson {
    code: &'static str,
    severity: &'static str,
    on_by_default: bool,
    summary: &'static str,
    explanation: &'static str,
}

/// Runs it: one code, or a list of all.
pub(crate) fn run(options: &Explain) -> Outcome {
    let codes = options.code.as_ref().map_or(Code::ALL, std::slice::from_ref);
    if options.json {
        return Ok(print::json(&codes.iter().map(|code| to_json(*code)).collect::<Vec<_>>())?);
    }
    match options.code {
        Some(code) => {
            print::text(&format!("{code}: {}\n\n{}\n", code.summary(), code.explanation().trim_end()))?;
        }
        None => print::table(
            ["code", "on", "what it says"],
            codes.iter().map(|code| {
                let on = if code.is_on_by_default() { "yes" } else { "--warn" };
                [code.id().to_owned(), on.to_owned(), code.summary().to_owned()]
            }),
        )?,
    }
    Ok(())
}

fn to_json(code: Code) -> CodeJson {
    CodeJson {
        code: code.id(),
        severity: match code.severity() {
            Severity::Error => "error",
            Severity::Warning => "warning",
        },
        on_by_default: code.is_on_by_default(),
        summary: code.summary(),
        explanation: code.explanation(),
    }
}
