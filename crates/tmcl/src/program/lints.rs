//! Which warnings are reported.

use clap::Args;
use tmcl_lang::{Code, Severity};

/// Options of every command that reports warnings.
#[derive(Args, Clone, Debug, Default)]
pub(crate) struct LintOptions {
    /// Do not report this warning, such as W0011; may be given several times
    #[arg(long, value_name = "CODE", value_parser = warning)]
    pub(crate) allow: Vec<Code>,
    /// Report this warning, which is off otherwise, such as W0010; may be given several times
    #[arg(long, value_name = "CODE", value_parser = warning)]
    pub(crate) warn: Vec<Code>,
}

impl LintOptions {
    /// Whether findings of this code are reported. `--allow` beats `--warn`.
    pub(crate) fn reports(&self, code: Code) -> bool {
        let asked_for = code.is_on_by_default() || self.warn.contains(&code);
        asked_for && !self.allow.contains(&code)
    }
}

fn warning(text: &str) -> Result<Code, String> {
    let code: Code = text.parse().map_err(|_| "no such code; `tmcl explain` lists them".to_owned())?;
    match code.severity() {
        Severity::Warning => Ok(code),
        Severity::Error => Err("errors cannot be switched; a warning's code begins with W".to_owned()),
    }
}
