//! The TOML of `data/`, as `data/README.md` describes it.

use std::path::Path;

use anyhow::{Context, Result};
use serde::Deserialize;
use serde::de::DeserializeOwned;

/// Everything under `data/`.
pub(crate) struct Tables {
    pub(crate) statuses: Vec<Status>,
    pub(crate) commands: Vec<Command>,
    pub(crate) modules: Vec<Module>,
}

/// One module's folder.
pub(crate) struct Module {
    pub(crate) identity: Identity,
    pub(crate) axis: Vec<Parameter>,
    pub(crate) globals: Vec<Parameter>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct StatusFile {
    status: Vec<Status>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Status {
    pub(crate) code: u8,
    pub(crate) id: String,
    pub(crate) name: String,
    pub(crate) summary: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CommandFile {
    command: Vec<Command>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Command {
    pub(crate) number: u8,
    #[serde(default)]
    pub(crate) mnemonic: String,
    pub(crate) id: String,
    pub(crate) name: String,
    pub(crate) summary: String,
    pub(crate) group: String,
    pub(crate) operands: Vec<String>,
    #[serde(rename = "type")]
    pub(crate) type_field: String,
    #[serde(rename = "motor")]
    pub(crate) motor_field: String,
    #[serde(rename = "value")]
    pub(crate) value_field: String,
    #[serde(default)]
    pub(crate) types: Vec<NamedType>,
    pub(crate) modes: Vec<String>,
    #[serde(default)]
    pub(crate) starts_motion: bool,
    #[serde(default = "yes")]
    pub(crate) repeat_safe: bool,
    #[serde(default)]
    pub(crate) note: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct NamedType {
    pub(crate) value: u8,
    pub(crate) id: String,
    #[serde(default)]
    pub(crate) keyword: String,
    pub(crate) name: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Identity {
    pub(crate) name: String,
    pub(crate) id: String,
    pub(crate) number: u16,
    pub(crate) version_string: String,
    pub(crate) firmware: [u8; 2],
    pub(crate) summary: String,
    pub(crate) interfaces: Vec<String>,
    pub(crate) program_memory: u16,
    pub(crate) axes: u8,
    pub(crate) coordinates: u8,
    pub(crate) commands: Vec<ModuleCommand>,
    #[serde(default)]
    pub(crate) port: Vec<Port>,
    #[serde(default)]
    pub(crate) interrupt: Vec<Interrupt>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ModuleCommand {
    pub(crate) number: u8,
    #[serde(default)]
    pub(crate) section: String,
    pub(crate) types: Option<Vec<u8>>,
    #[serde(default)]
    pub(crate) beyond_manual: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Port {
    pub(crate) bank: u8,
    pub(crate) number: u8,
    pub(crate) id: String,
    pub(crate) name: String,
    pub(crate) direction: String,
    pub(crate) range: Vec<(i64, i64)>,
    #[serde(default)]
    pub(crate) unit: String,
    pub(crate) section: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Interrupt {
    pub(crate) number: u8,
    pub(crate) id: String,
    pub(crate) name: String,
    pub(crate) symbol: String,
    pub(crate) parameter: Option<u8>,
    pub(crate) section: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ParameterFile {
    parameter: Vec<Parameter>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Parameter {
    #[serde(default)]
    pub(crate) bank: u8,
    pub(crate) number: u8,
    pub(crate) last: Option<u8>,
    pub(crate) name: String,
    pub(crate) id: String,
    pub(crate) summary: String,
    #[serde(default)]
    pub(crate) unit: String,
    pub(crate) closed_loop_unit: Option<String>,
    pub(crate) range: Vec<(i64, i64)>,
    #[serde(default)]
    pub(crate) range_from: Source,
    pub(crate) step: Option<i64>,
    pub(crate) write_range: Option<Vec<(i64, i64)>>,
    pub(crate) default: i64,
    #[serde(default)]
    pub(crate) default_from: Source,
    pub(crate) access: String,
    role: Option<Role>,
    #[serde(default)]
    pub(crate) unsigned: bool,
    #[serde(default)]
    pub(crate) values: Vec<NamedValue>,
    #[serde(default)]
    pub(crate) fields: Vec<Field>,
    #[serde(default)]
    pub(crate) starts_motion: bool,
    #[serde(default = "yes")]
    pub(crate) repeat_safe: bool,
    #[serde(default)]
    pub(crate) section: String,
    #[serde(default)]
    pub(crate) beyond_manual: String,
    #[serde(default)]
    pub(crate) note: String,
}

impl Parameter {
    /// The last number the entry stands for.
    pub(crate) fn last(&self) -> u8 {
        self.last.unwrap_or(self.number)
    }

    /// Its part in a configuration: what can be both read and written is a setting unless the table says otherwise.
    pub(crate) fn role(&self) -> Role {
        match self.role {
            Some(role) => role,
            None if self.access.starts_with("RW") => Role::Setting,
            None => Role::State,
        }
    }

    /// What a write may carry.
    pub(crate) fn write_range(&self) -> &[(i64, i64)] {
        self.write_range.as_deref().unwrap_or(&self.range)
    }
}

#[derive(Deserialize, Default, Debug, Clone, Copy, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Source {
    #[default]
    Manual,
    Chosen,
}

#[derive(Deserialize, Debug, Clone, Copy, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Role {
    Setting,
    Connection,
    Lock,
    State,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct NamedValue {
    pub(crate) value: i64,
    pub(crate) write: Option<i64>,
    pub(crate) id: String,
    pub(crate) name: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Field {
    pub(crate) id: String,
    pub(crate) bits: [u8; 2],
    pub(crate) name: String,
}

fn yes() -> bool {
    true
}

/// Reads `data/`.
pub(crate) fn load(folder: &Path, modules: &[&str]) -> Result<Tables> {
    Ok(Tables {
        statuses: read::<StatusFile>(&folder.join("status.toml"))?.status,
        commands: read::<CommandFile>(&folder.join("commands.toml"))?.command,
        modules: modules.iter().map(|id| load_module(&folder.join(id))).collect::<Result<_>>()?,
    })
}

fn load_module(folder: &Path) -> Result<Module> {
    let globals = folder.join("globals.toml");
    Ok(Module {
        identity: read(&folder.join("module.toml"))?,
        axis: read::<ParameterFile>(&folder.join("axis.toml"))?.parameter,
        globals: if globals.exists() { read::<ParameterFile>(&globals)?.parameter } else { Vec::new() },
    })
}

fn read<T: DeserializeOwned>(path: &Path) -> Result<T> {
    let text = std::fs::read_to_string(path).with_context(|| format!("reading {}", path.display()))?;
    toml::from_str(&text).with_context(|| format!("in {}", path.display()))
}
