//! Any text as a bench file: parsing does not panic, every error points into the text, and what parses can be built and run.
#![no_main]

use libfuzzer_sys::fuzz_target;
use virtual_bench::{Bench, config};

fuzz_target!(|text: &str| {
    match config::parse(text) {
        Ok(config) => Bench::new(&config).advance_by(1_000_000),
        Err(errors) => {
            assert!(!errors.is_empty());
            for error in errors {
                let _ = error.report("bench.toml", text);
            }
        }
    }
});
