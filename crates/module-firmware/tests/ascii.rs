//! The ASCII interface at the ports of a module (TMCM-1311 §4.4).

mod common;

use common::{Memory, Node, RS485, USB, answer, datagram};
use module_firmware::PortId;
use module_firmware::tmcm_1311::Tmcm1311;
use module_firmware::tmcm_1640::Tmcm1640;
use proptest::prelude::*;
use tmcl_tables::{Command, Status};
use tmcl_wire::{Reply, Request, serial};

const SGP: Command = Command::SetGlobalParameter;
const GAP: Command = Command::GetAxisParameter;
const ENTER: Command = Command::EnterAsciiMode;

const ECHO_LINE: i32 = 0x10;
const NO_ECHO: i32 = 0x20;

/// A module with a port in ASCII mode.
fn node(echo: i32) -> Node<Tmcm1311> {
    let mut node = Node::new();
    node.sgp(67, echo);
    node.sgp(88, 0);
    assert_eq!(node.exchange(RS485, &datagram(1, ENTER, 0, 0, 0)), answer(1, ENTER, 0));
    node
}

/// What a line leads to, as text.
#[track_caller]
fn say(node: &mut Node<Tmcm1311>, line: &str) -> String {
    let heard = node.exchange(RS485, format!("{line}\r").as_bytes());
    String::from_utf8(heard).expect("ASCII")
}

/// What was typed and what was heard, ends of lines and all.
fn transcript(node: &mut Node<Tmcm1311>, typed: &[&str]) -> String {
    let mut transcript = String::new();
    for text in typed {
        transcript += &format!("> {}\n", text.as_bytes().escape_ascii());
        let heard = node.exchange(RS485, text.as_bytes());
        for said in heard.split_inclusive(|byte| *byte == b'\r') {
            transcript += &format!("< {}\n", said.escape_ascii());
        }
    }
    transcript
}

/// The manual's lines, and what people do to a line.
const SESSION: [&str; 25] = [
    // §4.4.1: there is no motor 1 or 2.
    "AMVP ABS, 1, 50000\r",
    "A MVP ABS, 1, 50000\r",
    "AROL 2, 500\r",
    "A MST 1\r",
    // §4.4.2, with motor 0 and the parameter that it means.
    "ASAP 1, 0, -5000\r",
    "AGAP 1, 0\r",
    "a  mvp  rel,0 , +200\r",
    "AGAP 0, 0\r\n",
    // Erasing, with either key; more than there is.
    "AGAP 4\x085 5\x08, 1\x7f0\r",
    "AMTS\x08\x7fST 0\r",
    "\x7fB\x7f\x7fAMST 0\r",
    // Others' lines.
    "BMST 0\r",
    "CMVP ABS, 0, 1000\r",
    // What is no command, and wrong operands.
    "A\r",
    "AVERSION\r",
    "AGAP 21, 0\r",
    "AMVP UP, 0, 1000\r",
    "ASAP 4, 0, 400000000\r",
    "AJA 0\r",
    "\r",
    // Too long a line.
    "AMST 00000000000000000000000000000000000000000000000000000000000000000000000000000000\r",
    // The program: a STOP at address 5.
    "ARUN 5\r",
    "ASTOP\r",
    // From here on a line is noise.
    "ABIN\r",
    "AGAP 1, 0\r",
];

#[test]
fn a_session_with_an_echo_of_each_character() {
    insta::assert_snapshot!(transcript(&mut node(0), &SESSION));
}

#[test]
fn a_session_with_an_echo_of_each_line() {
    insta::assert_snapshot!(transcript(&mut node(ECHO_LINE), &SESSION));
}

#[test]
fn a_session_without_echo() {
    insta::assert_snapshot!(transcript(&mut node(NO_ECHO), &SESSION));
}

/// Every command of §4.4.3, and those of direct mode that it does not list.
#[test]
fn every_command_does_what_its_datagram_does() {
    let lines = [
        ("ROL 0, 500", Command::RotateLeft, 0, 0, 500),
        ("ROR 0, 500", Command::RotateRight, 0, 0, 500),
        ("MST 0", Command::MotorStop, 0, 0, 0),
        ("MVP ABS, 0, 9000", Command::MoveToPosition, 0, 0, 9000),
        ("MVP REL, 0, -100", Command::MoveToPosition, 1, 0, -100),
        ("SCO 8, 0, 77", Command::SetCoordinate, 8, 0, 77),
        ("MVP COORD, 0, 8", Command::MoveToPosition, 2, 0, 8),
        ("SAP 6, 0, 200", SGP, 0, 0, 0),
        ("GAP 6, 0", GAP, 6, 0, 0),
        ("STAP 6, 0", Command::StoreAxisParameter, 6, 0, 0),
        ("RSAP 6, 0", Command::RestoreAxisParameter, 6, 0, 0),
        ("SGP 3, 2, -7", SGP, 3, 2, -7),
        ("GGP 3, 2", Command::GetGlobalParameter, 3, 2, 0),
        ("STGP 3, 2", Command::StoreGlobalParameter, 3, 2, 0),
        ("RSGP 3, 2", Command::RestoreGlobalParameter, 3, 2, 0),
        ("RFS START, 0", Command::ReferenceSearch, 0, 0, 0),
        ("RFS STATUS, 0", Command::ReferenceSearch, 2, 0, 0),
        ("RFS STOP, 0", Command::ReferenceSearch, 1, 0, 0),
        ("SIO 3, 2, 1", Command::SetOutput, 3, 2, 1),
        ("GIO 3, 2", Command::GetInput, 3, 2, 0),
        ("GCO 8, 0", Command::GetCoordinate, 8, 0, 0),
        ("SCO 8, 255, 0", Command::SetCoordinate, 8, 255, 0),
        ("CCO 9, 0", Command::CaptureCoordinate, 9, 0, 0),
        ("CALC LOAD, 21", Command::Calculate, 9, 0, 21),
        ("CALC MUL, 2", Command::Calculate, 2, 0, 2),
        ("CALCX LOAD", Command::CalculateX, 9, 0, 0),
        ("ACO 10, 0", Command::AccumulatorToCoordinate, 10, 0, 0),
        ("AAP 4, 0", Command::AccumulatorToAxisParameter, 4, 0, 0),
        ("AGP 4, 2", Command::AccumulatorToGlobalParameter, 4, 2, 0),
        ("UF0 1, 2, 3", Command::UserFunction0, 1, 2, 3),
        ("RUN 4", Command::ApplicationRun, 1, 0, 4),
        ("STOP", Command::ApplicationStop, 0, 0, 0),
    ];
    let mut typed = node(NO_ECHO);
    let mut sent = typed.clone();
    for (text, command, kind, motor, value) in lines {
        let request = match text {
            "SAP 6, 0, 200" => Request::new(Command::SetAxisParameter, 6, 0, 200),
            _ => Request::new(command, kind, motor, value),
        };
        let Reply { status, value, .. } = sent.ask(1, request);
        assert_eq!(
            say(&mut typed, &format!("A{text}")),
            format!("BA {} {value}\r", status.number()),
            "{text}"
        );
        assert_eq!(format!("{:?}", typed.firmware.axis()), format!("{:?}", sent.firmware.axis()), "{text}");
        assert_eq!(typed.storage.records, sent.storage.records, "{text}");
        typed.run(20);
        sent.run(20);
    }
    assert_eq!(typed.ok(Command::GetCoordinate, 10, 0, 0), 42);
}

mod modes {
    use super::*;

    /// Decisions 2a.16: the value of a setting command is what was sent.
    #[test]
    fn each_port_has_its_own_mode_and_the_way_in_and_out_is_answered_in_the_old_one() {
        let mut node = Node::<Tmcm1311>::new();
        assert_eq!(node.exchange(USB, &datagram(1, ENTER, 1, 2, 3)), answer(1, ENTER, 3));
        assert_eq!(node.exchange(PortId::ALL[3], &datagram(1, GAP, 4, 0, 0)), answer(1, GAP, 51_200));
        assert_eq!(node.exchange(USB, b"agap 4, 0\r"), b"agap 4, 0\rBA 100 51200\r");
        assert_eq!(node.exchange(USB, b"ABIN\r"), b"ABIN\rBA 100 0\r");
        assert_eq!(node.exchange(USB, &datagram(1, GAP, 4, 0, 0)), answer(1, GAP, 51_200));
    }

    #[test]
    fn a_line_may_take_its_time() {
        let mut node = node(NO_ECHO);
        assert_eq!(node.exchange(RS485, b"AGAP 4"), b"");
        node.run_ms(1000);
        assert_eq!(node.exchange(RS485, b", 0\r"), b"BA 100 51200\r");
    }

    /// GP 67 bit 0: from power-on on, and until then nothing changes.
    #[test]
    fn a_module_starts_up_in_ascii_where_it_is_set() {
        let mut node = Node::<Tmcm1311>::new();
        node.sgp(88, 0);
        node.sgp(67, NO_ECHO + 1);
        assert_eq!(node.exchange(USB, &datagram(1, GAP, 4, 0, 0)), answer(1, GAP, 51_200));
        node.power_cycle();
        for port in [USB, RS485, PortId::ALL[3]] {
            assert_eq!(node.exchange(port, b"AGAP 4, 0\r"), b"BA 100 51200\r");
        }
        assert_eq!(node.exchange_frame(1, &[6, 4, 0, 0, 0, 0, 0]), [], "CAN has no ASCII, and is deaf here");
        assert_eq!(node.exchange(USB, b"ABIN\r"), b"BA 100 0\r");
        assert_eq!(node.ok(Command::SoftwareReset, 0, 0, 1234), 1234);
        assert_eq!(node.exchange(USB, b"AGAP 4, 0\r"), b"BA 100 51200\r", "so it does after 255");
    }

    #[test]
    fn a_client_that_comes_finds_the_mode_of_the_start() {
        let mut node = Node::<Tmcm1311>::new();
        node.sgp(67, 1);
        node.exchange(USB, &datagram(1, ENTER, 0, 0, 0));
        node.exchange(USB, b"AGAP");
        node.firmware.disconnect(USB);
        assert_eq!(node.ok(GAP, 4, 0, 0), 51_200);
        node.power_cycle();
        node.exchange(USB, b"ABIN\r");
        node.firmware.disconnect(USB);
        assert_eq!(node.exchange(USB, b"AGAP 4, 0\r"), b"AGAP 4, 0\rBA 100 51200\r");
    }

    /// What has no letter cannot be spoken to (decision): 139 is not available, and a new address ends the mode.
    #[test]
    fn without_a_letter_there_is_no_ascii() {
        for address in [0, 27, 255_u8] {
            let mut node = node(NO_ECHO + 1);
            assert_eq!(say(&mut node, &format!("ASGP 66, 0, {address}")), format!("BA 100 {address}\r"));
            let refusal = Reply { status: Status::NotAvailable, command: ENTER.number(), value: 0 };
            let refused = serial::encode_reply(2, address, refusal);
            assert_eq!(node.exchange(RS485, &datagram(address, ENTER, 0, 0, 5)), refused);
            node.power_cycle();
            assert_eq!(node.exchange(RS485, &datagram(address, GAP, 4, 0, 0)), answer(address, GAP, 51_200));
        }
    }

    #[test]
    fn the_tmcm_1640_has_none() {
        let mut node = Node::<Tmcm1640>::new();
        assert_eq!(node.ask(1, Request::new(ENTER, 0, 0, 0)).status, Status::InvalidCommand);
        assert_eq!(node.ask(1, Request::new(SGP, 67, 0, 1)).status, Status::WrongType);
    }

    /// Bits 4 and 5 together are not accepted.
    #[test]
    fn there_are_three_echoes() {
        let mut node = Node::<Tmcm1311>::new();
        for value in [0x30, 0x31, 2, 64, -1] {
            assert_eq!(node.ask(1, Request::new(SGP, 67, 0, value)).status, Status::InvalidValue);
        }
    }
}

mod addresses {
    use super::*;

    #[test]
    fn letters_follow_the_addresses_after_the_reply() {
        let mut node = node(NO_ECHO);
        assert_eq!(say(&mut node, "ASGP 66, 0, 26"), "BA 100 26\r");
        assert_eq!(say(&mut node, "AGAP 4, 0"), "");
        assert_eq!(say(&mut node, "ZSGP 76, 0, 26"), "BZ 100 26\r");
        assert_eq!(say(&mut node, "zSGP 76, 0, 27"), "ZZ 100 27\r");
        assert_eq!(say(&mut node, "ZGAP 4, 0"), "?Z 100 51200\r", "a host without a letter");
    }

    #[test]
    fn the_secondary_letter_is_obeyed_in_silence() {
        for echo in [0, ECHO_LINE, NO_ECHO] {
            let mut node = node(echo);
            node.sgp(87, 7);
            assert_eq!(say(&mut node, "GSGP 3, 2, 5"), "");
            assert_eq!(node.ok(Command::GetGlobalParameter, 3, 2, 0), 5);
            assert_eq!(say(&mut node, "G nonsense"), "");
            assert_eq!(say(&mut node, "GBIN"), "");
            assert_eq!(node.exchange(RS485, &datagram(1, GAP, 4, 0, 0)), answer(1, GAP, 51_200));
        }
    }

    /// Not even an echo is sent; SGP 255 itself is answered.
    #[test]
    fn suppression_is_as_in_binary() {
        let mut node = node(ECHO_LINE);
        assert_eq!(say(&mut node, "ASGP 255, 0, 1"), "ASGP 255, 0, 1\rBA 100 1\r");
        assert_eq!(say(&mut node, "ASGP 3, 2, 5"), "");
        assert_eq!(say(&mut node, "Anonsense"), "");
        assert_eq!(say(&mut node, "ASGP 255, 0, 0"), "BA 100 0\r");
        assert_eq!(say(&mut node, "AGGP 3, 2"), "AGGP 3, 2\rBA 100 5\r");
    }
}

/// GP 75 holds back what begins to be said, an echo too.
#[test]
fn the_pause_is_as_in_binary() {
    let mut node = node(ECHO_LINE);
    node.sgp(75, 15);
    assert_eq!(say(&mut node, "AGAP 4, 0"), "");
    node.run(299);
    assert_eq!(node.heard(RS485), b"");
    node.run(1);
    assert_eq!(node.heard(RS485), b"AGAP 4, 0\rBA 100 51200\r");
}

/// GP 68: a line for this module counts, one for another does not.
#[test]
fn a_line_keeps_the_heartbeat_going() {
    for (line, goes_on) in [("AGAP 4, 0", true), ("A", true), ("BGAP 4, 0", false)] {
        let mut node = node(NO_ECHO);
        node.ok(Command::RotateRight, 0, 0, 1000);
        node.sgp(68, 100);
        node.run_ms(99);
        say(&mut node, line);
        node.run_ms(99);
        assert_eq!(node.gap(2) == 1000, goes_on, "{line}");
    }
}

/// A request of 138 from before is answered the way the port speaks by then.
#[test]
fn the_position_is_reported_in_ascii() {
    let mut node = Node::<Tmcm1311>::new();
    node.ok(Command::MoveToPosition, 0, 0, 50);
    node.ok(Command::RequestPositionReachedEvent, 0, 0, 0);
    node.ok(ENTER, 0, 0, 0);
    node.run_ms(1000);
    assert_eq!(node.heard(USB), b"BA 128 1\r");
}

/// A download goes on over lines: what is sent is stored, RUN and STOP are not.
#[test]
fn a_download_stores_lines_too() {
    let mut node = node(NO_ECHO);
    node.exchange(RS485, b"ABIN\r");
    node.exchange(RS485, &datagram(1, Command::DownloadStart, 0, 0, 0));
    node.exchange(RS485, &datagram(1, ENTER, 0, 0, 0));
    assert_eq!(say(&mut node, "ACALC LOAD, 42"), "BA 101 42\r");
    assert_eq!(say(&mut node, "ABIN"), "BA 100 0\r");
    node.exchange(RS485, &datagram(1, Command::DownloadEnd, 0, 0, 0));
    node.exchange(RS485, &datagram(1, ENTER, 0, 0, 0));
    assert_eq!(say(&mut node, "ARUN 0"), "BA 100 0\r");
    node.run(1);
    assert_eq!(node.firmware.program().registers.accumulator, 42);
}

/// A storage that fails is told of in ASCII as well.
#[test]
fn what_cannot_be_stored_is_not_available() {
    let mut node = Node::<Tmcm1311>::with(Memory::default());
    node.ok(ENTER, 0, 0, 0);
    node.storage.writing_fails = true;
    assert_eq!(node.exchange(USB, b"ASTAP 4, 0\r"), b"ASTAP 4, 0\rBA 6 0\r");
}

/// Who does not read is waited for, and nothing is lost of what found room.
#[test]
fn unread_echoes_and_replies_wait() {
    for (echo, expected) in
        [(0, "AMST 0\rBA 100 0\r"), (ECHO_LINE, "AMST 0\rBA 100 0\r"), (NO_ECHO, "BA 100 0\r")]
    {
        let mut node = node(echo);
        let mut typed = b"AMST 0\r".iter().cycle();
        let mut taken = 0;
        while let Some(byte) = typed.next()
            && node.firmware.receive(RS485, *byte)
        {
            taken += 1;
            assert!(taken < 1000);
        }
        let heard = String::from_utf8(node.heard(RS485)).expect("ASCII");
        let (lines, rest) = (taken / 7, taken % 7);
        let begun = if echo == 0 { &"AMST 0\r"[..rest] } else { "" };
        assert_eq!(heard, expected.repeat(lines) + begun);
        assert!(lines >= 10);
    }
}

/// The lines for this module in what was typed, by the shortest model of them.
fn lines_for_a(typed: &[u8]) -> usize {
    let (mut line, mut lines) = (Vec::new(), 0);
    for byte in typed {
        match byte {
            8 | 0x7F => drop(line.pop()),
            b'\r' | b'\n' => {
                lines +=
                    usize::from(line.first().is_some_and(|first: &u8| first.eq_ignore_ascii_case(&b'A')));
                line.clear();
            }
            b' ' if line.is_empty() => {}
            _ => line.push(*byte),
        }
    }
    lines
}

proptest! {
    /// Every line for this module gets one whole reply, whatever is typed, and nothing else gets any.
    #[test]
    fn every_line_gets_one_reply(
        // No way to BIN, SGP or a long line.
        typed in prop::collection::vec(prop::sample::select(b"AaBGgITMPO0123-, \r\n\x08\x7f\xFF".to_vec()), 0..76),
    ) {
        let mut node = node(NO_ECHO);
        let heard = String::from_utf8(node.exchange(RS485, &typed)).expect("ASCII");
        let replies: Vec<_> = heard.split_terminator('\r').collect();
        prop_assert!(heard.is_empty() || heard.ends_with('\r'));
        prop_assert_eq!(replies.len(), lines_for_a(&typed), "{:?}", heard);
        for reply in replies {
            let mut fields = reply.split(' ');
            prop_assert_eq!(fields.next(), Some("BA"));
            prop_assert!(matches!(fields.next(), Some("100" | "2" | "3" | "4" | "6")), "{}", reply);
            prop_assert!(fields.next().is_some_and(|value| value.parse::<i32>().is_ok()), "{}", reply);
            prop_assert_eq!(fields.next(), None);
        }
    }
}
