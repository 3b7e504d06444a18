//! Lines at the top of a program that say how it is meant: `//! module: tmcm-1311`, `//! no-final-stop` (decision §4 and
//! our own).

use core::ops::Range;

use tmcl_tables::{MODULES, Mode, ModuleSpec, module_by_id, tmcm_1311};

use super::suggest::NearMisses;
use super::words;
use crate::code::Code;
use crate::diagnostic::Diagnostic;
use crate::source::{Sources, Span};
use crate::syntax::File;

/// The module that a program is for.
pub(super) struct Target {
    pub(super) module: &'static ModuleSpec,
    /// Whether a program holds the commands, or a host sends them.
    pub(super) mode: Mode,
    /// Whether the caller or the file said so.
    pub(super) is_named: bool,
    /// Whether it is the one that was meant; without it nothing can be said of parameters and ports.
    pub(super) is_known: bool,
    /// Whether a STOP follows a program that does not end; the line `//! no-final-stop` says no.
    pub(super) appends_stop: bool,
    pub(super) diagnostic: Option<Diagnostic>,
}

/// The caller's module, or the one that the file names, or else the TMCM-1311.
pub(super) fn target(module: Option<&'static ModuleSpec>, file: &File, bytes: &[u8]) -> Target {
    let appends_stop = !says_no_final_stop(file, bytes);
    let named = |module| Target {
        module,
        mode: Mode::Program,
        is_named: true,
        is_known: true,
        appends_stop,
        diagnostic: None,
    };
    if let Some(module) = module {
        return named(module);
    }
    let Some((name, span)) = named_module(file, bytes) else {
        return Target { is_named: false, ..named(&tmcm_1311::SPEC) };
    };
    match module_by_id(&name) {
        Ok(module) => named(module),
        Err(_) => Target {
            is_known: false,
            diagnostic: Some(unknown_module(&name, span)),
            ..named(&tmcm_1311::SPEC)
        },
    }
}

fn unknown_module(name: &str, span: Span) -> Diagnostic {
    let ids = || MODULES.iter().map(|module| module.id);
    let message = match name {
        "" => "no module is named here".to_owned(),
        name => format!("there is no module `{}`", words::shortened(name)),
    };
    let known = words::list(&ids().collect::<Vec<_>>(), "and");
    let diagnostic =
        Diagnostic::new(Code::UnknownModule, span, message).note(format!("the modules are {known}"));
    match NearMisses::default().nearest(name, ids()) {
        Some(id) => diagnostic.suggest(span, id, "a module has a similar name"),
        None => diagnostic,
    }
}

/// What the first line `//! module: …` among the comments at the top says, and where.
fn named_module(file: &File, bytes: &[u8]) -> Option<(String, Span)> {
    comments(file).find_map(|comment| {
        let text = bytes.get(comment.clone())?;
        let value = after_key(text)?;
        let start = comment.end - value.len();
        let name = value.trim_ascii_end();
        let span = Span::new(Sources::ROOT, start..start + name.len());
        Some((String::from_utf8_lossy(name).into_owned(), span))
    })
}

/// Whether one of the comments at the top is `//! no-final-stop`.
fn says_no_final_stop(file: &File, bytes: &[u8]) -> bool {
    let texts = comments(file).filter_map(|comment| bytes.get(comment)?.strip_prefix(b"//!"));
    texts.into_iter().any(|text| text.trim_ascii().eq_ignore_ascii_case(b"no-final-stop"))
}

/// Where the comments at the top stand.
fn comments(file: &File) -> impl Iterator<Item = Range<usize>> {
    let header = file
        .lines
        .iter()
        .take_while(|line| line.labels.is_empty() && line.statement.is_none() && !line.has_errors);
    header.filter_map(|line| Some(file.tokens.get(line.comment?)?.range()))
}

/// What follows `//! module:` and its spaces.
fn after_key(comment: &[u8]) -> Option<&[u8]> {
    let text = comment.strip_prefix(b"//!")?.trim_ascii_start();
    let (key, rest) = text.split_at_checked(b"module".len())?;
    let rest = rest.trim_ascii_start().strip_prefix(b":")?;
    key.eq_ignore_ascii_case(b"module").then(|| rest.trim_ascii_start())
}

#[cfg(test)]
mod tests {
    use super::after_key;

    #[test]
    fn the_key_is_found_in_any_case_and_with_any_spaces() {
        assert_eq!(after_key(b"//! module: tmcm-1311"), Some(&b"tmcm-1311"[..]));
        assert_eq!(after_key(b"//!MODULE  :1640 "), Some(&b"1640 "[..]));
        assert_eq!(after_key(b"//! module:"), Some(&b""[..]));
        assert_eq!(after_key(b"// module: tmcm-1311"), None);
        assert_eq!(after_key(b"//! modules: tmcm-1311"), None);
        assert_eq!(after_key(b"//! mod"), None);
    }
}
