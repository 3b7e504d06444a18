//! What must hold of the tables before anything is generated from them.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::{Result, bail};

use super::data::{Module, Parameter, Role, Tables};

/// Checks everything, and reports every finding at once.
pub(crate) fn check(tables: &Tables) -> Result<()> {
    let mut findings = Vec::new();
    sorted("commands", tables.commands.iter().map(|command| (0, command.number)), &mut findings);
    unique("commands", tables.commands.iter().map(|command| command.id.as_str()), &mut findings);
    for module in &tables.modules {
        check_module(tables, module, &mut findings);
    }
    check_shared_ids(tables, &mut findings);
    if !findings.is_empty() {
        bail!("data/ is not consistent:\n  {}", findings.join("\n  "));
    }
    Ok(())
}

fn check_module(tables: &Tables, module: &Module, findings: &mut Vec<String>) {
    let id = &module.identity.id;
    if module.identity.version_string.len() != 8 {
        findings.push(format!("{id}: version_string has eight characters"));
    }
    if module.identity.axes != 1 {
        findings.push(format!("{id}: the firmware has one axis"));
    }
    sorted(&format!("{id} axis"), module.axis.iter().map(|entry| (0, entry.number)), findings);
    unique(&format!("{id} axis"), module.axis.iter().map(|entry| entry.id.as_str()), findings);
    sorted(&format!("{id} globals"), module.globals.iter().map(|entry| (entry.bank, entry.number)), findings);
    sorted(
        &format!("{id} ports"),
        module.identity.port.iter().map(|port| (port.bank, port.number)),
        findings,
    );
    unique(&format!("{id} ports"), module.identity.port.iter().map(|port| port.id.as_str()), findings);
    sorted(
        &format!("{id} interrupts"),
        module.identity.interrupt.iter().map(|entry| (0, entry.number)),
        findings,
    );
    for parameter in module.axis.iter().chain(&module.globals) {
        let place = format!("{id} {} ({})", parameter.number, parameter.id);
        check_parameter(parameter, &place, findings);
    }
    sorted(
        &format!("{id} commands"),
        module.identity.commands.iter().map(|entry| (0, entry.number)),
        findings,
    );
    for entry in &module.identity.commands {
        if !tables.commands.iter().any(|command| command.number == entry.number) {
            findings.push(format!("{id}: command {} is not in commands.toml", entry.number));
        }
        if entry.section.is_empty() && entry.beyond_manual.is_empty() {
            findings.push(format!("{id}: command {} names neither section nor source", entry.number));
        }
    }
    for interrupt in &module.identity.interrupt {
        if let Some(number) = interrupt.parameter
            && !module.globals.iter().any(|entry| entry.bank == 3 && entry.number == number)
        {
            findings.push(format!("{id}: interrupt {} names bank-3 parameter {number}", interrupt.id));
        }
    }
}

fn check_parameter(parameter: &Parameter, place: &str, findings: &mut Vec<String>) {
    let mut complain = |text: &str| findings.push(format!("{place}: {text}"));
    let step = parameter.step.unwrap_or(1);
    let ascending = |intervals: &[(i64, i64)]| {
        intervals.iter().all(|(low, high)| low <= high)
            && intervals.windows(2).all(|pair| pair[0].1 < pair[1].0)
    };
    if step < 1 || !ascending(&parameter.range) || !ascending(parameter.write_range()) {
        complain("intervals ascend, and step is positive");
    }
    if parameter.default % step != 0
        || !parameter.range.iter().any(|&(low, high)| (low..=high).contains(&parameter.default))
    {
        complain("the default is in the range");
    }
    let (low, high) =
        if parameter.unsigned { (0, u32::MAX.into()) } else { (i32::MIN.into(), i32::MAX.into()) };
    if parameter
        .range
        .iter()
        .chain(parameter.write_range())
        .any(|interval| interval.0 < low || interval.1 > high)
    {
        complain("the range fits 32 bits of the signedness given");
    }
    if !["R", "W", "RW", "RWE", "RE"].contains(&parameter.access.as_str()) {
        complain("access is R, W, RW, RE or RWE");
    }
    let in_configuration = parameter.role() != Role::State;
    if in_configuration && !parameter.access.starts_with("RW") {
        complain("only what can be read and written is part of a configuration");
    }
    let may_write = |value| parameter.write_range().iter().any(|&(low, high)| (low..=high).contains(&value));
    if parameter.values.iter().filter_map(|named| named.write).any(|value| !may_write(value)) {
        complain("what is written for a named value is in the range for writing");
    }
    if parameter.fields.iter().any(|field| field.bits[0] > field.bits[1] || field.bits[1] > 31) {
        complain("bits = [lowest, highest] within 32");
    }
    if parameter.summary.ends_with('.') || parameter.summary.is_empty() {
        complain("the summary is one line without a full stop");
    }
    if parameter.section.is_empty() && parameter.beyond_manual.is_empty() {
        complain("names neither section nor source");
    }
}

/// One number, one meaning: commands aside, global parameters and interrupts are family-wide enums.
fn check_shared_ids(tables: &Tables, findings: &mut Vec<String>) {
    let mut globals = BTreeMap::new();
    let mut interrupts = BTreeMap::new();
    for module in &tables.modules {
        for entry in module.globals.iter().filter(|entry| entry.bank != 2) {
            let known = globals.entry((entry.bank, entry.number)).or_insert(&entry.id);
            if *known != &entry.id {
                findings.push(format!("global {}/{} is {known} and {}", entry.bank, entry.number, entry.id));
            }
        }
        for entry in &module.identity.interrupt {
            let known = interrupts.entry(entry.number).or_insert(&entry.id);
            if *known != &entry.id {
                findings.push(format!("interrupt {} is {known} and {}", entry.number, entry.id));
            }
        }
    }
    unique("globals", globals.values().map(|id| id.as_str()), findings);
}

fn sorted(what: &str, keys: impl Iterator<Item = (u8, u8)>, findings: &mut Vec<String>) {
    let keys: Vec<_> = keys.collect();
    for pair in keys.windows(2).filter(|pair| pair[0] >= pair[1]) {
        findings.push(format!("{what}: {:?} is followed by {:?}", pair[0], pair[1]));
    }
}

fn unique<'a>(what: &str, ids: impl Iterator<Item = &'a str>, findings: &mut Vec<String>) {
    let mut seen = BTreeSet::new();
    for id in ids {
        if !seen.insert(id) {
            findings.push(format!("{what}: {id} twice"));
        }
    }
}
