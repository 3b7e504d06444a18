//! `tmcl factory-reset`: a module as it came.

use std::io::{IsTerminal, Write};
use std::time::Duration;

use clap::Args;
use tmcl_client::{Client, ClientError, FirmwareVersion, Parties, Settings};
use tmcl_link::Link;
use tmcl_tables::{Command, GlobalParameter, ModuleSpec};
use tmcl_wire::Request;

use crate::connection::{AnyClient, ConnectionOptions, told};
use crate::exit::{Code, Failure, Outcome};
use crate::print;

/// Without it command 137 does nothing (decisions of the project, "Wire").
const CONFIRMATION: i32 = 1234;

/// How often the module is asked whether it is back.
const ATTEMPTS: usize = 20;

/// The addresses of modules as they come, and their identifiers on a CAN bus (TMCM-1311 §5.7.36: GP 66, 76, 71, 70).
const FACTORY: Parties = Parties { module: 1, host: 2 };

/// `tmcl factory-reset`.
#[derive(Args)]
#[command(
    after_help = "Every setting and user variable in the EEPROM becomes what it was when the module came, addresses and bit rates \
    too, and the module starts anew: the motor stops. A program stays, unless it was protected from being read. The module is \
    looked for at its own address, and then at the factory's."
)]
pub(crate) struct FactoryReset {
    /// Do not ask
    #[arg(short, long)]
    yes: bool,
    #[command(flatten)]
    connection: ConnectionOptions,
}

/// Resets it.
pub(crate) fn run(options: &FactoryReset) -> Outcome {
    let (mut client, module) = options.connection.connect()?;
    if module.command(Command::FactoryReset.number()).is_none() {
        let message = format!("the {} has no command that resets it", module.name);
        return Err(Failure::new(Code::TmclStatus, message).into());
    }
    let address = client.parties().module;
    unlocked(&mut client, module)?;
    if !options.yes && !confirmed(module, address)? {
        return Err(Failure::new(Code::Usage, "nothing was done").into());
    }
    client
        .send(Request::new(Command::FactoryReset, 0, 0, CONFIRMATION))
        .map_err(|error| told(&client, &error))?;
    let (at, version) = back(client)?;
    let moved = if at == address { String::new() } else { format!(", now at address {at}") };
    print::note(&format!("the {version} is back with its factory settings{moved}"));
    Ok(())
}

/// A locked module ignores the command, without a word.
fn unlocked(client: &mut AnyClient, module: &ModuleSpec) -> Result<(), Failure> {
    let (bank, number) = GlobalParameter::EepromLock.address();
    if module.global_parameter(bank, number).is_none() {
        return Ok(());
    }
    match client.get_global_parameter(bank, number).map_err(|error| told(client, &error))? {
        0 => Ok(()),
        lock => {
            let message = format!(
                "the EEPROM is locked (global parameter {number} is {lock}), and a locked module ignores a factory reset; \
                 `tmcl exec 'SGP {number}, {bank}, 4321'` unlocks it"
            );
            Err(Failure::new(Code::TmclStatus, message))
        }
    }
}

/// Asks on a terminal; where there is none, somebody has to have said yes before.
fn confirmed(module: &ModuleSpec, address: u16) -> Result<bool, Failure> {
    if !std::io::stdin().is_terminal() {
        let message = format!("this sets all settings of the {} back; say --yes if you mean it", module.name);
        return Err(Failure::new(Code::Usage, message));
    }
    let unreadable = |error: std::io::Error| Failure::new(Code::Usage, format!("cannot ask: {error}"));
    let mut terminal = std::io::stderr();
    write!(
        terminal,
        "Set all settings of the {} at address {address} back to the factory's, addresses and bit rates too? \
         The motor stops. [y/N] ",
        module.name
    )
    .and_then(|()| terminal.flush())
    .map_err(unreadable)?;
    let mut answer = String::new();
    std::io::stdin().read_line(&mut answer).map_err(unreadable)?;
    Ok(matches!(answer.trim().to_ascii_lowercase().as_str(), "y" | "yes"))
}

/// Waits for the module, at its address and at the factory's.
fn back(client: AnyClient) -> Result<(u16, FirmwareVersion), Failure> {
    let settings = Settings { timeout: Duration::from_millis(150), retries: 0, ..client.settings() };
    let before = client.parties();
    let mut link = client.into_link();
    for _ in 0..ATTEMPTS {
        for parties in [FACTORY, before] {
            link.turn_to(parties).map_err(|error| gone(&error.to_string()))?;
            match Client::with_settings(&mut link, parties.within(settings)).firmware_version() {
                Ok(version) => return Ok((parties.module, version)),
                Err(ClientError::Link(error)) => return Err(gone(&error.to_string())),
                Err(_) => {}
            }
        }
        link.wait(Duration::from_millis(50)).map_err(|error| gone(&error.to_string()))?;
    }
    Err(gone("it may have another bit rate now, or be on another interface: the factory's"))
}

fn gone(why: &str) -> Failure {
    Failure::new(Code::Connection, format!("the reset was sent, and the module did not come back: {why}"))
}
