//! The grammar:
//!
//! ```text
//! expectation = [ "never" | "always" ] condition { timing }
//! condition   = comparison { "and" comparison } | operand ( "rises" | "falls" | "changes" )
//! comparison  = operand relation reference [ ( "+-" | "±" | "+/-" ) number ] | quantity "&" mask
//! operand     = quantity [ "&" mask ]
//! relation    = "==" | "!=" | "<" | "<=" | ">" | ">="
//! reference   = number | operand | the name of a value of the parameter on the left
//! timing      = "within" time | "after" time | "for" time | "at" time | "at" "end"
//! ```

use core::ops::Range;

use tmcl_tables::ParameterSpec;

use super::clauses::{Clause, Clauses, Time};
use super::condition::{Comparison, Condition, Edge, Operand, Reference, Relation};
use super::error::ExpectError;
use super::expectation::{Expectation, Rule, Timing};
use super::lexer::{Token, tokens};
use super::literal;
use crate::bench::Bench;
use crate::probe::{Probe, Quantity};

type Parsed<T> = Result<T, ExpectError>;

const A_TIME: &str = "a time such as 500us, 10ms, 1.5s or 2min";
const A_MASK: &str = "a mask such as 0x200, of at most 32 bits";
const A_QUANTITY: &str = "a quantity such as actual_position or output.3";
const A_REFERENCE: &str = "a number or a quantity";
const A_NUMBER: &str = "a number";
const A_TOLERANCE: &str = "a number from 0";
const A_COMPARISON: &str = "`==`, `!=`, `<`, `<=`, `>`, `>=`, `&`, `rises`, `falls` or `changes`";
const A_TIMING: &str = "`and`, `within`, `after`, `for`, `at` or the end";

/// The words that no quantity is called by.
pub(super) const KEYWORDS: [&str; 10] =
    ["never", "always", "and", "rises", "falls", "changes", "within", "after", "for", "at"];

pub(super) fn parse(text: &str, bench: &Bench) -> Parsed<Expectation> {
    let mut parser = Parser { tokens: tokens(text), next: 0, text, bench };
    let rule = if parser.take("never") {
        Rule::Never
    } else if parser.take("always") {
        Rule::Always
    } else {
        Rule::Eventually
    };
    let condition = parser.condition(rule)?;
    let timing = parser.timing(rule, &condition)?;
    Ok(Expectation { text: text.trim().to_owned(), rule, condition, timing })
}

struct Parser<'t, 'b> {
    tokens: Vec<Token<'t>>,
    next: usize,
    text: &'t str,
    bench: &'b Bench,
}

impl<'t> Parser<'t, '_> {
    fn peek(&self) -> Option<&Token<'t>> {
        self.tokens.get(self.next)
    }

    /// The next word or symbol, if it is this one.
    fn take(&mut self, text: &str) -> bool {
        let found = self.peek().is_some_and(|token| token.text == text);
        self.next += usize::from(found);
        found
    }

    /// The next word, whatever it is.
    fn word(&mut self, expected: &'static str) -> Parsed<(&'t str, Range<usize>)> {
        let word = self.peek().filter(|token| token.is_word && !KEYWORDS.contains(&token.text));
        let word = word.map(|token| (token.text, token.span.clone()));
        let word = word.ok_or_else(|| self.unexpected(expected))?;
        self.next += 1;
        Ok(word)
    }

    /// Something else is expected than what comes next.
    fn unexpected(&self, expected: &'static str) -> ExpectError {
        match self.peek() {
            Some(token) => wrong(expected, token.text, token.span.clone()),
            None => {
                let end = self.text.trim_end().len();
                ExpectError::Expected { expected, found: "the end".to_owned(), span: end..end }
            }
        }
    }

    fn condition(&mut self, rule: Rule) -> Parsed<Condition> {
        let operand = self.operand()?;
        if let Some(edge) = self.edge() {
            if rule == Rule::Always {
                let message = "a change takes no time: `always` needs a comparison";
                return Err(ExpectError::Conflict { message, span: self.last_span() });
            }
            return Ok(Condition::Edge(operand, edge));
        }
        let mut comparisons = vec![self.comparison(operand)?];
        while self.take("and") {
            let operand = self.operand()?;
            if self.edge().is_some() {
                let message = "a change stands alone: `and` joins comparisons";
                return Err(ExpectError::Conflict { message, span: self.last_span() });
            }
            comparisons.push(self.comparison(operand)?);
        }
        Ok(Condition::Comparisons(comparisons))
    }

    fn edge(&mut self) -> Option<Edge> {
        let edges = [("rises", Edge::Rises), ("falls", Edge::Falls), ("changes", Edge::Changes)];
        edges.into_iter().find(|(word, _)| self.take(word)).map(|(_, edge)| edge)
    }

    fn operand(&mut self) -> Parsed<Operand> {
        let (name, span) = self.word(A_QUANTITY)?;
        if literal::looks_like_a_number(name) {
            return Err(wrong(A_QUANTITY, name, span));
        }
        let probe = self.bench.probe(name);
        let probe = probe.map_err(|problem| ExpectError::Quantity { problem, span: span.clone() })?;
        self.masked(name, probe, span)
    }

    fn masked(&mut self, name: &str, probe: Probe, span: Range<usize>) -> Parsed<Operand> {
        let mut mask = None;
        if self.take("&") {
            if matches!(probe.quantity, Quantity::Physical(_)) {
                return Err(ExpectError::NoBits { name: name.to_owned(), span });
            }
            let (word, span) = self.word(A_MASK)?;
            mask = Some(literal::mask(word).ok_or_else(|| wrong(A_MASK, word, span))?);
        }
        Ok(Operand { name: name.to_owned(), probe, mask })
    }

    /// The rest of a comparison.
    fn comparison(&mut self, left: Operand) -> Parsed<Comparison> {
        let Some(relation) = self.relation() else {
            if left.mask.is_some() {
                let right = Reference::Number(0.0);
                return Ok(Comparison { left, relation: Relation::NotEqual, right, tolerance: 0.0 });
            }
            return Err(self.unexpected(A_COMPARISON));
        };
        let right = self.reference(&left)?;
        let tolerance = self.tolerance(relation)?;
        Ok(Comparison { left, relation, right, tolerance })
    }

    fn relation(&mut self) -> Option<Relation> {
        let relations = [
            ("==", Relation::Equal),
            ("!=", Relation::NotEqual),
            ("<", Relation::Less),
            ("<=", Relation::AtMost),
            (">", Relation::Greater),
            (">=", Relation::AtLeast),
        ];
        relations.into_iter().find(|(symbol, _)| self.take(symbol)).map(|(_, relation)| relation)
    }

    /// A number, the name of a value of the left side, or another quantity.
    fn reference(&mut self, left: &Operand) -> Parsed<Reference> {
        let (word, span) = self.word(A_REFERENCE)?;
        if literal::looks_like_a_number(word) {
            let value = literal::number(word).ok_or_else(|| wrong(A_NUMBER, word, span))?;
            return Ok(Reference::Number(value));
        }
        let spec = self.parameter(left);
        let named = spec.and_then(|spec| spec.values.iter().find(|value| value.id == word));
        if let Some(named) = named {
            return Ok(Reference::Number(named.value as f64));
        }
        match (self.bench.probe(word), spec.filter(|spec| !spec.values.is_empty())) {
            (Ok(probe), _) => self.masked(word, probe, span).map(Reference::Operand),
            (Err(problem), None) => Err(ExpectError::Quantity { problem, span }),
            (Err(_), Some(spec)) => Err(no_value(word, span, spec)),
        }
    }

    /// The parameter that an operand is the whole of.
    fn parameter(&self, operand: &Operand) -> Option<&'static ParameterSpec> {
        let spec = self.bench.spec(operand.probe.module).filter(|_| operand.mask.is_none())?;
        match operand.probe.quantity {
            Quantity::Parameter(number) => spec.axis_parameter(number),
            Quantity::Global(bank, number) => {
                spec.global_parameter(bank, number).map(|entry| &entry.parameter)
            }
            _ => None,
        }
    }

    fn tolerance(&mut self, relation: Relation) -> Parsed<f64> {
        let given = ["+-", "±", "+/-"].into_iter().any(|symbol| self.take(symbol));
        if !given {
            return Ok(0.0);
        }
        if !matches!(relation, Relation::Equal | Relation::NotEqual) {
            let message = "a tolerance goes with == and != only";
            return Err(ExpectError::Conflict { message, span: self.last_span() });
        }
        let (word, span) = self.word(A_TOLERANCE)?;
        let tolerance = literal::number(word).filter(|value| *value >= 0.0);
        tolerance.ok_or_else(|| wrong(A_TOLERANCE, word, span))
    }

    /// Where the token stands that was taken last.
    fn last_span(&self) -> Range<usize> {
        let last = self.next.checked_sub(1).and_then(|last| self.tokens.get(last));
        last.map_or(0..0, |token| token.span.clone())
    }

    fn timing(&mut self, rule: Rule, condition: &Condition) -> Parsed<Timing> {
        let mut clauses = Clauses::default();
        while let Some(keyword) = self.peek().cloned() {
            let clause = match keyword.text {
                "within" => Clause::Within,
                "after" => Clause::After,
                "for" => Clause::For,
                "at" => Clause::At,
                _ => return Err(self.unexpected(A_TIMING)),
            };
            self.next += 1;
            let at_end = clause == Clause::At && self.take("end");
            let time = if at_end { Time::End } else { Time::Ns(self.time()?) };
            let span = keyword.span.start..self.last_span().end;
            clauses
                .add(clause, time, rule, condition)
                .map_err(|message| ExpectError::Conflict { message, span })?;
        }
        Ok(clauses.timing())
    }

    /// A time; its unit may stand apart.
    fn time(&mut self) -> Parsed<u64> {
        let (word, span) = self.word(A_TIME)?;
        let unit = self.peek().filter(|token| literal::is_unit(token.text)).map(|token| token.text);
        if let Some(unit) = unit {
            self.next += 1;
            let span = span.start..self.last_span().end;
            let time_ns = literal::time_ns(&format!("{word}{unit}"));
            return time_ns.ok_or_else(|| wrong(A_TIME, self.text.get(span.clone()).unwrap_or(word), span));
        }
        literal::time_ns(word).ok_or_else(|| wrong(A_TIME, word, span))
    }
}

fn wrong(expected: &'static str, found: &str, span: Range<usize>) -> ExpectError {
    ExpectError::Expected { expected, found: format!("`{found}`"), span }
}

fn no_value(word: &str, span: Range<usize>, spec: &ParameterSpec) -> ExpectError {
    let values: Vec<_> = spec.values.iter().map(|value| value.id).collect();
    ExpectError::Value {
        name: word.to_owned(),
        parameter: spec.id.to_owned(),
        values: values.join(", "),
        span,
    }
}
