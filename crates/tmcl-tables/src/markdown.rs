//! The tables as Markdown, for `tmcl params --markdown`, `tmcl commands --markdown` and the generated reference pages.

use core::fmt::{Display, Formatter, Result};

use crate::{GlobalSpec, ModuleSpec, ParameterSpec, Source};

/// Which parameters of a module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Selection {
    /// Axis parameters, then every bank.
    All,
    /// Axis parameters only.
    Axis,
    /// Global parameters of one bank.
    Bank(u8),
}

impl Selection {
    /// Whether axis parameters are among them.
    #[must_use]
    pub fn has_axis(self) -> bool {
        matches!(self, Self::All | Self::Axis)
    }

    /// Whether the global parameters of `bank` are among them.
    #[must_use]
    pub fn has_bank(self, bank: u8) -> bool {
        self == Self::All || self == Self::Bank(bank)
    }
}

/// Parameters of a module as a Markdown page.
pub struct ParametersMarkdown<'a> {
    /// The module.
    pub module: &'a ModuleSpec,
    /// Which of its parameters.
    pub selection: Selection,
}

/// Every command of a module as a Markdown table.
pub struct CommandsMarkdown<'a>(pub &'a ModuleSpec);

impl Display for ParametersMarkdown<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        writeln!(f, "# {} parameters\n", self.module.name)?;
        writeln!(f, "Marked †: not printed in the manual, chosen by OpenTMCL.")?;
        if self.selection.has_axis() {
            writeln!(f, "\n## Axis parameters\n")?;
            write_header(f)?;
            for parameter in self.module.axis_parameters {
                write_row(f, parameter, parameter.number)?;
            }
        }
        for bank in [0, 2, 3] {
            let globals = self.module.global_parameters;
            let entries = || globals.iter().filter(move |entry| entry.bank == bank);
            if !self.selection.has_bank(bank) || entries().next().is_none() {
                continue;
            }
            writeln!(f, "\n## Global parameters, bank {bank}\n")?;
            write_header(f)?;
            for GlobalSpec { parameter, last, .. } in entries() {
                write_row(f, parameter, *last)?;
            }
        }
        Ok(())
    }
}

fn write_header(f: &mut Formatter<'_>) -> Result {
    writeln!(f, "| number | identifier | name | range | unit | default | access | § | meaning |")?;
    writeln!(f, "|---:|---|---|---|---|---:|---|---|---|")
}

fn write_row(f: &mut Formatter<'_>, parameter: &ParameterSpec, last: u8) -> Result {
    write!(f, "| {}", parameter.number)?;
    if last > parameter.number {
        write!(f, "…{last}")?;
    }
    write!(
        f,
        " | `{}` | {} | {}{}",
        parameter.id,
        parameter.name,
        parameter.range,
        mark(parameter.range_from)
    )?;
    if parameter.write_range != parameter.range {
        write!(f, "; write {}", parameter.write_range)?;
    }
    write!(f, " | {}", parameter.unit)?;
    if parameter.closed_loop_unit != parameter.unit {
        write!(f, ", closed loop {}", parameter.closed_loop_unit)?;
    }
    write!(
        f,
        " | {}{} | {} | {} | {}",
        parameter.default,
        mark(parameter.default_from),
        parameter.access,
        parameter.section,
        parameter.summary
    )?;
    for named in parameter.values {
        write!(f, "<br>{} = {}", named.value, named.name)?;
    }
    for field in parameter.fields {
        match (field.low, field.high) {
            (low, high) if low == high => write!(f, "<br>bit {low}: {}", field.name)?,
            (low, high) => write!(f, "<br>bits {high}:{low}: {}", field.name)?,
        }
    }
    if !parameter.beyond_manual.is_empty() {
        write!(f, "<br>*Beyond the manual: {}*", parameter.beyond_manual)?;
    }
    if !parameter.note.is_empty() {
        write!(f, "<br>*{}*", parameter.note)?;
    }
    writeln!(f, " |")
}

fn mark(source: Source) -> &'static str {
    match source {
        Source::Manual => "",
        Source::Chosen => "†",
    }
}

impl Display for CommandsMarkdown<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        writeln!(f, "# {} commands\n", self.0.name)?;
        writeln!(f, "| number | mnemonic | name | types | direct | program | § | meaning |")?;
        writeln!(f, "|---:|---|---|---|---|---|---|---|")?;
        for entry in self.0.commands {
            let spec = entry.spec;
            write!(f, "| {} | {} | {} | ", spec.number, spec.mnemonic, spec.name)?;
            for (index, named) in entry.named_types().enumerate() {
                let separator = if index == 0 { "" } else { "<br>" };
                let text = if named.keyword.is_empty() { named.name } else { named.keyword };
                write!(f, "{separator}{} = {text}", named.value)?;
            }
            let tick = |allowed| if allowed { "✓" } else { "" };
            write!(f, " | {} | {} | {}", tick(entry.modes.direct), tick(entry.modes.program), entry.section)?;
            write!(f, " | {}", spec.summary)?;
            if !entry.beyond_manual.is_empty() {
                write!(f, "<br>*Beyond the manual: {}*", entry.beyond_manual)?;
            }
            if !spec.note.is_empty() {
                write!(f, "<br>*{}*", spec.note)?;
            }
            writeln!(f, " |")?;
        }
        Ok(())
    }
}
