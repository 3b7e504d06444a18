//! Inlining of included files.

use std::collections::BTreeMap;

use tmcl_tables::ModuleSpec;

use super::suggest::NearMisses;
use super::words;
use crate::builtin::{BUILTIN_INCLUDES, builtin_include};
use crate::code::Code;
use crate::diagnostic::Diagnostic;
use crate::resolver::Resolver;
use crate::source::{FileId, SourceFile, Sources, Span};
use crate::syntax::{File, Include, Line, Parse, Statement, parse};

/// How deep includes may nest.
const DEEPEST: usize = 64;
/// How many lines included files may add up to, each as often as it is included.
const MOST_INCLUDED_LINES: usize = 100_000;

/// A program with its included files.
pub(super) struct Loaded {
    pub(super) sources: Sources,
    pub(super) diagnostics: Vec<Diagnostic>,
    /// The trees, by [`FileId`].
    trees: Vec<File>,
    /// File and line, in the order of the program.
    order: Vec<(FileId, usize)>,
}

impl Loaded {
    /// The lines that say something, included ones where they are included.
    pub(super) fn lines(&self) -> impl Iterator<Item = (FileId, &Line)> {
        self.order
            .iter()
            .filter_map(|&(file, line)| Some((file, self.trees.get(file.0 as usize)?.lines.get(line)?)))
    }

    /// Whether a file is one that OpenTMCL brings along.
    pub(super) fn is_builtin(&self, file: FileId) -> bool {
        self.sources.get(file).is_some_and(|file| file.builtin)
    }
}

/// A file that is being gone through.
struct Frame {
    file: FileId,
    next_line: usize,
    /// The `#include` that led here.
    included_at: Option<Span>,
}

struct Loader<'r> {
    module: &'static ModuleSpec,
    resolver: &'r mut dyn Resolver,
    loaded: Loaded,
    stack: Vec<Frame>,
    /// What an include in a file led to; None where that was complained about.
    found: BTreeMap<(FileId, String), Option<FileId>>,
    /// Files by whether they are built in, and name.
    by_name: BTreeMap<(bool, String), FileId>,
    included_lines: usize,
    /// Whether a bound was met, after which nothing is included any more.
    is_full: bool,
}

/// Goes through a program and what it includes.
pub(super) fn inline(
    root: SourceFile,
    parsed: Parse,
    module: &'static ModuleSpec,
    resolver: &mut dyn Resolver,
) -> Loaded {
    let loaded =
        Loaded { sources: Sources::default(), diagnostics: Vec::new(), trees: Vec::new(), order: Vec::new() };
    let mut loader = Loader {
        module,
        resolver,
        loaded,
        stack: Vec::new(),
        found: BTreeMap::new(),
        by_name: BTreeMap::new(),
        included_lines: 0,
        is_full: false,
    };
    let file = loader.keep(root, |_, _| parsed);
    loader.stack.push(Frame { file, next_line: 0, included_at: None });
    while loader.step() {}
    loader.loaded
}

impl Loader<'_> {
    /// One line further; false at the end.
    fn step(&mut self) -> bool {
        let Some(frame) = self.stack.last_mut() else { return false };
        let (file, line) = (frame.file, frame.next_line);
        frame.next_line += 1;
        let tree = self.loaded.trees.get(file.0 as usize);
        let Some(found) = tree.and_then(|tree| tree.lines.get(line)) else {
            self.stack.pop();
            return true;
        };
        if !found.labels.is_empty() || found.statement.is_some() {
            self.loaded.order.push((file, line));
        }
        if let Some(Statement::Include(include)) = &found.statement {
            let include = include.clone();
            self.include(file, &include);
        }
        true
    }

    fn include(&mut self, includer: FileId, include: &Include) {
        if self.is_full {
            return;
        }
        let key = (includer, include.path.text.clone());
        let file = match self.found.get(&key) {
            Some(known) => *known,
            None => {
                let file = self.find(includer, include);
                self.found.insert(key, file);
                file
            }
        };
        let Some(file) = file else { return };
        if let Some(complaint) = self.cycle(file, include).or_else(|| self.too_much(file, include)) {
            self.loaded.diagnostics.push(complaint);
            return;
        }
        self.stack.push(Frame { file, next_line: 0, included_at: Some(include.span) });
    }

    /// The resolver's file, or the built-in one.
    fn find(&mut self, includer: FileId, include: &Include) -> Option<FileId> {
        let name = include.path.text.as_str();
        let includer = self.loaded.sources.get(includer).map_or("", |file| file.name.as_str());
        match self.resolver.resolve(includer, name) {
            Ok(Some(resolved)) => {
                Some(self.file(SourceFile { name: resolved.name, bytes: resolved.bytes, builtin: false }))
            }
            Ok(None) => self.builtin(name).or_else(|| {
                self.loaded.diagnostics.push(not_found(include));
                None
            }),
            Err(reason) => {
                let message = format!("`{}` cannot be read: {reason}", words::shortened(name));
                self.loaded.diagnostics.push(Diagnostic::new(
                    Code::IncludeNotFound,
                    include.path.span,
                    message,
                ));
                None
            }
        }
    }

    fn builtin(&mut self, name: &str) -> Option<FileId> {
        let known = BUILTIN_INCLUDES.iter().find(|known| known.eq_ignore_ascii_case(name))?;
        let bytes = builtin_include(known, self.module)?.into_bytes();
        Some(self.file(SourceFile { name: (*known).to_owned(), bytes, builtin: true }))
    }

    /// Takes a file in, unless it is there.
    fn file(&mut self, file: SourceFile) -> FileId {
        match self.by_name.get(&(file.builtin, file.name.clone())) {
            Some(known) => *known,
            None => self.keep(file, parse),
        }
    }

    fn keep(&mut self, file: SourceFile, parse: impl FnOnce(FileId, &[u8]) -> Parse) -> FileId {
        let key = (file.builtin, file.name.clone());
        let id = self.loaded.sources.add(file);
        self.by_name.insert(key, id);
        let parsed = parse(id, self.loaded.sources.get(id).map_or(&[], |file| &file.bytes));
        self.loaded.diagnostics.extend(parsed.diagnostics);
        self.loaded.trees.push(parsed.file);
        id
    }

    /// The complaint where a file includes itself, with all the includes in between.
    fn cycle(&self, file: FileId, include: &Include) -> Option<Diagnostic> {
        let first = self.stack.iter().position(|frame| frame.file == file)?;
        let chain = self.stack.get(first..)?;
        let name = |file: FileId| self.loaded.sources.get(file).map_or("", |file| file.name.as_str());
        let message = format!("`{}` includes itself", name(file));
        let mut diagnostic =
            Diagnostic::new(Code::IncludeCycle, include.span, message).label("the circle closes here");
        let mut story = format!("`{}`", name(file));
        for pair in chain.windows(2) {
            if let [outer, Frame { file, included_at: Some(span), .. }] = pair {
                let text = format!("`{}` includes `{}`", name(outer.file), name(*file));
                diagnostic = diagnostic.also(*span, text);
                story.push_str(&format!(" includes `{}`, which", name(*file)));
            }
        }
        Some(match chain.len() {
            1 => diagnostic,
            _ => diagnostic.note(format!("{story} includes `{}`", name(file))),
        })
    }

    /// The complaint where includes nest too deep or add up to too much.
    fn too_much(&mut self, file: FileId, include: &Include) -> Option<Diagnostic> {
        let lines = self.loaded.trees.get(file.0 as usize).map_or(0, |tree| tree.lines.len());
        self.included_lines = self.included_lines.saturating_add(lines.max(1));
        let (message, note) = if self.stack.len() > DEEPEST {
            ("this include is nested too deep", format!("includes may nest {DEEPEST} deep"))
        } else if self.included_lines > MOST_INCLUDED_LINES {
            let note = format!(
                "included files may have {MOST_INCLUDED_LINES} lines together, each counted as often as it is included"
            );
            ("the included files have too many lines", note)
        } else {
            return None;
        };
        self.is_full = true;
        Some(Diagnostic::new(Code::IncludeNotFound, include.span, message).note(note))
    }
}

fn not_found(include: &Include) -> Diagnostic {
    let name = &include.path.text;
    let message = format!("there is no file `{}`", words::shortened(name));
    let diagnostic = Diagnostic::new(Code::IncludeNotFound, include.path.span, message)
        .note(format!("the built-in files are {}", words::list(&BUILTIN_INCLUDES, "and")));
    match NearMisses::default().nearest(name, BUILTIN_INCLUDES) {
        Some(known) => diagnostic.suggest(include.path.span, known, "a built-in file has a similar name"),
        None => diagnostic,
    }
}
