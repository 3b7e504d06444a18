use proptest::prelude::*;

use super::*;
use crate::syntax::{Operand, OperandKind, Statement};

fn laid_out(text: &str) -> String {
    String::from_utf8(format(text.as_bytes())).unwrap()
}

mod listings {
    use super::laid_out;

    /// TMCM-1311 §3.3.2.
    #[test]
    fn first_program() {
        let text = laid_out(
            "\
ROL 0, 50000           //Rotate motor 0 with speed 50000
WAIT TICKS, 0, 500
MST 0
ROR 0, 50000           //Rotate motor 0 with 50000
WAIT TICKS, 0, 500
MST 0

SAP 4, 0, 50000        //Set max. Velocity
SAP 5, 0, 50000        //Set max. Acceleration
Loop: MVP ABS, 0, 10000 //Move to Position 10000
WAIT POS, 0, 0         //Wait until position reached
MVP ABS, 0, -100000    //Move to Position -10000
WAIT POS, 0, 0         //Wait until position reached
JA Loop                //Infinite Loop
",
        );
        insta::assert_snapshot!(text);
    }

    /// TMCM-1311 §5.6.5.
    #[test]
    fn timer_interrupt() {
        let text = laid_out(
            "\
#include Interrupts.inc
VECT 0, Timer0Irq //define the interrupt vector
SGP 0, 3, 1000 //configure the interrupt: set its period to 1000ms
EI 0 //enable this interrupt
EI 255 //globally switch on interrupt processing

//Main program: toggles output 3, using a WAIT command for the delay
Loop:
  SIO 3, 2, 1
  WAIT TICKS, 0, 50
  SIO 3, 2, 0
  WAIT TICKS, 0, 50
  JA Loop

//Here is the interrupt handling routine
Timer0Irq:
  GIO 0, 2 //check if OUT0 is high
  JC NZ, Out0Off //jump if not
  SIO 0, 2, 1 //switch OUT0 high
  RETI //end of interrupt
Out0Off:
  SIO 0, 2, 0      //switch OUT0 low
  RETI            //end of interrupt
",
        );
        insta::assert_snapshot!(text);
    }

    /// TMCM-1311 §8.11.1.
    #[test]
    fn closed_loop() {
        let text = laid_out(
            "\
//Initialize the parameters
    SAP 6, 0, 128          //max. current
    SAP 202, 0, 200       //motor full steps
    SAP 210, 0, 40000     //encoder steps

    SAP 4, 0, 398105      //positioning speed
    SAP 5, 0, 3981070     //acceleration
    SAP 126, 0, 1023950   //correction speed

    SAP 129, 0, 1         //switch on closed loop
ClWait:  GAP 133, 0       //wait until closed loop is ready
        JC ZE, ClWait

//Let motor run
Loop:   MVP ABS, 0, 512000
        WAIT POS, 0, 0
        WAIT TICKS, 0, 100
        MVP ABS, 0, 0
        WAIT POS, 0, 0
        WAIT TICKS, 0, 100
        JA Loop
        STOP
",
        );
        insta::assert_snapshot!(text);
    }

    /// TMCM-1311 §11.3 and §11.4, with what a hasty author makes of them.
    #[test]
    fn constants_and_quirks() {
        let text = laid_out(
            "\n\n\
//Define some constants
#INCLUDE   TMCLParam.tmc// vendor's
MaxSpeed=500 // pps
Position0 =- $1f
MyVariable = 42
    //Use a symbolic name for the user variable
    //(This makes the program better readable.)



\tsap\tAPMaxPositioningSpeed,Motor0 ,MaxSpeed\t; as fast as
\t\t\t\t\t\t\t; it goes
MainLoop:
 mvp, abs,Motor0,-Position0
Second: third:  wait pos , 0,0  \t
ALabelThatIsTooLong: ja mainloop

SAP 4 0 1000  \n\n",
        );
        insta::assert_snapshot!(text);
    }
}

#[test]
fn nothing_stays_nothing() {
    assert_eq!(format(b""), b"");
    assert_eq!(format(b" \r\n\t\n"), b"");
    assert_eq!(format(b"\xEF\xBB\xBF\n\n//x"), b"\xEF\xBB\xBF//x\n");
}

#[test]
fn the_newline_is_that_of_most_lines() {
    assert_eq!(format(b"A=1\r\nB=2\r\nC=3\nD=4"), b"A = 1\r\nB = 2\r\nC = 3\r\nD = 4\r\n");
    assert_eq!(format(b"A=1\r\nB=2\nC=3\n"), b"A = 1\nB = 2\nC = 3\n");
    assert_eq!(format(b"A=1\rB=2\r"), b"A = 1\nB = 2\n");
}

#[test]
fn only_mnemonics_and_keywords_become_upper_case() {
    assert_eq!(laid_out("wait Ticks, 0, pos"), "    WAIT TICKS, 0, pos\n");
    assert_eq!(laid_out("sap abs, 0, -abs"), "    SAP abs, 0, -abs\n");
    assert_eq!(laid_out("mvp -abs, 0, 0xfF"), "    MVP -abs, 0, 0xfF\n");
    assert_eq!(laid_out("Foo: bar pos"), "Foo:    bar pos\n");
}

#[test]
fn a_comment_that_goes_on_stays_below() {
    assert_eq!(
        laid_out("MST 0 // one\n      // two\n      // three\n // alone\n// edge"),
        "    MST 0  // one\n           // two\n           // three\n    // alone\n// edge\n"
    );
    assert_eq!(laid_out("MST 0\t// one\n\t// two"), "    MST 0  // one\n           // two\n");
    assert_eq!(laid_out("MST 0 // one\n\n      // two"), "    MST 0  // one\n\n    // two\n");
}

#[test]
fn comments_keep_their_bytes() {
    assert_eq!(format(b"MST 0//\xF6  x\t \n;"), b"    MST 0  //\xF6  x\n;\n");
}

#[test]
fn lines_with_errors_are_not_touched() {
    assert_eq!(
        laid_out("  sap 4 0 \t\r\nsap 4,0,1\r\n? // x "),
        "  sap 4 0 \t\r\n    SAP 4, 0, 1\r\n? // x \r\n"
    );
    assert_eq!(format(b"\n\n\xEF\xBB\xBFMST 0"), b"\n\xEF\xBB\xBFMST 0\n");
}

/// What must not change: every line that is not blank, in any case, without stray commas and spans.
fn meaning(bytes: &[u8]) -> Vec<Vec<String>> {
    let file = parse(Sources::ROOT, bytes).file;
    let source = Source { bytes, file: &file };
    let of_line = |line: &Line| {
        if line.has_errors {
            return vec![source.verbatim(line).escape_ascii().to_string()];
        }
        let mut parts: Vec<_> =
            line.labels.iter().map(|label| format!("{}:", label.text.to_lowercase())).collect();
        parts.extend(line.statement.as_ref().map(|statement| statement_meaning(&source, statement)));
        let comment = line.comment.map(|comment| trim_end(source.text(&file.tokens[comment])));
        parts.extend(comment.map(|comment| comment.escape_ascii().to_string()));
        parts
    };
    file.lines.iter().map(of_line).filter(|parts| !parts.is_empty()).collect()
}

fn statement_meaning(source: &Source<'_>, statement: &Statement) -> String {
    let operand = |operand: &Operand| match &operand.kind {
        OperandKind::Number(number) => format!("{} {number}", operand.negated),
        OperandKind::Name(name) => format!("{} {}", operand.negated, name.to_lowercase()),
    };
    match statement {
        Statement::Instruction(instruction) => {
            let operands: Vec<_> = instruction.operands.iter().map(operand).collect();
            format!("{} {operands:?}", instruction.mnemonic.text.to_lowercase())
        }
        Statement::Constant(constant) => {
            format!("{} = {}", constant.name.text.to_lowercase(), operand(&constant.value))
        }
        Statement::Include(include) => {
            format!("#include {}", source.bytes[include.path.span.range()].escape_ascii())
        }
    }
}

fn comments(bytes: &[u8]) -> Vec<Vec<u8>> {
    let file = parse(Sources::ROOT, bytes).file;
    let tokens = file.tokens.iter().filter(|token| token.kind == TokenKind::Comment);
    tokens.map(|token| trim_end(&bytes[token.range()]).to_vec()).collect()
}

fn assert_well_laid_out(text: &[u8]) -> Result<(), TestCaseError> {
    let once = format(text);
    prop_assert_eq!(meaning(text), meaning(&once));
    prop_assert_eq!(comments(text), comments(&once));
    prop_assert_eq!(format(&once).escape_ascii().to_string(), once.escape_ascii().to_string());
    let file = parse(Sources::ROOT, &once).file;
    let source = Source { bytes: &once, file: &file };
    let good_lines = file.lines.iter().filter(|line| !line.has_errors).map(|line| source.verbatim(line));
    for line in good_lines {
        prop_assert_eq!(trim_end(line), line);
    }
    if once == BYTE_ORDER_MARK {
        return Ok(());
    }
    let ends: Vec<_> =
        file.lines.iter().filter_map(|line| source.tokens(line).last()).map(|token| token.kind).collect();
    prop_assert!(ends.iter().all(|kind| *kind == TokenKind::Newline), "{:?}", ends);
    let blank: Vec<_> = file.lines.iter().map(|line| source.verbatim(line).is_empty()).collect();
    prop_assert!(blank.windows(2).all(|pair| pair != [true, true]));
    prop_assert_ne!(blank.last(), Some(&true));
    Ok(())
}

/// One of the texts.
fn any_of<const N: usize>(texts: [&'static str; N]) -> impl Strategy<Value = String> {
    proptest::sample::select(texts.to_vec()).prop_map(str::to_owned)
}

fn space() -> impl Strategy<Value = String> {
    any_of(["", "", " ", " ", "  ", "\t", "    ", "        ", " \t \x0C"])
}

fn statement() -> impl Strategy<Value = String> {
    let operand =
        any_of(["0", "255", "$1f", "0xAB", "-5", "- Max", "pos", "Abs", "loop", "ticks", "4294967295"]);
    let operands =
        proptest::collection::vec((operand, space()).prop_map(|(operand, space)| operand + &space), 0..4);
    let comma = (space(), space()).prop_map(|(before, behind)| format!("{before},{behind}"));
    let mnemonic = any_of(["mvp ", "WAIT ", "Sap\t", "stop ", "calcx ", "EI, ", "Foo ", "UF0 "]);
    let instruction =
        (mnemonic, operands, comma).prop_map(|(mnemonic, operands, comma)| mnemonic + &operands.join(&comma));
    let constant = any_of(["A=1", "Max = -$7F", "b\t= - Max", "Loop = loop"]);
    let include = any_of(["#include a.inc", "#INCLUDE\t\"a //b\tc;.inc\"", "#include a\tb ä.inc"]);
    let broken =
        any_of(["SAP 4 0 1", "A =", "12x", "#define", "MVP ABS,, 1", "\u{FEFF}MST 0", "EI 99999999999"]);
    prop_oneof![6 => instruction, 2 => constant, 1 => include, 1 => broken, 3 => Just(String::new())]
}

fn line() -> impl Strategy<Value = String> {
    let label = any_of(["", "", "", "L:", "Loop: ", "A:b : ", "ALabelThatIsVeryLong:", "Quitelonglabel:"]);
    let comment = any_of(["", "", "// fast", "//x \t", ";", "; größer  ", "//! module: tmcm-1311"]);
    let newline = any_of(["\n", "\n", "\r\n", "\r\n", "\n\n\n", "\r"]);
    (space(), label, statement(), space(), comment, newline).prop_map(
        |(indent, label, statement, space, comment, newline)| {
            indent + &label + &statement + &space + &comment + &newline
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1024))]

    #[test]
    fn programs(mark in any_of(["", "", "", "\u{FEFF}"]), lines in proptest::collection::vec(line(), 0..12)) {
        assert_well_laid_out((mark + &lines.concat()).as_bytes())?;
    }

    #[test]
    fn programs_with_a_wrong_byte(text in proptest::collection::vec(line(), 0..6), cut in any::<prop::sample::Index>(), byte in any::<u8>()) {
        let mut text = text.concat().into_bytes();
        if !text.is_empty() {
            let at = cut.index(text.len());
            text[at] = byte;
        }
        assert_well_laid_out(&text)?;
    }

    #[test]
    fn any_bytes(bytes in any::<Vec<u8>>()) {
        assert_well_laid_out(&bytes)?;
    }
}
