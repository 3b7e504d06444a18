//! Any text as an expectation: reading it does not panic, an error points into the text and can be shown, and what is read can be
//! watched.
#![no_main]

use libfuzzer_sys::fuzz_target;
use virtual_bench::expect::{Expectation, Monitor};
use virtual_bench::{Bench, BenchConfig, ModuleKind};

fuzz_target!(|text: &str| {
    let mut bench = Bench::new(&BenchConfig::default_for(ModuleKind::Tmcm1311));
    match Expectation::parse(text, &bench) {
        Ok(expectation) => {
            let mut monitor = Monitor::new(vec![expectation], &bench);
            monitor.advance_to(&mut bench, 1_000_000);
            monitor.finish(&bench);
            assert!(!monitor.verdicts()[0].to_string().is_empty());
        }
        Err(error) => {
            assert!(text.get(error.span()).is_some());
            assert_eq!(error.report(text).lines().count(), 3);
        }
    }
});
