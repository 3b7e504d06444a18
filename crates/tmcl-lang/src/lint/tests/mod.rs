//! Lint, rule by rule, on small programs, and on the manuals' listings.

mod builder;
mod flow;
mod interrupts;
mod large;
mod listings;
mod oracle;
mod rules;
