use proptest::prelude::*;
use tmcl_tables::{MODULES, ModuleSpec};

use super::*;
use crate::item::items;

const SPEC: &ModuleSpec = &tmcl_tables::tmcm_1311::SPEC;

fn defaults(module: &'static ModuleSpec) -> Vec<(Item, i64)> {
    let value = |item: Item| item.spec().map_or(0, |spec| spec.default);
    items(module).map(|item| (item, value(item))).collect()
}

fn header(module: &'static ModuleSpec) -> Header<'static> {
    Header { module, firmware: module.firmware, writer: "tmcl 0.0.0" }
}

fn values(config: &Config) -> Vec<(Item, i64)> {
    config.entries.iter().map(|entry| (entry.item, entry.value)).collect()
}

fn report(text: &str) -> String {
    let findings = parse(text).expect_err("something is wrong");
    let line = |finding: &Finding| {
        let before = &text[..finding.span.start];
        let line = before.matches('\n').count() + 1;
        let marked = &text[finding.span.clone()];
        let help = finding.help.as_deref().map_or_else(String::new, |help| format!(" ({help})"));
        format!("{line} <{marked}> {finding}{help}\n")
    };
    findings.iter().map(line).collect()
}

#[test]
fn the_factory_settings_of_a_small_module() {
    insta::assert_snapshot!(write(
        header(&tmcl_tables::tmcm_1076::SPEC),
        &defaults(&tmcl_tables::tmcm_1076::SPEC)
    ));
}

#[test]
fn the_settings_of_a_module_come_back() {
    for module in MODULES {
        let written = write(header(module), &defaults(module));
        let config = parse(&written).expect("it is what was written");
        let (major, minor) = module.firmware;
        assert_eq!(config.module, module);
        assert_eq!(config.firmware, Some(format!("{major}.{minor:02}")));
        let kept: Vec<_> = defaults(module).into_iter().filter(|(item, _)| item.is_configuration()).collect();
        assert_eq!(values(&config), kept);
        assert_eq!(written, write(header(module), &defaults(module)), "nothing but the arguments counts");
    }
}

#[test]
fn what_starts_a_motion_stands_in_a_comment() {
    let text = write(header(SPEC), &defaults(SPEC));
    assert!(text.contains("\n# closed_loop_mode = \"open_loop\"\n"), "{text}");
    assert!(!text.contains("target_position"));
}

#[test]
fn what_a_module_holds_and_does_not_take_stands_in_a_comment() {
    let item = Item::by_id(SPEC, "chopper_off_time").expect("it has it");
    let text = write(header(SPEC), &[(item, 1)]);
    assert!(
        text.contains("\n# chopper_off_time = 1  # `chopper_off_time` cannot be 1: allowed is 0, 2…15\n"),
        "{text}"
    );
    assert_eq!(parse(&text).map(|config| config.entries), Ok(Vec::new()));
}

#[test]
fn values_may_be_names_numbers_and_numbers_with_a_unit() {
    let text = "module = \"1311\"\n[axis]\nmax_velocity = \"0x10 pps\"\n5 = 0x20\n[global]\nauto_start = \"on\"\n\
                eeprom_lock = 1234\n\"3/0\" = 5\n[variable]\n3 = -7\n[coordinate]\n2 = 9\n";
    let config = parse(text).expect("nothing is wrong");
    let found: Vec<_> = values(&config).into_iter().map(|(item, value)| (item.name(), value)).collect();
    let expected = [
        ("max_velocity", 16),
        ("max_acceleration", 32),
        ("eeprom_lock", 1),
        ("auto_start", 1),
        ("variable.3", -7),
        ("timer_0_period", 5),
        ("coordinate.2", 9),
    ];
    assert_eq!(found, expected.map(|(name, value)| (name.to_owned(), value)));
}

#[test]
fn everything_that_is_wrong_is_said_with_its_place() {
    insta::assert_snapshot!(report(
        "module = \"tmcm-1311\"\n\
         firmware = 1.11\n\
         max_current = 3\n\
         axes = 1\n\
         global = 3\n\
         [axis]\n\
         max_velocty = 3\n\
         max_velocity = -1\n\
         max_acceleration = 1.5\n\
         5 = 3\n\
         max_current = 300\n\
         supply_voltage = 3\n\
         actual_position = 3\n\
         target_position = 3\n\
         closed_loop_mode = 1\n\
         auto_start = 1\n\
         soft_stop = true\n\
         standby_current = \"5 mA\"\n\
         encoder_mode.null_active_high = 1\n\
         \"encoder_mode.null_active_high\" = 1\n\
         4 = 7\n\
         [connection]\n\
         baud_rate = \"baud_9601\"\n\
         [variable]\n\
         56 = 1\n\
         x = 1\n\
         [coordinate]\n\
         21 = 1\n\
         [axs]\n"
    ));
    assert_eq!(
        report("[axis]\n"),
        "1 <> the file does not say which module it is for (begin with module = \"…\"; there are tmcm-1076, tmcm-1311, \
         tmcm-1640)\n"
    );
    assert_eq!(
        report("module = \"tmcm-9\"\n"),
        "1 <\"tmcm-9\"> no such module (there are tmcm-1076, tmcm-1311, tmcm-1640)\n"
    );
    assert!(report("module = \n[axis]\nx = \n").contains("not TOML"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn any_text_is_a_configuration_or_an_error_within_it(text in "\\PC{0,80}") {
        for text in [text.clone(), format!("module = \"tmcm-1311\"\n[axis]\n{text}")] {
            if let Err(findings) = parse(&text) {
                prop_assert!(!findings.is_empty());
                for finding in findings {
                    prop_assert!(text.get(finding.span).is_some());
                }
            }
        }
    }

    /// Any values that may be written come back.
    #[test]
    fn legal_values_come_back(seeds in proptest::collection::vec(any::<u64>(), 400)) {
        for module in MODULES {
            let pick = |item: Item, seed: u64| {
                let range = item.range();
                let count = range.intervals.len() as u64;
                let (low, high) = range.intervals[(seed % count) as usize];
                let steps = (high - low) / range.step;
                low + (seed / count % (steps as u64 + 1)) as i64 * range.step
            };
            let kept = items(module).filter(|item| item.is_configuration());
            let values: Vec<_> = kept.zip(&seeds).map(|(item, seed)| (item, pick(item, *seed))).collect();
            let text = write(header(module), &values);
            let config = parse(&text).map_err(|findings| TestCaseError::fail(format!("{findings:?}\n{text}")))?;
            prop_assert_eq!(super::tests::values(&config), values);
        }
    }
}
