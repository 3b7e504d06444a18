//! Configuration files and what is wrong with them.

use std::io::IsTerminal;
use std::path::Path;

use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet};
use tmcl_config::file::{self, Config, Finding};
use tmcl_tables::ModuleSpec;

use crate::exit::{Code, Failure};

/// A configuration file, read and checked; - is stdin. What is wrong with it has been said with its place.
pub(crate) struct Loaded {
    pub(crate) config: Config,
    name: String,
    text: String,
}

/// Reads and checks a configuration file.
pub(crate) fn load(path: &Path) -> Result<Loaded, Failure> {
    let name = if path == Path::new("-") { "stdin".to_owned() } else { path.display().to_string() };
    let text = if path == Path::new("-") {
        std::io::read_to_string(std::io::stdin())
    } else {
        std::fs::read_to_string(path)
    };
    let text = text.map_err(|error| {
        Failure::new(Code::Usage, format!("cannot read the configuration file {name}: {error}"))
    })?;
    match file::parse(&text) {
        Ok(config) => Ok(Loaded { config, name, text }),
        Err(findings) => Err(wrong(&findings, &name, &text)),
    }
}

/// Whether the file is for this module; if not, that is said with its place.
pub(crate) fn belongs_to(loaded: &Loaded, module: &'static ModuleSpec) -> Result<(), Failure> {
    let Loaded { config, name, text } = loaded;
    if config.module == module {
        return Ok(());
    }
    let finding = Finding {
        message: format!("the file is for a {}, and a {} answers", config.module.name, module.name),
        span: config.module_span.clone(),
        help: None,
    };
    Err(wrong(&[finding], name, text))
}

fn wrong(findings: &[Finding], name: &str, text: &str) -> Failure {
    let reports: Vec<_> = findings.iter().map(|finding| report(finding, name, text)).collect();
    anstream::eprint!("{}", reports.concat());
    let count = match findings.len() {
        1 => "an error".to_owned(),
        count => format!("{count} errors"),
    };
    Failure::new(Code::Usage, format!("{count} in the configuration file {name}; nothing was written"))
}

fn report(finding: &Finding, name: &str, text: &str) -> String {
    let snippet =
        Snippet::source(text).path(name).annotation(AnnotationKind::Primary.span(finding.span.clone()));
    let mut group = Level::ERROR.primary_title(finding.message.as_str()).element(snippet);
    if let Some(help) = &finding.help {
        group = group.element(Level::HELP.message(help.as_str()));
    }
    let width =
        terminal_size::terminal_size_of(std::io::stderr()).map_or(140, |(width, _)| usize::from(width.0));
    let renderer = if std::io::stderr().is_terminal() { Renderer::styled() } else { Renderer::plain() };
    format!("{}\n\n", renderer.term_width(width).render(&[group]))
}
