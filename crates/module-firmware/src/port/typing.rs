//! A port in ASCII mode: characters become lines, and are echoed (TMCM-1311 §4.4).

use tmcl_tables::{ModuleSpec, Status};
use tmcl_wire::ascii::{self, CommandLine, Echo, Input, LINE_LENGTH, Typed};

use super::{OUTBOX, Port};

/// Whom a port in ASCII mode listens for, and what it echoes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ear {
    pub(crate) address: u8,
    /// 0 for none.
    pub(crate) secondary_address: u8,
    pub(crate) echo: Echo,
    /// The tick at which an echo may leave.
    pub(crate) ready_at: u64,
}

/// What an erased character looks like on a terminal.
const ERASED: &[u8] = b"\x08 \x08";

/// Room that the end of a line needs: for its echo, a reply and an event.
const ROOM_FOR_LINE: usize = LINE_LENGTH + 1 + 2 * ascii::REPLY_LENGTH;

const _: () = assert!(ROOM_FOR_LINE <= OUTBOX);

impl Port {
    /// Whether it takes lines instead of datagrams.
    pub(crate) fn is_ascii(&self) -> bool {
        self.typed.is_some()
    }

    /// From the next byte on it takes lines, or datagrams.
    pub(crate) fn set_ascii(&mut self, ascii: bool) {
        self.typed = ascii.then(CommandLine::new);
        self.decoder.reset();
    }

    /// The address of the next line for this module in the characters that wait, which are echoed. None while an echo, a
    /// reply and an event would not fit the outbox.
    pub(crate) fn next_line(&mut self, ear: &Ear) -> Option<u8> {
        loop {
            let byte = self.inbox.peek()?;
            if self.outbox.room() < room_for_echo(byte) {
                return None;
            }
            self.inbox.pop();
            let line = self.typed.as_mut()?;
            let was_ours = line.is_for(ear.address);
            let typed = line.push(byte);
            let (ours, group) = (line.is_for(ear.address), line.is_for(ear.secondary_address));
            if was_ours || ours {
                self.echo(ear, typed, byte);
            }
            match typed {
                Typed::Ended if ours => return Some(ear.address),
                Typed::Ended if group => return Some(ear.secondary_address),
                Typed::Ended => self.forget_line(),
                Typed::Kept | Typed::Erased | Typed::Nothing => {}
            }
        }
    }

    /// What the line that ended asks for, by the tables of the module.
    pub(crate) fn take_line(&mut self, module: &ModuleSpec) -> Result<Input, Status> {
        let input = self.typed.as_ref().map(|line| line.input(module));
        self.forget_line();
        input.unwrap_or(Err(Status::InvalidCommand))
    }

    /// Echoes a character of a line for this module, or the line that it ended (TMCM-1311 §4.4.4). CR stands for every end.
    fn echo(&mut self, ear: &Ear, typed: Typed, byte: u8) {
        match (ear.echo, typed) {
            (Echo::Characters, Typed::Kept) => self.say(ear.ready_at, &[byte]),
            (Echo::Characters, Typed::Erased) => self.say(ear.ready_at, ERASED),
            (Echo::Line, Typed::Ended) => {
                let line = self.typed.clone().unwrap_or_default();
                self.say(ear.ready_at, line.text()) && self.say(ear.ready_at, &[ascii::END])
            }
            (Echo::Characters, Typed::Ended) => self.say(ear.ready_at, &[ascii::END]),
            (Echo::Line | Echo::Characters | Echo::Off, _) => true,
        };
    }

    /// Forgets what was typed of a line.
    pub(super) fn forget_line(&mut self) {
        if let Some(line) = &mut self.typed {
            line.clear();
        }
    }
}

/// Room that the outbox needs for what a character may lead to.
fn room_for_echo(byte: u8) -> usize {
    match byte {
        b'\r' | b'\n' => ROOM_FOR_LINE,
        _ => ERASED.len(),
    }
}
