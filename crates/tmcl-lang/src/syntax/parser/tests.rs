use core::fmt::Write as _;

use proptest::prelude::*;

use super::*;
use crate::source::Sources;

fn tree(text: &[u8]) -> Parse {
    parse(Sources::ROOT, text)
}

/// A line as `label: MNEMONIC[,] operand operand ; comment`, and `!` where it has errors.
fn line_text(text: &[u8], parse: &Parse, line: &Line) -> String {
    let mut out = String::new();
    for label in &line.labels {
        write!(out, "{}: ", label.text).unwrap();
    }
    match &line.statement {
        Some(Statement::Instruction(instruction)) => {
            let comma = if instruction.stray_comma.is_some() { "[,]" } else { "" };
            write!(out, "{}{comma}", instruction.mnemonic.text).unwrap();
            for operand in &instruction.operands {
                write!(out, " {}", operand_text(operand)).unwrap();
            }
        }
        Some(Statement::Constant(constant)) => {
            write!(out, "{} = {}", constant.name.text, operand_text(&constant.value)).unwrap();
        }
        Some(Statement::Include(include)) => write!(out, "#include <{}>", include.path.text).unwrap(),
        None => {}
    }
    if let Some(comment) = line.comment {
        let comment = &text[parse.file.tokens[comment].range()];
        write!(out, " {}", comment.escape_ascii()).unwrap();
    }
    if line.has_errors {
        out.push_str(" !");
    }
    out.split(' ').filter(|part| !part.is_empty()).collect::<Vec<_>>().join(" ")
}

fn operand_text(operand: &Operand) -> String {
    let minus = if operand.negated { "-" } else { "" };
    match &operand.kind {
        OperandKind::Number(number) => format!("{minus}{number}"),
        OperandKind::Name(name) => format!("{minus}{name}"),
    }
}

fn lines(text: &[u8]) -> Vec<String> {
    let parse = tree(text);
    parse.file.lines.iter().map(|line| line_text(text, &parse, line)).collect()
}

/// The lines, which make sense all over.
#[track_caller]
fn good_lines(text: &str) -> Vec<String> {
    assert_eq!(tree(text.as_bytes()).diagnostics, []);
    lines(text.as_bytes())
}

/// Code, place and words of the only finding in a text.
#[track_caller]
fn finding(text: &[u8]) -> String {
    let diagnostics = tree(text).diagnostics;
    let [diagnostic] = diagnostics.as_slice() else { panic!("{diagnostics:?}") };
    let place = text[diagnostic.primary.span.range()].escape_ascii();
    let mut out =
        format!("{} «{place}» {}: {}", diagnostic.code, diagnostic.message, diagnostic.primary.text);
    for note in &diagnostic.notes {
        write!(out, "; note: {note}").unwrap();
    }
    if let Some(suggestion) = &diagnostic.suggestion {
        let old = text[suggestion.span.range()].escape_ascii();
        write!(out, "; {}: «{old}» -> «{}»", suggestion.text, suggestion.replacement).unwrap();
    }
    out
}

#[test]
fn an_empty_file_has_no_lines() {
    assert_eq!(lines(b""), [""; 0]);
    assert_eq!(lines(b"\n"), [""]);
    assert_eq!(lines(b"\xEF\xBB\xBFSTOP"), ["STOP"]);
}

#[test]
fn labels_stand_alone_or_before_an_instruction() {
    assert_eq!(
        good_lines("A:\nB : C:MVP ABS, 0,-10//go\n\tJA A"),
        ["A:", "B: C: MVP ABS 0 -10 //go", "JA A"]
    );
}

#[test]
fn constants_are_numbers_or_names_with_or_without_minus() {
    assert_eq!(
        good_lines("A=5\nB = - $1f;x\n C\t=-A\nl: D = B"),
        ["A = 5", "B = -31 ;x", "C = -A", "l: D = B"]
    );
}

#[test]
fn includes_with_and_without_quotes() {
    assert_eq!(
        good_lines("#include TMCLParam.tmc // x\n  #Include \"a b//c.inc\"//y\n#INCLUDE my file.inc\t\r\n"),
        ["#include <TMCLParam.tmc> //x", "#include <a b//c.inc> //y", "#include <my file.inc>"]
            .map(|line| line.replace("//x", "// x"))
    );
    assert_eq!(lines(b"#include \xF6.inc"), ["#include <\u{FFFD}.inc>"]);
}

#[test]
fn the_quirks_of_the_manuals() {
    assert_eq!(
        good_lines("EI, 255\r\nSGP, 0, 2, 100\r\nGAP 1, 0, 0\r\nAAP 17,0\r\nSTOP,\r\nRETI"),
        ["EI[,] 255", "SGP[,] 0 2 100", "GAP 1 0 0", "AAP 17 0", "STOP[,]", "RETI"]
    );
}

#[test]
fn comments_need_not_be_utf8() {
    assert_eq!(lines(b"MST 0 // \xFC\n;\xFF"), [r"MST 0 // \xfc", r";\xff"]);
    assert_eq!(tree(b"MST 0 // \xFC\n;\xFF").diagnostics, []);
}

#[test]
fn numbers_reach_to_32_bits() {
    assert_eq!(good_lines("CALC LOAD, 4294967295"), ["CALC LOAD 4294967295"]);
    assert_eq!(lines(b"CALC LOAD, 4294967296"), ["CALC LOAD 0 !"]);
    insta::assert_snapshot!(finding(b"CALC LOAD, -$100000000"), @"E0003 «$100000000» `$100000000` does not fit 32 bits: the largest is 4294967295 or $FFFFFFFF");
}

#[test]
fn spans_cover_what_they_name() {
    let text = b"L: MVP REL , 0, - 10 // x\n#include  \"a\" ";
    let parse = tree(text);
    let part = |span: Span| core::str::from_utf8(&text[span.range()]).unwrap();
    let Some(Statement::Instruction(instruction)) = &parse.file.lines[0].statement else { panic!() };
    assert_eq!(part(parse.file.lines[0].labels[0].span), "L");
    assert_eq!(part(instruction.span), "MVP REL , 0, - 10");
    assert_eq!(
        instruction.operands.iter().map(|operand| part(operand.span)).collect::<Vec<_>>(),
        ["REL", "0", "- 10"]
    );
    let Some(Statement::Include(include)) = &parse.file.lines[1].statement else { panic!() };
    assert_eq!((part(include.span), part(include.path.span)), ("#include  \"a\"", "\"a\""));
    assert_eq!(include.path.text, "a");
}

#[test]
fn a_bad_line_does_not_spoil_the_next() {
    let text = b"MVP ABS,,0,1 // a\nx: ROR 0 =\n?\nSAP 4 0 1000\nA =\nMST 0";
    let expected = ["// a !", "x: !", "!", "SAP 4 0 1000 !", "A = 0 !", "MST 0"];
    assert_eq!(lines(text), expected);
    assert_eq!(tree(text).diagnostics.len(), 5);
}

/// Every mistake is one finding that says what was found and what is expected.
#[test]
fn mistakes() {
    let mistakes: [&[u8]; 34] = [
        b"SAP 4 0 1000 // slow",
        b"SAP, 4, 0 1000",
        b"Loop MVP ABS, 0, 1000",
        b"SAP 4,, 1000",
        b"SAP 4, 0, 1000,",
        b"EI,, 255",
        b"MVP ABS, 0, 12abc",
        b"MVP ABS, 0, 12ms",
        b"MVP ABS, 0, $",
        b"MVP ABS, 0, 0x // hex",
        b"MVP ABS, 0, $12G4",
        b"MVP ABS, 0, 1.5",
        b"MVP ABS, 0, +5",
        b"MVP ABS, 0, --5",
        b"MVP ABS, 0, -",
        b"MVP ABS, 0, A - B",
        b"MVP ABS, 0, A + B",
        b"Speed =",
        b"Speed = // fast",
        b"Speed = 5,",
        b"Speed = 5 * 3",
        b"= 5",
        b"5 = Speed",
        b"JA Loop:",
        b": MST 0",
        b"Gr\xC3\xB6\xC3\x9Fe = 5",
        b"Gr\xF6\xDFe = 5",
        b"MST\xC2\xA00",
        b"#define SPEED 5",
        b"#include",
        b"#include \"\"",
        b"#include \"a.inc // b",
        b"#include \"a.inc\" b",
        b"\"MST 0\"",
    ];
    let mut out = String::new();
    for text in mistakes {
        writeln!(out, "{}\n    {}", text.escape_ascii(), finding(text)).unwrap();
    }
    insta::assert_snapshot!(out);
}

fn assert_sound(bytes: &[u8]) -> Result<(), TestCaseError> {
    let Parse { file, diagnostics } = tree(bytes);
    prop_assert_eq!(
        file.tokens.iter().flat_map(|token| bytes[token.range()].to_vec()).collect::<Vec<_>>(),
        bytes
    );
    let mut next = 0;
    for line in &file.lines {
        prop_assert_eq!(line.tokens.start, next);
        prop_assert!(!line.tokens.is_empty());
        prop_assert!(line.comment.is_none_or(|comment| line.tokens.contains(&comment)));
        next = line.tokens.end;
    }
    prop_assert_eq!(next, file.tokens.len());
    prop_assert_eq!(diagnostics.is_empty(), file.lines.iter().all(|line| !line.has_errors));
    for diagnostic in &diagnostics {
        let suggested = diagnostic.suggestion.iter().map(|suggestion| suggestion.span);
        for span in suggested.chain([diagnostic.primary.span]) {
            prop_assert!(span.start <= span.end && span.end as usize <= bytes.len(), "{:?}", diagnostic);
        }
    }
    for span in file.lines.iter().flat_map(spans) {
        prop_assert!(span.start < span.end && span.end as usize <= bytes.len(), "{:?}", span);
    }
    Ok(())
}

/// The spans of all that is in the tree; the value of a constant without one is nowhere.
fn spans(line: &Line) -> Vec<Span> {
    let mut spans: Vec<_> = line.labels.iter().map(|label| label.span).collect();
    match &line.statement {
        Some(Statement::Instruction(instruction)) => {
            spans.extend([instruction.span, instruction.mnemonic.span]);
            spans.extend(instruction.operands.iter().map(|operand| operand.span));
        }
        Some(Statement::Constant(constant)) if line.has_errors => spans.push(constant.name.span),
        Some(Statement::Constant(constant)) => spans.extend([constant.name.span, constant.value.span]),
        Some(Statement::Include(include)) => spans.extend([include.span, include.path.span]),
        None => {}
    }
    spans
}

proptest! {
    #[test]
    fn any_bytes_have_a_sound_tree(bytes in any::<Vec<u8>>()) {
        assert_sound(&bytes)?;
    }

    #[test]
    fn any_heap_of_pieces_has_a_sound_tree(pieces in proptest::collection::vec(piece(), 0..40)) {
        assert_sound(&pieces.concat())?;
    }
}

/// What programs are made of, in no order.
fn piece() -> impl Strategy<Value = Vec<u8>> {
    let pieces: [&[u8]; 28] = [
        b" ",
        b" ",
        b"\t",
        b"\n",
        b"\n",
        b"\r\n",
        b"\r",
        b",",
        b",",
        b":",
        b"=",
        b"-",
        b"//",
        b";",
        b"#include ",
        b"\"",
        b"MVP",
        b"ABS",
        b"Loop",
        b"Loop:",
        b"0",
        b"$1F",
        b"99999999999",
        b"12x",
        b"$",
        b"\xEF\xBB\xBF",
        b"\xF6",
        b"SAP 4, 0, 5",
    ];
    proptest::sample::select(pieces.to_vec()).prop_map(<[u8]>::to_vec)
}
