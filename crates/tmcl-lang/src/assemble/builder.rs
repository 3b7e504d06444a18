//! From lines to instructions.

use std::collections::BTreeMap;

use tmcl_tables::{CommandSpec, Mode, ModuleSpec, commands};

use super::check;
use super::count;
use super::header::Target;
use super::load::Loaded;
use super::names::{Names, Number};
use super::operand::At;
use super::suggest::NearMisses;
use super::words;
use crate::builtin::{BuiltinName, builtin_names};
use crate::code::Code;
use crate::diagnostic::Diagnostic;
use crate::instruction::Instruction;
use crate::program::Program;
use crate::source::{FileId, Sources, Span};
use crate::syntax::{Constant, DATA, InstructionSyntax, Name, Statement};

/// An instruction whose operands were read. A field is None where no operand writes it, or where its operand was complained
/// about.
#[derive(Clone, Copy)]
pub(super) struct Read {
    pub(super) spec: &'static CommandSpec,
    /// Where the mnemonic stands.
    pub(super) mnemonic: Span,
    pub(super) kind: Option<At<u8>>,
    pub(super) motor: Option<At<u8>>,
    pub(super) value: Option<At<Number>>,
}

impl Read {
    fn instruction(&self) -> Instruction {
        Instruction {
            command: self.spec.number,
            kind: self.kind.map_or(0, |kind| kind.value),
            motor: self.motor.map_or(0, |motor| motor.value),
            value: self.value.map_or(0, |value| check::wrapped(value.value)),
        }
    }
}

/// Makes the program, line by line.
pub(super) struct Builder<'a> {
    loaded: &'a Loaded,
    pub(super) module: &'static ModuleSpec,
    mode: Mode,
    /// Whether commands, parameters and the like are held against the module's tables.
    pub(super) checks_module: bool,
    /// Whether a STOP follows a program that does not end.
    appends_stop: bool,
    pub(super) names: Names,
    pub(super) near: NearMisses,
    /// What the built-in files would define, once a name was not found.
    builtin_names: Option<BTreeMap<String, BuiltinName>>,
    diagnostics: Vec<Diagnostic>,
    instructions: Vec<Instruction>,
    origins: Vec<Span>,
}

impl<'a> Builder<'a> {
    pub(super) fn new(loaded: &'a Loaded, target: &Target, names: Names) -> Self {
        let module = target.module;
        Self {
            loaded,
            module,
            mode: target.mode,
            checks_module: target.is_known && (target.mode == Mode::Direct || module.program_memory > 0),
            appends_stop: target.appends_stop,
            names,
            near: NearMisses::default(),
            builtin_names: None,
            diagnostics: Vec::new(),
            instructions: Vec::new(),
            origins: Vec::new(),
        }
    }

    pub(super) fn complain(&mut self, diagnostic: Diagnostic) {
        self.diagnostics.push(diagnostic);
    }

    /// The built-in file that would define a name, were it included.
    pub(super) fn builtin_file(&mut self, name: &str) -> Option<&'static str> {
        let module = self.module;
        let names = self.builtin_names.get_or_insert_with(|| builtin_names(module));
        names.get(&name.to_ascii_lowercase()).map(|known| known.file)
    }

    /// What the built-in files would define that has a similar name.
    pub(super) fn near_builtin(&mut self, name: &str) -> Option<BuiltinName> {
        let module = self.module;
        let names = self.builtin_names.get_or_insert_with(|| builtin_names(module));
        let nearest = self.near.nearest(name, names.keys().map(String::as_str))?;
        names.get(nearest).cloned()
    }

    /// The bytes of the text at a place.
    pub(super) fn text(&self, span: Span) -> &'a [u8] {
        self.loaded.sources.bytes(span)
    }

    pub(super) fn build(mut self) -> (Program, Vec<Diagnostic>) {
        let loaded = self.loaded;
        for (file, line) in loaded.lines() {
            match &line.statement {
                Some(Statement::Constant(constant)) => self.constant(file, constant, line.has_errors),
                Some(Statement::Instruction(syntax)) => self.instruction(syntax, line.has_errors),
                Some(Statement::Include(_)) | None => {}
            }
        }
        self.finish()
    }

    fn constant(&mut self, file: FileId, constant: &Constant, has_errors: bool) {
        let number = if has_errors { None } else { self.constant_value(&constant.value) };
        self.names.define_constant(&constant.name, number, self.loaded.is_builtin(file));
    }

    /// Adds an instruction. One that nothing can be made of still takes its place, so that addresses stay.
    fn instruction(&mut self, syntax: &InstructionSyntax, has_errors: bool) {
        let instruction = if has_errors {
            None
        } else if syntax.mnemonic.text.eq_ignore_ascii_case(DATA) {
            self.data(syntax)
        } else {
            self.read(syntax).map(|read| read.instruction())
        };
        self.instructions.push(instruction.unwrap_or(Instruction::STOP));
        self.origins.push(syntax.span);
    }

    fn read(&mut self, syntax: &InstructionSyntax) -> Option<Read> {
        let spec = self.command(&syntax.mnemonic)?;
        if let Some(comma) = syntax.stray_comma {
            self.complain(stray_comma(spec, comma));
        }
        let lacks = self.missing_command(spec, syntax.mnemonic.span);
        let is_lacking = lacks.is_some();
        self.diagnostics.extend(lacks);
        if let Some(complaint) = count::check(spec, syntax) {
            let is_error = complaint.code == Code::OperandCount;
            self.complain(complaint);
            if is_error {
                return None;
            }
        }
        let read = self.operands(spec, syntax);
        let module = (self.checks_module && !is_lacking).then_some(self.module);
        self.diagnostics.extend(check::check(module, &read));
        Some(read)
    }

    /// The command of that mnemonic.
    fn command(&mut self, mnemonic: &Name) -> Option<&'static CommandSpec> {
        let known = || commands::COMMANDS.iter().filter(|spec| !spec.mnemonic.is_empty());
        if let Some(spec) = known().find(|spec| spec.mnemonic.eq_ignore_ascii_case(&mnemonic.text)) {
            return Some(spec);
        }
        let message = format!("there is no command `{}`", words::shortened(&mnemonic.text));
        let diagnostic = Diagnostic::new(Code::UnknownMnemonic, mnemonic.span, message);
        let module = self.module;
        let here = known().filter(|spec| module.command(spec.number).is_some());
        let nearest = self.near.nearest(&mnemonic.text, here.map(|spec| spec.mnemonic));
        self.complain(match nearest {
            Some(near) => diagnostic.suggest(mnemonic.span, near, "a command has a similar name"),
            None => diagnostic,
        });
        None
    }

    /// The complaint where the module lacks the command, or has it in direct mode only.
    fn missing_command(&self, spec: &CommandSpec, span: Span) -> Option<Diagnostic> {
        if !self.checks_module {
            return None;
        }
        let (mnemonic, module) = (spec.mnemonic, self.module.name);
        match self.module.command(spec.number) {
            Some(entry) if entry.modes.allow(self.mode) => None,
            Some(_) if self.mode == Mode::Direct => {
                let message = format!("{mnemonic} cannot be sent to a {module}");
                let diagnostic = Diagnostic::new(Code::CommandMissing, span, message);
                Some(diagnostic.note("it works in stand-alone programs only"))
            }
            Some(_) => {
                let message = format!("{mnemonic} cannot stand in a program of the {module}");
                let diagnostic = Diagnostic::new(Code::CommandMissing, span, message);
                Some(diagnostic.note("it works in direct mode only: a host has to send it"))
            }
            None => {
                let message = format!("the {module} has no command {mnemonic}");
                let diagnostic = Diagnostic::new(Code::CommandMissing, span, message);
                let has = check::modules_with(|other| other.command(spec.number).is_some());
                Some(match words::list(&has, "and").as_str() {
                    "" => diagnostic,
                    has => diagnostic.note(format!("it is a command of the {has}")),
                })
            }
        }
    }

    /// Appends the STOP and looks at the length.
    fn finish(mut self) -> (Program, Vec<Diagnostic>) {
        let ends = self.instructions.last().is_some_and(|last| last.ends_a_program());
        let is_written = !self.instructions.is_empty();
        let appends_stop = self.appends_stop && !ends;
        if appends_stop {
            self.instructions.push(Instruction::STOP);
            let end = self.loaded.sources.get(Sources::ROOT).map_or(0, |root| root.bytes.len());
            self.origins.push(Span::new(Sources::ROOT, end..end));
        }
        if is_written && self.mode == Mode::Program {
            let complaint = self.too_long();
            self.diagnostics.extend(complaint);
        }
        let (labels, constants) = self.names.into_definitions();
        let program = Program {
            module: self.module,
            instructions: self.instructions,
            origins: self.origins,
            appended_stop: appends_stop,
            labels,
            constants,
        };
        (program, self.diagnostics)
    }

    fn too_long(&self) -> Option<Diagnostic> {
        let (module, most) = (self.module.name, usize::from(self.module.program_memory));
        let first_beyond = *self.origins.get(most)?;
        if most == 0 {
            let message = format!("the {module} has no program memory");
            let diagnostic = Diagnostic::new(Code::ProgramTooLong, first_beyond, message);
            let has = check::modules_with(|other| other.program_memory > 0);
            let has = words::list(&has, "and");
            return Some(diagnostic.note(format!("stand-alone programs run on the {has}")));
        }
        let count = self.instructions.len();
        let message = format!("the program has {count} instructions; the {module} has room for {most}");
        let what =
            if first_beyond.start == first_beyond.end { "the STOP at the end" } else { "this instruction" };
        let label = format!("{what} is the first that does not fit");
        Some(Diagnostic::new(Code::ProgramTooLong, first_beyond, message).label(label))
    }
}

fn stray_comma(spec: &CommandSpec, comma: Span) -> Diagnostic {
    let message = format!("there is a comma after {}", spec.mnemonic);
    Diagnostic::new(Code::StrayComma, comma, message)
        .note("commas stand between operands; some manuals print one here, too")
        .suggest(comma, "", "leave the comma out")
}
