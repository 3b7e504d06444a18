//! Any text as a session: parsing does not panic, every error points at a line, and what parses comes back when it is written
//! and parsed again.
#![no_main]

use emulated_module::Session;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    match Session::parse(text) {
        Ok(session) => {
            let written = session.to_string();
            assert_eq!(Session::parse(&written).expect("what is written can be read"), session);
        }
        Err(error) => assert!((1..=text.lines().count()).contains(&error.line), "{error}"),
    }
});
