//! `tmcl params`: a module's parameters.

use serde::Serialize;
use tmcl_tables::{ParameterSpec, ParametersMarkdown, Role, Selection, Source, ValueSet};

use crate::arguments::Params;
use crate::exit::{Code, Failure, Outcome};
use crate::print;

/// A parameter, as JSON has it. `bank` is absent for axis parameters.
#[derive(Serialize)]
struct Row {
    #[serde(skip_serializing_if = "Option::is_none")]
    bank: Option<u8>,
    number: u8,
    last: u8,
    id: &'static str,
    name: &'static str,
    summary: &'static str,
    unit: &'static str,
    closed_loop_unit: &'static str,
    range: Range,
    range_chosen: bool,
    write_range: Range,
    default: i64,
    default_chosen: bool,
    access: String,
    role: &'static str,
    unsigned: bool,
    values: Vec<Value>,
    fields: Vec<Field>,
    starts_motion: bool,
    repeat_safe: bool,
    section: &'static str,
    beyond_manual: &'static str,
    note: &'static str,
}

#[derive(Serialize)]
struct Range {
    intervals: &'static [(i64, i64)],
    step: i64,
}

#[derive(Serialize)]
struct Value {
    value: i64,
    id: &'static str,
    name: &'static str,
}

#[derive(Serialize)]
struct Field {
    id: &'static str,
    low: u8,
    high: u8,
    name: &'static str,
}

/// Prints them.
pub(crate) fn run(options: &Params) -> Outcome {
    let module = options.module;
    let selection = match (options.axis, options.bank) {
        (true, _) => Selection::Axis,
        (false, Some(bank)) => Selection::Bank(bank),
        (false, None) => Selection::All,
    };
    let listed = listed(options, selection)?;
    if options.format.markdown {
        return Ok(print::text(&ParametersMarkdown { module, selection }.to_string())?);
    }
    if options.format.json {
        let rows: Vec<Row> = listed.iter().map(|&(bank, last, spec)| row(bank, last, spec)).collect();
        return Ok(print::json(&rows)?);
    }
    let header = ["number", "identifier", "range", "unit", "default", "access", "meaning"];
    Ok(print::table(header, listed.iter().map(|&(bank, last, spec)| cells(bank, last, spec)))?)
}

type Listed = (Option<u8>, u8, &'static ParameterSpec);

fn listed(options: &Params, selection: Selection) -> Result<Vec<Listed>, Failure> {
    let module = options.module;
    let mut listed: Vec<Listed> = Vec::new();
    if selection.has_axis() {
        listed.extend(module.axis_parameters.iter().map(|spec| (None, spec.number, spec)));
    }
    let globals = module.global_parameters.iter().filter(|entry| selection.has_bank(entry.bank));
    listed.extend(globals.map(|entry| (Some(entry.bank), entry.last, &entry.parameter)));
    if let (true, Some(bank)) = (listed.is_empty(), options.bank) {
        let mut banks: Vec<_> = module.global_parameters.iter().map(|entry| entry.bank.to_string()).collect();
        banks.dedup();
        let has = if banks.is_empty() {
            "no global parameters".to_owned()
        } else {
            format!("banks {}", banks.join(", "))
        };
        return Err(Failure::new(
            Code::Usage,
            format!("the {} has no bank {bank}; it has {has}", module.name),
        ));
    }
    Ok(listed)
}

fn cells(bank: Option<u8>, last: u8, spec: &ParameterSpec) -> [String; 7] {
    let number = match (bank, last == spec.number) {
        (None, _) => spec.number.to_string(),
        (Some(bank), true) => format!("{bank}/{}", spec.number),
        (Some(bank), false) => format!("{bank}/{}…{last}", spec.number),
    };
    [
        number,
        spec.id.to_owned(),
        spec.range.to_string(),
        spec.unit.to_owned(),
        spec.default.to_string(),
        spec.access.to_string(),
        spec.summary.to_owned(),
    ]
}

fn row(bank: Option<u8>, last: u8, spec: &ParameterSpec) -> Row {
    let range = |set: ValueSet| Range { intervals: set.intervals, step: set.step };
    Row {
        bank,
        number: spec.number,
        last,
        id: spec.id,
        name: spec.name,
        summary: spec.summary,
        unit: spec.unit,
        closed_loop_unit: spec.closed_loop_unit,
        range: range(spec.range),
        range_chosen: spec.range_from == Source::Chosen,
        write_range: range(spec.write_range),
        default: spec.default,
        default_chosen: spec.default_from == Source::Chosen,
        access: spec.access.to_string(),
        role: match spec.role {
            Role::Setting => "setting",
            Role::Connection => "connection",
            Role::Lock => "lock",
            Role::State => "state",
        },
        unsigned: spec.unsigned,
        values: spec
            .values
            .iter()
            .map(|named| Value { value: named.value, id: named.id, name: named.name })
            .collect(),
        fields: spec
            .fields
            .iter()
            .map(|field| Field { id: field.id, low: field.low, high: field.high, name: field.name })
            .collect(),
        starts_motion: spec.starts_motion,
        repeat_safe: spec.repeat_safe,
        section: spec.section,
        beyond_manual: spec.beyond_manual,
        note: spec.note,
    }
}
