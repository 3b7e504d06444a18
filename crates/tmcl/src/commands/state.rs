//! `tmcl state`: what is kept in a folder of EEPROMs.

use std::path::Path;

use serde::Serialize;
use tmcl_server::state::{images, read_image};
use tmcl_tables::{ModuleSpec, ParameterSpec};
use virtual_bench::eeprom::{ENDURANCE, ImageError};
use virtual_bench::{Eeprom, RecordKey};

use crate::arguments::State;
use crate::exit::{Code, Failure, Outcome};
use crate::{print, state};

/// An image, as JSON has it. Of one that is damaged only the file and what is wrong are there.
#[derive(Serialize)]
struct Image {
    file: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    damage: Option<String>,
    #[serde(flatten)]
    contents: Option<Contents>,
}

#[derive(Serialize)]
struct Contents {
    module: &'static str,
    records: Vec<Record>,
    /// Instructions up to the last one that was ever written.
    instructions: usize,
    byte_writes: u64,
    most_worn_page: usize,
    most_worn_page_writes: u32,
    endurance: u32,
}

#[derive(Serialize)]
struct Record {
    kind: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    bank: Option<u8>,
    number: u8,
    id: String,
    value: i64,
    #[serde(skip_serializing_if = "str::is_empty")]
    named: &'static str,
    #[serde(skip_serializing_if = "str::is_empty")]
    unit: &'static str,
}

/// Prints it.
pub(crate) fn run(options: &State) -> Outcome {
    let paths = images(&options.path).map_err(state::failure)?;
    if paths.is_empty() {
        let message = format!("there is no EEPROM in {}: no file ends in .eeprom", options.path.display());
        return Err(Failure::new(Code::Usage, message).into());
    }
    let images = paths.iter().map(|path| image(path)).collect::<Result<Vec<_>, _>>()?;
    if options.json {
        print::json(&images)?;
    } else {
        for (index, image) in images.iter().enumerate() {
            if index > 0 {
                print::text("\n")?;
            }
            print_image(image)?;
        }
    }
    match images.iter().any(|image| image.damage.is_some()) {
        true => Err(Code::Findings.into()),
        false => Ok(()),
    }
}

fn image(path: &Path) -> Result<Image, Failure> {
    let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let found = read_image(path).map_err(state::failure)?;
    let damage = found.as_ref().err().map(ImageError::to_string);
    Ok(Image { file, damage, contents: found.ok().as_ref().map(contents) })
}

fn contents(eeprom: &Eeprom) -> Contents {
    let spec = eeprom.kind().spec();
    let (most_worn_page, most_worn_page_writes) = eeprom.most_worn();
    Contents {
        module: spec.id,
        records: eeprom.records().map(|(key, value)| record(spec, key, value)).collect(),
        instructions: eeprom.program().len(),
        byte_writes: eeprom.writes(),
        most_worn_page,
        most_worn_page_writes,
        endurance: ENDURANCE,
    }
}

/// A record, named by the module's tables. What they do not know can only come from elsewhere, and keeps its number.
fn record(spec: &'static ModuleSpec, key: RecordKey, bits: i32) -> Record {
    let (kind, bank, number) = match key {
        RecordKey::Axis(number) => ("axis", None, number),
        RecordKey::Coordinate(number) => ("coordinate", None, number),
        RecordKey::Global(bank, number) => ("global", Some(bank), number),
    };
    let parameter: Option<&'static ParameterSpec> = match key {
        RecordKey::Axis(number) => spec.axis_parameter(number),
        RecordKey::Global(bank, number) => spec.global_parameter(bank, number).map(|entry| &entry.parameter),
        RecordKey::Coordinate(_) => None,
    };
    let value = parameter.map_or(i64::from(bits), |parameter| parameter.from_wire(bits));
    let named = parameter.and_then(|parameter| parameter.values.iter().find(|named| named.value == value));
    let id = match (key, parameter) {
        (RecordKey::Global(2, number), Some(_)) => format!("variable.{number}"),
        (_, Some(parameter)) => parameter.id.to_owned(),
        (RecordKey::Coordinate(number), None) => format!("coordinate.{number}"),
        (RecordKey::Axis(_) | RecordKey::Global(..), None) => String::new(),
    };
    Record {
        kind,
        bank,
        number,
        id,
        value,
        named: named.map_or("", |named| named.name),
        unit: parameter.map_or("", |parameter| parameter.unit),
    }
}

fn print_image(image: &Image) -> std::io::Result<()> {
    let Image { file, damage, contents } = image;
    if let Some(damage) = damage {
        print::text(&format!("{file}: damaged: {damage}\n"))?;
    }
    let Some(contents) = contents else { return Ok(()) };
    let Contents { module, records, instructions, byte_writes, most_worn_page, .. } = contents;
    let worn = contents.most_worn_page_writes;
    print::text(&format!(
        "{file}: {module}, intact\n  {} and {} stored\n  {byte_writes} bytes written; page {most_worn_page}, the most worn, \
         {worn} times of {ENDURANCE}\n",
        counted(records.len(), "record"),
        counted(*instructions, "instruction"),
    ))?;
    if records.is_empty() {
        return Ok(());
    }
    print::text("\n")?;
    print::table(["number", "identifier", "value", "unit", "meaning"], records.iter().map(cells))
}

fn counted(count: usize, what: &str) -> String {
    match count {
        0 => format!("no {what}s"),
        1 => format!("1 {what}"),
        count => format!("{count} {what}s"),
    }
}

fn cells(record: &Record) -> [String; 5] {
    let number = match record.bank {
        None => record.number.to_string(),
        Some(bank) => format!("{bank}/{}", record.number),
    };
    let Record { id, value, unit, named, .. } = record;
    [number, id.clone(), value.to_string(), (*unit).to_owned(), (*named).to_owned()]
}
