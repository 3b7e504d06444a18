//! What nine bytes say to the one who asked.

use tmcl_tables::Status;
use tmcl_wire::serial::{DATAGRAM_LENGTH, DatagramError, checksum, decode_reply};
use tmcl_wire::{Reply, Request};

use crate::Heard;
use crate::finder::Verdict;

/// The module's answer to a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Answer<T> {
    /// Done, or stored.
    Done(T),
    /// Refused.
    Refused(Status),
    /// A status that the tables do not have.
    Unknown(u8),
}

/// Who asked whom for what.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Question {
    /// The address that replies are sent to.
    pub host: u8,
    /// The module that is asked.
    pub module: u8,
    /// What it is asked.
    pub request: Request,
}

/// The motor/bank byte of an instruction is below this, on every module that the tables know …
const MOTORS_AND_BANKS: u8 = 4;

/// … or says that a coordinate is copied from or to the EEPROM.
const EEPROM: u8 = 255;

type Datagram = [u8; DATAGRAM_LENGTH];

impl Question {
    /// The normal form of a reply (TMCM-1311 §4.2).
    pub(crate) fn reply(self, bytes: Datagram) -> Verdict<Answer<Reply>> {
        let [host, module, _, command, ..] = bytes;
        let decoded = match decode_reply(bytes) {
            Err(DatagramError::Checksum { .. }) => return Verdict::Noise,
            Err(DatagramError::Status(status)) => Answer::Unknown(status),
            Ok((_, _, reply)) => answer(reply),
        };
        if (host, module) != (self.host, self.module) {
            return Verdict::Foreign(Heard::Other { host, module });
        }
        match decoded {
            // It was spoiled on its way, and the module does not know what it was.
            Answer::Refused(Status::WrongChecksum) if command == 0 => Verdict::Ours(decoded),
            // The second reply to command 138 comes when it comes, and answers nothing.
            Answer::Refused(Status::Delayed) => Verdict::Foreign(Heard::OtherCommand(command)),
            _ if command == self.request.command => Verdict::Ours(decoded),
            _ => Verdict::Foreign(Heard::OtherCommand(command)),
        }
    }

    /// The same, where a complaint about a wrong checksum is no answer: it may be about any of the requests before.
    pub(crate) fn reply_to_probe(self, bytes: Datagram) -> Verdict<Answer<Reply>> {
        match self.reply(bytes) {
            Verdict::Ours(Answer::Refused(Status::WrongChecksum)) => Verdict::Foreign(Heard::OtherCommand(0)),
            verdict => verdict,
        }
    }

    /// The reply to command 134: host address, the instruction, the sum of those eight bytes (decision).
    ///
    /// Nothing in it says that it is none of the normal form, in which the module refuses and late replies come. Those are
    /// known by what they would be as an instruction: the motor would be the number of a command.
    pub(crate) fn instruction(self, bytes: Datagram) -> Verdict<Answer<[u8; 7]>> {
        let [host, instruction @ .., sum] = bytes;
        let [module, _, motor, value @ ..] = instruction;
        if sum != checksum(&bytes[..DATAGRAM_LENGTH - 1]) {
            return Verdict::Noise;
        }
        if host != self.host {
            return Verdict::Foreign(Heard::Other { host, module });
        }
        match self.reply(bytes) {
            Verdict::Ours(Answer::Refused(status)) if value == [0; 4] => {
                Verdict::Ours(Answer::Refused(status))
            }
            _ if motor >= MOTORS_AND_BANKS && motor != EEPROM && decode_reply(bytes).is_ok() => {
                Verdict::Foreign(Heard::OtherCommand(motor))
            }
            _ => Verdict::Ours(Answer::Done(instruction)),
        }
    }

    /// The reply to command 136, type 0: host address and eight characters, no checksum (TMCM-1311 §5.7.39).
    pub(crate) fn version_string(self, bytes: Datagram) -> Verdict<Answer<[u8; 8]>> {
        let [host, characters @ ..] = bytes;
        if host == self.host && characters.iter().all(u8::is_ascii_alphanumeric) {
            return Verdict::Ours(Answer::Done(characters));
        }
        match self.reply(bytes) {
            Verdict::Ours(Answer::Refused(status)) => Verdict::Ours(Answer::Refused(status)),
            Verdict::Ours(Answer::Unknown(status)) => Verdict::Ours(Answer::Unknown(status)),
            Verdict::Ours(Answer::Done(reply)) => Verdict::Foreign(Heard::OtherCommand(reply.command)),
            Verdict::Foreign(heard) => Verdict::Foreign(heard),
            Verdict::Noise => Verdict::Noise,
        }
    }
}

fn answer(reply: Reply) -> Answer<Reply> {
    match reply.status {
        Status::Ok | Status::Loaded => Answer::Done(reply),
        status => Answer::Refused(status),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use tmcl_tables::{Command, MODULES};
    use tmcl_wire::serial::{encode_reply, encode_version_string};

    use super::*;

    fn question(command: Command) -> Question {
        Question { host: 2, module: 1, request: Request::new(command, 0, 0, 0) }
    }

    fn reply(status: Status, command: u8, value: i32) -> Datagram {
        encode_reply(2, 1, Reply { status, command, value })
    }

    fn memory(instruction: [u8; 7]) -> Datagram {
        let [a, b, c, d, e, f, g] = instruction;
        [2, a, b, c, d, e, f, g, checksum(&[2, a, b, c, d, e, f, g])]
    }

    #[test]
    fn a_reply_is_for_us_from_the_module_to_the_command() {
        let get = question(Command::GetAxisParameter);
        let expected = Reply { status: Status::Ok, command: 6, value: -5 };
        assert_eq!(get.reply(encode_reply(2, 1, expected)), Verdict::Ours(Answer::Done(expected)));
        let other = Heard::Other { host: 3, module: 1 };
        assert_eq!(get.reply(encode_reply(3, 1, expected)), Verdict::Foreign(other));
        let other = Heard::Other { host: 2, module: 4 };
        assert_eq!(get.reply(encode_reply(2, 4, expected)), Verdict::Foreign(other));
        assert_eq!(get.reply(reply(Status::Ok, 5, 0)), Verdict::Foreign(Heard::OtherCommand(5)));
        let spoiled = Verdict::Ours(Answer::Refused(Status::WrongChecksum));
        assert_eq!(get.reply(reply(Status::WrongChecksum, 0, 0)), spoiled);
    }

    #[test]
    fn a_status_of_tomorrow_is_no_noise() {
        let mut bytes = reply(Status::Ok, 6, 0);
        bytes[2] = 77;
        bytes[8] = checksum(&bytes[..8]);
        assert_eq!(question(Command::GetAxisParameter).reply(bytes), Verdict::Ours(Answer::Unknown(77)));
        assert_eq!(
            question(Command::SetAxisParameter).reply(bytes),
            Verdict::Foreign(Heard::OtherCommand(6))
        );
    }

    #[test]
    fn events_answer_nothing() {
        let event = reply(Status::Delayed, 138, 1);
        let foreign = Heard::OtherCommand(138);
        let read = question(Command::ReadProgramMemory);
        assert_eq!(question(Command::RequestPositionReachedEvent).reply(event), Verdict::Foreign(foreign));
        assert_eq!(read.instruction(event), Verdict::Foreign(foreign));
        let late = reply(Status::Ok, 6, 77);
        assert_eq!(read.instruction(late), Verdict::Foreign(Heard::OtherCommand(6)));
    }

    #[test]
    fn instructions_and_refusals_are_told_apart() {
        let read = question(Command::ReadProgramMemory);
        for status in [Status::InvalidCommand, Status::InvalidValue, Status::NotAvailable] {
            assert_eq!(read.instruction(reply(status, 134, 0)), Verdict::Ours(Answer::Refused(status)));
        }
        let spoiled = reply(Status::WrongChecksum, 0, 0);
        assert_eq!(read.instruction(spoiled), Verdict::Ours(Answer::Refused(Status::WrongChecksum)));
        // ROR at 134, SAP 1, and one with a status where its type is.
        for instruction in [[1, 0, 0, 0, 0, 0, 134], [5, 1, 0, 0, 0, 0, 1], [1, 4, 2, 0, 0, 0, 134]] {
            assert_eq!(read.instruction(memory(instruction)), Verdict::Ours(Answer::Done(instruction)));
        }
        let mut bytes = memory([5, 1, 0, 0, 0, 0, 1]);
        bytes[3] ^= 1;
        assert_eq!(read.instruction(bytes), Verdict::Noise);
        bytes = encode_reply(9, 1, Reply { status: Status::Ok, command: 6, value: 0 });
        assert_eq!(read.instruction(bytes), Verdict::Foreign(Heard::Other { host: 9, module: 1 }));
    }

    #[test]
    fn a_version_string_is_known_by_its_characters() {
        let version = question(Command::FirmwareVersion);
        let bytes = encode_version_string(2, *b"1311V111");
        assert_eq!(version.version_string(bytes), Verdict::Ours(Answer::Done(*b"1311V111")));
        assert_eq!(version.version_string(encode_version_string(3, *b"1311V111")), Verdict::Noise);
        let refused = reply(Status::InvalidCommand, 136, 0);
        assert_eq!(version.version_string(refused), Verdict::Ours(Answer::Refused(Status::InvalidCommand)));
    }

    #[test]
    fn the_tables_have_no_more_motors_and_banks() {
        for spec in MODULES {
            let banks = spec.global_parameters.iter().map(|global| global.bank);
            assert!(banks.chain(spec.ports.iter().map(|port| port.bank)).all(|bank| bank < MOTORS_AND_BANKS));
        }
    }

    proptest! {
        /// All instructions that a program may hold are read as they are.
        #[test]
        fn no_instruction_is_taken_for_a_refusal(mut instruction: [u8; 7]) {
            instruction[2] %= MOTORS_AND_BANKS;
            prop_assume!(instruction != [1, 1, 0, 0, 0, 0, 0]); // as `Client::read_program_instruction` says
            let verdict = question(Command::ReadProgramMemory).instruction(memory(instruction));
            prop_assert_eq!(verdict, Verdict::Ours(Answer::Done(instruction)));
        }

        #[test]
        fn any_bytes_are_judged(bytes: Datagram) {
            let question = question(Command::ReadProgramMemory);
            let _ = (question.reply(bytes), question.instruction(bytes), question.version_string(bytes));
        }
    }
}
