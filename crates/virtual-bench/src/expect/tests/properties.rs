//! Nothing makes the reader panic, and what it says can be shown.

use proptest::prelude::*;

use super::super::{Expectation, Monitor};
use super::one;

const PARTS: [&str; 34] = [
    "never",
    "always",
    "and",
    "rises",
    "falls",
    "changes",
    "within",
    "after",
    "for",
    "at",
    "end",
    "==",
    "!=",
    "<",
    "<=",
    ">",
    ">=",
    "&",
    "+-",
    "±",
    "actual_position",
    "tick_timer",
    "output.3",
    "status_word",
    "physical.torque_nm",
    "variable.255",
    "0x200",
    "$FFFFFFFF",
    "-1",
    "1e308",
    "1ms",
    "2 s",
    "µs",
    "=",
];

/// An error lies within the text and can be shown; an expectation can be watched.
fn check(text: &str) {
    let mut bench = one();
    match Expectation::parse(text, &bench) {
        Ok(expectation) => {
            let mut monitor = Monitor::new(vec![expectation], &bench);
            monitor.advance_to(&mut bench, 2_000_000);
            monitor.finish(&bench);
            assert!(!monitor.verdicts()[0].to_string().is_empty());
        }
        Err(error) => {
            let span = error.span();
            assert!(text.get(span).is_some(), "{error:?}");
            assert_eq!(error.report(text).lines().count(), 3, "{error:?}");
        }
    }
}

proptest! {
    #[test]
    fn arbitrary_text_is_read_or_refused(text in any::<String>()) {
        check(&text);
    }

    #[test]
    fn jumbled_parts_are_read_or_refused(
        parts in proptest::collection::vec(prop_oneof![9 => proptest::sample::select(&PARTS[..]), 1 => Just("µ\0")], 0..10),
        glue in proptest::sample::select(&["", " ", "\t\n"][..]),
    ) {
        check(&parts.join(glue));
    }

    /// Beginnings of what is right: most comparisons that come out of this are.
    #[test]
    fn comparisons_are_read_or_refused(
        quantity in proptest::sample::select(&PARTS[20..26]),
        relation in proptest::sample::select(&PARTS[11..17]),
        number in any::<f64>(),
        clauses in proptest::collection::vec(proptest::sample::select(&["within 1ms", "for 1ms", "after 1ms", "at 1ms", "at end"][..]), 0..3),
    ) {
        check(&format!("{quantity} {relation} {number} {}", clauses.join(" ")));
    }
}
