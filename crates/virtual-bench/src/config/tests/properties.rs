//! Nothing makes the reader panic, and what it says can be shown.

use proptest::prelude::*;

use super::super::{SETTINGS, parse, parse_setting};
use crate::{ModuleKind, config::BenchConfig};

const KEYS: [&str; 33] = [
    "temperature_c",
    "voltage_v",
    "kind",
    "name",
    "address",
    "preset",
    "resistance_ohm",
    "pole_pairs",
    "full_steps",
    "inertia_kgm2",
    "torque_nm",
    "torque",
    "hard_stops",
    "low_turns",
    "by",
    "points",
    "period",
    "counts",
    "index",
    "left",
    "home.at_turns",
    "in_1",
    "ain_0",
    "frequency_hz",
    "pulses",
    "offset_deg",
    "torque_constant_nm_per_a",
    "enable",
    "from",
    "to",
    "at",
    "set",
    "µ",
];

const HEADERS: [&str; 15] = [
    "[supply]",
    "[bus]",
    "[[module]]",
    "[module.motor]",
    "[module.load]",
    "[module.load.torque]",
    "[module.encoder]",
    "[module.switches]",
    "[module.switches.home]",
    "[module.inputs]",
    "[module.step_dir]",
    "[module.halls]",
    "[[wire]]",
    "[[event]]",
    "[event.set]",
];

const VALUES: [&str; 21] = [
    "1",
    "-1",
    "0",
    "1e400",
    "nan",
    "-inf",
    "0.5",
    "99999999999999999999999",
    "true",
    "\"tmcm-1311\"",
    "\"tmcm-1640\"",
    "\"a\"",
    "\"m1.output.0\"",
    "\"m1.input.1\"",
    "\"1s\"",
    "[[0, 0], [1, 2]]",
    "[]",
    "{ power = \"off\" }",
    "{ at_turns = 1 }",
    "1979-05-27",
    "\"ÄÖ\\u0000\"",
];

/// Lines as they stand in bench files, in no sensible order.
fn lines() -> impl Strategy<Value = String> {
    let pair = (proptest::sample::select(&KEYS[..]), proptest::sample::select(&VALUES[..]));
    let line = prop_oneof![
        3 => proptest::sample::select(&HEADERS[..]).prop_map(str::to_owned),
        6 => pair.prop_map(|(key, value)| format!("{key} = {value}")),
        1 => "\\PC{0,12}",
    ];
    proptest::collection::vec(line, 0..24).prop_map(|lines| lines.join("\n"))
}

/// Every error lies within the text and can be shown.
fn check(text: &str) {
    if let Err(errors) = parse(text) {
        assert!(!errors.is_empty());
        for error in errors {
            assert!(error.span.start <= error.span.end && error.span.end <= text.len(), "{error:?}");
            let (line, column) = error.line_column(text);
            assert!(line >= 1 && line <= text.split('\n').count() && column >= 1, "{error:?}");
            assert!(error.report("bench.toml", text).contains(&error.message));
        }
    }
}

proptest! {
    #[test]
    fn arbitrary_text_is_read_or_refused(text in any::<String>()) {
        check(&text);
    }

    #[test]
    fn arbitrary_printable_text_is_read_or_refused(text in "[\\[\\]{}=.,\"'#\na-z0-9\\PC]{0,200}") {
        check(&text);
    }

    #[test]
    fn jumbled_bench_files_are_read_or_refused(text in lines()) {
        check(&text);
    }

    /// A file cut short anywhere.
    #[test]
    fn files_cut_short_are_read_or_refused(length in 0..4000_usize) {
        let text = include_str!("../../../../../examples/benches/stop-switches.toml");
        let length = (0..=length.min(text.len())).rev().find(|length| text.is_char_boundary(*length)).unwrap_or(0);
        check(&text[..length]);
    }

    #[test]
    fn arbitrary_settings_are_understood_or_refused(name in any::<String>(), value in any::<String>()) {
        let _ = parse_setting(&BenchConfig::default_for(ModuleKind::Tmcm1311), &name, value.as_str().into());
    }

    /// A number that is taken is taken as it is.
    #[test]
    fn numbers_survive(torque_nm in -100.0..=100.0) {
        let bench = BenchConfig::default_for(ModuleKind::Tmcm1311);
        let settings = parse_setting(&bench, SETTINGS[0], format!("{torque_nm}").as_str().into());
        prop_assert_eq!(settings, Ok(vec![(0, super::super::Setting::LoadTorqueNm(torque_nm))]));
    }
}

/// Neither brackets nor dots a hundred thousand deep exhaust the stack.
#[test]
fn deep_nesting_is_refused() {
    for text in [
        format!("a={}", "[".repeat(100_000)),
        format!("{}a=1", "a.".repeat(100_000)),
        format!("[{}a]", "a.".repeat(100_000)),
    ] {
        check(&text);
        assert!(parse(&text).is_err());
    }
}
