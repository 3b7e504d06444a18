//! A command sent, and what came back.

use serde::Serialize;
use tmcl_client::{Client, ClientError, Described};
use tmcl_link::Link;
use tmcl_tables::{Command, ModuleSpec, STATUSES, Status};
use tmcl_wire::Request;

use super::Meaning;
use crate::connection::{AnyClient, follow};

/// What a module answers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Answer {
    /// A reply of the normal form that says yes.
    Value(Status, i32),
    /// The eight characters that answer command 136 of type 0.
    Version(String),
    /// The instruction that answers command 134.
    Instruction([u8; 7]),
    /// Nothing, and so it shall be (137 and 255).
    Silence,
    /// A reply that says no.
    Refused(Status),
}

/// As [`ask`], and goes on talking to a module that was told another address.
pub(crate) fn send(client: &mut AnyClient, request: Request) -> Result<Answer, ClientError> {
    let answer = ask(client, request)?;
    if matches!(answer, Answer::Value(Status::Ok, _))
        && request.command == Command::SetGlobalParameter.number()
    {
        follow(client, request.motor, request.kind, request.value.into())?;
    }
    Ok(answer)
}

/// Sends a command in the way that its kind of reply wants. A refusal is an answer.
pub(crate) fn ask<L: Link>(client: &mut Client<L>, request: Request) -> Result<Answer, ClientError> {
    let answer = match Command::try_from(request.command) {
        Ok(Command::FirmwareVersion) if request.kind == 0 => client.version_string().map(Answer::Version),
        Ok(Command::ReadProgramMemory) => {
            client.read_program_instruction(request.value.cast_unsigned()).map(Answer::Instruction)
        }
        Ok(Command::FactoryReset | Command::SoftwareReset) if is_confirmed(request) => {
            client.send(request).map(|()| Answer::Silence)
        }
        _ => client.request(request).map(|reply| Answer::Value(reply.status, reply.value)),
    };
    match answer {
        Err(ClientError::Status { status, .. }) => Ok(Answer::Refused(status)),
        answer => answer,
    }
}

/// Whether it carries the value without which these commands are refused, and answered.
fn is_confirmed(request: Request) -> bool {
    const CONFIRMATION: i32 = 1234;
    request.value == CONFIRMATION
}

/// A command and its answer, for people and machines.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Exchange {
    /// As program text.
    pub(crate) command: String,
    /// The bytes that were sent.
    pub(crate) sent: String,
    /// The bytes of the reply; none where there is none.
    pub(crate) received: Option<String>,
    /// The number of the status; none where no reply, or one of another form, is the answer.
    pub(crate) status: Option<u8>,
    pub(crate) status_name: &'static str,
    /// The value; none where the module refused.
    pub(crate) value: Option<i64>,
    /// The value as people read it.
    #[serde(skip)]
    pub(crate) shown: String,
    /// The unit of the value; empty where it has none.
    pub(crate) unit: &'static str,
    /// What the value is about.
    pub(crate) meaning: String,
}

impl Exchange {
    /// Of the request that was sent last.
    pub(crate) fn new<L: Link>(
        client: &Client<L>,
        request: Request,
        answer: &Answer,
        module: &'static ModuleSpec,
    ) -> Self {
        let line = client.last_exchange();
        let sent = line.map_or_else(String::new, |line| hexadecimal(&line.sent));
        let received = line.and_then(tmcl_client::Exchange::reply).map(|reply| hexadecimal(&reply));
        let command = Described(request).to_string();
        let plain = |status: Option<Status>, shown: String, meaning: &str| Self {
            command: command.clone(),
            sent: sent.clone(),
            received: received.clone(),
            status: status.map(Status::number),
            status_name: status.map_or("", status_name),
            value: None,
            shown,
            unit: "",
            meaning: meaning.to_owned(),
        };
        match answer {
            Answer::Value(status, value) => {
                let Meaning { value, unit, name } = Meaning::of(request, *value, module);
                Self {
                    value: Some(value),
                    unit,
                    meaning: name,
                    ..plain(Some(*status), value.to_string(), "")
                }
            }
            Answer::Version(text) => plain(None, text.clone(), "Firmware version"),
            Answer::Instruction(bytes) => {
                plain(None, hexadecimal(bytes), &Described(Request::from_bytes(*bytes)).to_string())
            }
            Answer::Silence => plain(None, String::new(), "No reply, as is usual for this command"),
            Answer::Refused(status) => plain(Some(*status), String::new(), ""),
        }
    }

    /// `100 OK`.
    pub(crate) fn status_text(&self) -> String {
        self.status.map_or_else(|| "-".to_owned(), |number| format!("{number} {}", self.status_name))
    }

    /// The value with its unit.
    pub(crate) fn value_text(&self) -> String {
        match self.unit {
            "" => self.shown.clone(),
            unit => match self.value.and_then(|value| in_whole_units(value, unit)) {
                Some(whole) => format!("{} ({whole})", self.shown),
                None => format!("{} {unit}", self.shown),
            },
        }
    }
}

/// 240 counted in units of `0.1 V` is `24.0 V`.
fn in_whole_units(value: i64, unit: &str) -> Option<String> {
    let (scale, unit) = unit.split_once(' ')?;
    let digits = scale.strip_prefix("0.")?.len();
    let scale: f64 = scale.parse().ok()?;
    Some(format!("{:.digits$} {unit}", value as f64 * scale))
}

/// The manual's name.
pub(crate) fn status_name(status: Status) -> &'static str {
    STATUSES.iter().find(|spec| spec.status == status).map_or("", |spec| spec.name)
}

/// `01 06 0a`.
pub(crate) fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect::<Vec<_>>().join(" ")
}
