//! Expectations: what shall be true of a run, in a line of text, and what came of it.
//!
//! An [`Expectation`] is read from text such as `actual_position == 10000 within 2s`; `docs/expectations.md` is the reference
//! for people. A [`Monitor`] looks at a bench after every control period and decides each of them as soon as it can be
//! decided. Both are plain data.
//!
//! This module must never know what a parameter means, nor how a run is reported or ends.
//!
//! ```
//! use virtual_bench::expect::{Expectation, Monitor, Outcome};
//! use virtual_bench::{Bench, BenchConfig, ModuleKind};
//!
//! let mut bench = Bench::new(&BenchConfig::default_for(ModuleKind::Tmcm1311));
//! let expectation = Expectation::parse("tick_timer == 5 within 10ms", &bench)?;
//! let mut monitor = Monitor::new(vec![expectation], &bench);
//! monitor.advance_to(&mut bench, 1_000_000_000);
//! monitor.finish(&bench);
//! assert_eq!(monitor.verdicts()[0].outcome, Outcome::Held { at_ns: 5_000_000 });
//! # Ok::<(), virtual_bench::expect::ExpectError>(())
//! ```

mod clauses;
mod condition;
mod error;
mod expectation;
mod lexer;
mod literal;
mod monitor;
mod parser;
mod show;
#[cfg(test)]
mod tests;
mod verdict;
mod watch;

pub use error::ExpectError;
pub use expectation::Expectation;
pub use monitor::Monitor;
pub use show::time as shown_time;
pub use verdict::{Outcome, Verdict};
