//! `tmcl info`: which module this is, and how it is.

use clap::Args;
use serde::Serialize;
use tmcl_client::ClientError;
use tmcl_config::Item;
use tmcl_tables::{GlobalParameter, ModuleSpec};

use crate::connection::{AnyClient, ConnectionOptions, told};
use crate::direct::{self, Answer, Exchange};
use crate::exit::Outcome;
use crate::print;

/// `tmcl info`.
#[derive(Args)]
pub(crate) struct Info {
    /// Print JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    connection: ConnectionOptions,
}

/// Global parameters that say how the module is set up.
const SETTINGS: [GlobalParameter; 9] = [
    GlobalParameter::SerialAddress,
    GlobalParameter::HostAddress,
    GlobalParameter::BaudRate,
    GlobalParameter::CanId,
    GlobalParameter::CanReplyId,
    GlobalParameter::CanBitRate,
    GlobalParameter::AutoStart,
    GlobalParameter::EepromLock,
    GlobalParameter::CodeProtection,
];

/// Axis parameters that say how it is, by the identifiers that the tables give them.
const STATE: [&str; 8] = [
    "supply_voltage",
    "dc_current",
    "module_temperature",
    "driver_temperature",
    "actual_position",
    "actual_velocity",
    "status_word",
    "minute_counter",
];

#[derive(Serialize)]
struct Report {
    module: &'static str,
    summary: &'static str,
    firmware: String,
    /// What the tables were made for.
    tables: String,
    port: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    program: Option<ProgramReport>,
    parameters: Vec<Parameter>,
}

#[derive(Serialize)]
struct ProgramReport {
    mode: String,
    address: u32,
    memory: u16,
}

#[derive(Serialize)]
struct Parameter {
    id: String,
    value: Option<i64>,
    unit: &'static str,
    meaning: String,
    #[serde(skip)]
    shown: String,
}

/// Prints it.
pub(crate) fn run(options: &Info) -> Outcome {
    let connection = options.connection.resolve()?;
    let (mut client, module) = connection.connect()?;
    let report = report(&mut client, module, connection.port()).map_err(|error| told(&client, &error))?;
    if options.json {
        return Ok(print::json(&report)?);
    }
    let row = |name: &str, value: String| [name.to_owned(), value, String::new()];
    let mut rows = vec![
        ["module".to_owned(), module.name.to_owned(), report.summary.to_owned()],
        row("firmware", report.firmware.clone()),
        row("port", report.port.clone()),
    ];
    if report.firmware != report.tables {
        rows.push(row("tables", format!("{}; what is newer in the module is not known here", report.tables)));
    }
    if let Some(ProgramReport { mode, address, memory }) = &report.program {
        rows.push(row("program", format!("{mode} at {address} of {memory}")));
    }
    rows.extend(report.parameters.iter().map(|it| [it.id.clone(), it.shown.clone(), it.meaning.clone()]));
    Ok(print::listing(["what", "value", "meaning"], rows.into_iter())?)
}

fn report(client: &mut AnyClient, module: &'static ModuleSpec, port: &str) -> Result<Report, ClientError> {
    let version = client.firmware_version()?;
    let (major, minor) = module.firmware;
    let program = if module.program_memory > 0 {
        let status = client.program_status()?;
        let (mode, address) = (status.mode.to_string(), status.address);
        Some(ProgramReport { mode, address, memory: module.program_memory })
    } else {
        None
    };
    let mut parameters = Vec::new();
    for item in asked_for(module) {
        parameters.push(parameter(client, module, item)?);
    }
    Ok(Report {
        module: module.id,
        summary: module.summary,
        firmware: format!("V{}.{:02}", version.major, version.minor),
        tables: format!("V{major}.{minor:02}"),
        port: port.to_owned(),
        program,
        parameters,
    })
}

/// Those that the module has.
fn asked_for(module: &'static ModuleSpec) -> Vec<Item> {
    let settings = SETTINGS.iter().filter_map(|parameter| {
        let (bank, number) = parameter.address();
        Item::global(module, bank, number)
    });
    settings.chain(STATE.iter().filter_map(|id| Item::by_id(module, id))).collect()
}

fn parameter(
    client: &mut AnyClient,
    module: &'static ModuleSpec,
    item: Item,
) -> Result<Parameter, ClientError> {
    let request = direct::reading(item);
    let answer = direct::send(client, request)?;
    let exchange = Exchange::new(client, request, &answer, module);
    let shown = match answer {
        Answer::Refused(_) => format!("refused, status {}", exchange.status_text()),
        _ => exchange.value_text(),
    };
    Ok(Parameter {
        id: item.name(),
        value: exchange.value,
        unit: exchange.unit,
        meaning: exchange.meaning,
        shown,
    })
}
