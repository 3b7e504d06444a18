//! Any text as a configuration file: parsing does not panic, every error points into the text, and what parses comes back when
//! it is written and parsed again.
#![no_main]

use libfuzzer_sys::fuzz_target;
use tmcl_config::file::{self, Config, Header};

fn values(config: &Config) -> Vec<(tmcl_config::Item, i64)> {
    config.entries.iter().map(|entry| (entry.item, entry.value)).collect()
}

fuzz_target!(|text: &str| {
    match file::parse(text) {
        Ok(config) => {
            let header = Header { module: config.module, firmware: config.module.firmware, writer: "fuzz" };
            let written = file::write(header, &values(&config));
            let again = file::parse(&written).expect("what is written can be read");
            assert_eq!(values(&again), values(&config));
        }
        Err(findings) => {
            assert!(!findings.is_empty());
            for finding in findings {
                assert!(text.get(finding.span).is_some());
            }
        }
    }
});
