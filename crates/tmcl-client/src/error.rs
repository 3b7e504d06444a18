//! What goes wrong between host and module, and how it is said.

use std::fmt;
use std::time::Duration;

use tmcl_link::LinkError;
use tmcl_tables::{STATUSES, Status};
use tmcl_wire::Request;

use crate::Described;
use crate::exchange::hexadecimal;

/// Why a call did not do what it should.
#[derive(Debug, thiserror::Error)]
pub enum ClientError {
    /// The link is broken.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// No reply came, or none that could be read. Whether the module executed the command is not known.
    #[error("no reply to {} within {} ms{}: {heard}", Described(*.request), .timeout.as_millis(), times(*.attempts))]
    NoReply {
        /// What was asked.
        request: Request,
        /// How long each attempt lasted.
        timeout: Duration,
        /// How often it was asked.
        attempts: u32,
        /// What came instead.
        heard: Heard,
    },
    /// The module refused.
    #[error("the module refused {}: {}", Described(*.request), status_text(*.status))]
    Status {
        /// What was asked.
        request: Request,
        /// What it said.
        status: Status,
    },
    /// The module answered with a status that no manual here knows.
    #[error("the module answered {} with the unknown status {status}", Described(*.request))]
    UnknownStatus {
        /// What was asked.
        request: Request,
        /// The number.
        status: u8,
    },
    /// The module is in download mode and took the command for a part of a program.
    #[error(
        "the module did not execute {} but stored it in its program memory: it is in download mode, \
         from which command 133 leads out",
        Described(*.request)
    )]
    Stored {
        /// What was asked.
        request: Request,
    },
    /// The module answered, and the answer makes no sense.
    #[error("the module answered {} with {value:#010x}, which means nothing", Described(*.request))]
    Meaningless {
        /// What was asked.
        request: Request,
        /// The value of the reply.
        value: i32,
    },
    /// The module executed what it should have stored.
    #[error("the module executed {} instead of storing it: it is not in download mode", Described(*.request))]
    Executed {
        /// The instruction.
        request: Request,
    },
    /// A program holds what cannot be stored: the module would execute it during the download.
    #[error("instruction {address} is {}, which a program cannot hold", Described(*.request))]
    NotStorable {
        /// The address of the instruction.
        address: usize,
        /// The instruction.
        request: Request,
    },
    /// A download broke off; the program memory holds what was stored so far.
    #[error(
        "the download stopped after {address} of {count} instructions{}: {source}",
        still_downloading(*.ended)
    )]
    Download {
        /// The address of the instruction that was not stored.
        address: usize,
        /// How many instructions the program has.
        count: usize,
        /// Whether the module confirmed that it left download mode.
        ended: bool,
        /// What went wrong.
        source: Box<ClientError>,
    },
    /// A whole program was stored, but the module did not say that it left download mode.
    #[error("all {count} instructions were stored, but the download did not end: {source}")]
    DownloadEnd {
        /// How many instructions the program has.
        count: usize,
        /// What went wrong.
        source: Box<ClientError>,
    },
    /// The program memory holds something else than it should.
    #[error(
        "the program memory differs at address {address}: it should hold {}, and holds {}",
        hexadecimal(.expected),
        hexadecimal(.found)
    )]
    Differs {
        /// Where; the first such address.
        address: usize,
        /// What should be there.
        expected: [u8; 7],
        /// What is there.
        found: [u8; 7],
    },
}

/// What came in place of a reply.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Heard {
    /// Not a byte.
    #[default]
    Nothing,
    /// This many bytes, with no reply in them.
    Noise(usize),
    /// A whole reply, from another module or to another host.
    Other {
        /// The host it was for.
        host: u8,
        /// The module it came from.
        module: u8,
    },
    /// A whole reply of the right module, to another command.
    OtherCommand(u8),
}

impl fmt::Display for Heard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Nothing => {
                f.write_str("nothing came; is it switched on, and are address and baud rate right?")
            }
            Self::Noise(1) => f.write_str("one byte came, which is no reply"),
            Self::Noise(count) => {
                write!(f, "{count} bytes came, and no reply in them; is the baud rate right?")
            }
            Self::Other { host, module } => {
                write!(f, "a reply came from module {module} to host {host}; is the address right?")
            }
            Self::OtherCommand(command) => write!(f, "a reply to command {command} came instead"),
        }
    }
}

fn times(attempts: u32) -> String {
    if attempts == 1 { String::new() } else { format!(" ({attempts} times)") }
}

fn status_text(status: Status) -> String {
    let number = status.number();
    match STATUSES.iter().find(|spec| spec.status == status) {
        Some(spec) => format!("{} (status {number}). {}", spec.name, spec.summary),
        None => format!("status {number}"),
    }
}

fn still_downloading(ended: bool) -> &'static str {
    if ended { "" } else { " (the module may still be in download mode)" }
}

#[cfg(test)]
mod tests {
    use tmcl_tables::Command;

    use super::*;

    #[test]
    fn messages_say_what_was_asked_and_what_came() {
        let request = Request::new(Command::GetAxisParameter, 21, 0, 0);
        let download = Request::new(Command::DownloadStart, 0, 0, 0);
        let timeout = Duration::from_millis(500);
        let refused = || ClientError::Status { request: download, status: Status::NotAvailable };
        let errors = [
            ClientError::Status { request, status: Status::WrongType },
            ClientError::UnknownStatus { request, status: 77 },
            ClientError::NoReply { request, timeout, attempts: 3, heard: Heard::Nothing },
            ClientError::NoReply { request, timeout, attempts: 1, heard: Heard::Noise(9) },
            ClientError::NoReply {
                request,
                timeout,
                attempts: 1,
                heard: Heard::Other { host: 2, module: 5 },
            },
            ClientError::Stored { request },
            ClientError::Meaningless { request: download, value: 0x7000_0001 },
            ClientError::Download { address: 4, count: 10, ended: true, source: Box::new(refused()) },
            ClientError::Download { address: 4, count: 10, ended: false, source: Box::new(refused()) },
            ClientError::DownloadEnd { count: 10, source: Box::new(refused()) },
            ClientError::Executed { request },
            ClientError::NotStorable { address: 7, request: download },
            ClientError::Differs {
                address: 3,
                expected: [1, 0, 0, 0, 0, 0, 200],
                found: [28, 0, 0, 0, 0, 0, 0],
            },
        ];
        let text = errors.map(|error| error.to_string()).join("\n");
        insta::assert_snapshot!(text, @r#"
        the module refused GAP 21, 0: Wrong type (status 3). No such parameter, port, bank, interrupt or type, or it cannot be accessed this way
        the module answered GAP 21, 0 with the unknown status 77
        no reply to GAP 21, 0 within 500 ms (3 times): nothing came; is it switched on, and are address and baud rate right?
        no reply to GAP 21, 0 within 500 ms: 9 bytes came, and no reply in them; is the baud rate right?
        no reply to GAP 21, 0 within 500 ms: a reply came from module 5 to host 2; is the address right?
        the module did not execute GAP 21, 0 but stored it in its program memory: it is in download mode, from which command 133 leads out
        the module answered "Start download" (command 132) with 0x70000001, which means nothing
        the download stopped after 4 of 10 instructions: the module refused "Start download" (command 132): Command not available (status 6). The command exists, but not now or not here
        the download stopped after 4 of 10 instructions (the module may still be in download mode): the module refused "Start download" (command 132): Command not available (status 6). The command exists, but not now or not here
        all 10 instructions were stored, but the download did not end: the module refused "Start download" (command 132): Command not available (status 6). The command exists, but not now or not here
        the module executed GAP 21, 0 instead of storing it: it is not in download mode
        instruction 7 is "Start download" (command 132), which a program cannot hold
        the program memory differs at address 3: it should hold 01 00 00 00 00 00 c8, and holds 1c 00 00 00 00 00 00
        "#);
    }
}
