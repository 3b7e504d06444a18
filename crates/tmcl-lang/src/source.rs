//! Source files and places in them.
//!
//! Files are bytes: real programs hold comments in whatever code page their author's editor used.

use core::ops::Range;

/// A file of a [`Sources`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FileId(pub u32);

/// Some bytes of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Span {
    /// The file.
    pub file: FileId,
    /// The first byte.
    pub start: u32,
    /// The byte after the last.
    pub end: u32,
}

impl Span {
    /// The bytes `range` of `file`.
    #[must_use]
    pub fn new(file: FileId, range: Range<usize>) -> Self {
        let offset = |offset: usize| u32::try_from(offset).unwrap_or(u32::MAX);
        Self { file, start: offset(range.start), end: offset(range.end) }
    }

    /// The bytes as a range of indices.
    #[must_use]
    pub fn range(self) -> Range<usize> {
        self.start as usize..self.end as usize
    }

    /// From the first byte of this to the last of `other`.
    #[must_use]
    pub fn to(self, other: Self) -> Self {
        Self { end: other.end.max(self.end), ..self }
    }
}

/// A place as people count: both from 1, columns in characters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Position {
    /// The line.
    pub line: u32,
    /// The character in the line.
    pub column: u32,
}

/// A file that was read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SourceFile {
    /// What messages call it: its path, or the name of a built-in include file.
    pub name: String,
    /// What it holds.
    pub bytes: Vec<u8>,
    /// Whether it is one of the include files that OpenTMCL brings along.
    pub builtin: bool,
}

/// All files that one assembly read; the first is the program itself.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Sources {
    files: Vec<SourceFile>,
}

impl Sources {
    /// The file that everything begins with.
    pub const ROOT: FileId = FileId(0);

    /// Takes a file in.
    pub fn add(&mut self, file: SourceFile) -> FileId {
        let id = FileId(u32::try_from(self.files.len()).unwrap_or(u32::MAX));
        self.files.push(file);
        id
    }

    /// A file.
    #[must_use]
    pub fn get(&self, id: FileId) -> Option<&SourceFile> {
        self.files.get(id.0 as usize)
    }

    /// Every file, with its name for spans.
    pub fn iter(&self) -> impl Iterator<Item = (FileId, &SourceFile)> {
        self.files
            .iter()
            .enumerate()
            .map(|(index, file)| (FileId(u32::try_from(index).unwrap_or(u32::MAX)), file))
    }

    /// The bytes that a span names; none where it names nothing.
    #[must_use]
    pub fn bytes(&self, span: Span) -> &[u8] {
        self.get(span.file).and_then(|file| file.bytes.get(span.range())).unwrap_or_default()
    }

    /// Line and column of a span's first byte.
    #[must_use]
    pub fn position(&self, span: Span) -> Position {
        let before = self.bytes(Span { start: 0, end: span.start, ..span });
        // A lone CR ends a line too, as in the lexer.
        let ends_line = |&(index, byte): &(usize, &u8)| match byte {
            b'\n' => true,
            b'\r' => before.get(index + 1) != Some(&b'\n'),
            _ => false,
        };
        let mut newlines = before.iter().enumerate().filter(ends_line).map(|(index, _)| index);
        let (lines, line_start) = match newlines.next_back() {
            Some(last) => (newlines.count() + 1, last + 1),
            None => (0, 0),
        };
        let characters =
            String::from_utf8_lossy(before.get(line_start..).unwrap_or_default()).chars().count();
        let from_one = |count: usize| u32::try_from(count + 1).unwrap_or(u32::MAX);
        Position { line: from_one(lines), column: from_one(characters) }
    }

    /// The name of a span's file.
    #[must_use]
    pub fn name(&self, span: Span) -> &str {
        self.get(span.file).map_or("", |file| file.name.as_str())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_count_lines_and_characters_from_one() {
        let mut sources = Sources::default();
        let bytes = "MST 0\n// Größe\n  STOP".as_bytes().to_vec();
        let file = sources.add(SourceFile { name: "a.tmc".to_owned(), bytes, builtin: false });
        let at = |start: usize| sources.position(Span::new(file, start..start));
        assert_eq!(at(0), Position { line: 1, column: 1 });
        assert_eq!(at(16), Position { line: 2, column: 9 });
        assert_eq!(at(19), Position { line: 3, column: 3 });
        assert_eq!(at(99), Position { line: 1, column: 1 });
        let bytes = b"STOP\r\nSTOP\rSTOP".to_vec();
        let file = sources.add(SourceFile { name: "b.tmc".to_owned(), bytes, builtin: false });
        assert_eq!(sources.position(Span::new(file, 11..11)), Position { line: 3, column: 1 });
    }
}
