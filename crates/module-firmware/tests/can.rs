//! CAN: frames of seven and eight bytes (TMCM-1311 §4.1, §4.2, §10.1).

mod common;

use common::{CAN, Node, USB, datagram};
use module_firmware::tmcm_1311::Tmcm1311;
use proptest::prelude::*;
use tmcl_tables::{Command, Status};
use tmcl_wire::serial::checksum;
use tmcl_wire::{Reply, Request, can};

fn request(command: Command, kind: u8, motor: u8, value: i32) -> [u8; 7] {
    Request::new(command, kind, motor, value).to_bytes()
}

/// The same with the sum of the seven bytes.
fn long(bytes: [u8; 7]) -> [u8; 8] {
    let [a, b, c, d, e, f, g] = bytes;
    [a, b, c, d, e, f, g, checksum(&bytes)]
}

const GAP_4: [u8; 7] = [6, 4, 0, 0, 0, 0, 0];
/// 51 200.
const REPLY: [u8; 7] = [1, 100, 6, 0, 0, 0xC8, 0];

#[test]
fn a_reply_has_the_length_of_its_request() {
    let mut node = Node::<Tmcm1311>::new();
    assert_eq!(node.exchange_frame(1, &GAP_4), [(2, REPLY.to_vec())]);
    assert_eq!(node.exchange_frame(1, &long(GAP_4)), [(2, long(REPLY).to_vec())]);
    let mut spoiled = long(GAP_4);
    spoiled[7] ^= 0xFF;
    assert_eq!(node.exchange_frame(1, &spoiled), [(2, long(REPLY).to_vec())], "CAN has a sum of its own");
}

#[test]
fn other_lengths_and_identifiers_are_none_of_its_business() {
    let mut node = Node::<Tmcm1311>::new();
    for length in 0..7 {
        assert_eq!(node.exchange_frame(1, &GAP_4[..length]), []);
    }
    for id in [0, 2, 3, 0x101, 0x7FF] {
        assert_eq!(node.exchange_frame(id, &request(Command::SetGlobalParameter, 0, 2, 5)), []);
    }
    assert_eq!(node.ok(Command::GetGlobalParameter, 0, 2, 0), 0);
}

/// GP 70, 71 (decisions 2a.11): the reply still goes by the old ones. What it begins with is the low byte of the module's.
#[test]
fn new_identifiers_count_after_the_reply() {
    let mut node = Node::<Tmcm1311>::new();
    let sgp = |number, value| request(Command::SetGlobalParameter, number, 0, value);
    assert_eq!(node.exchange_frame(1, &sgp(71, 0x234)), [(2, vec![1, 100, 9, 0, 0, 2, 0x34])]);
    assert_eq!(node.exchange_frame(1, &GAP_4), []);
    assert_eq!(node.exchange_frame(0x234, &sgp(70, 0x7FF)), [(2, vec![0x34, 100, 9, 0, 0, 7, 0xFF])]);
    assert_eq!(node.exchange_frame(0x234, &GAP_4), [(0x7FF, vec![0x34, 100, 6, 0, 0, 0xC8, 0])]);
    node.power_cycle();
    assert_eq!(node.exchange_frame(0x234, &GAP_4), [(0x7FF, vec![0x34, 100, 6, 0, 0, 0xC8, 0])], "stored");
}

/// GP 83 is that of a group, as GP 87 is (decision).
#[test]
fn the_secondary_identifier_is_obeyed_in_silence() {
    let mut node = Node::<Tmcm1311>::new();
    assert_eq!(node.exchange_frame(0, &request(Command::SetGlobalParameter, 0, 2, 5)), [], "0 is none");
    node.sgp(83, 0x300);
    assert_eq!(node.exchange_frame(0x300, &request(Command::SetGlobalParameter, 1, 2, 7)), []);
    assert_eq!(node.ok(Command::GetGlobalParameter, 0, 2, 0), 0);
    assert_eq!(node.ok(Command::GetGlobalParameter, 1, 2, 0), 7);
    assert_eq!(node.exchange_frame(1, &GAP_4).len(), 1);
}

#[test]
fn suppressed_replies_are_not_sent() {
    let mut node = Node::<Tmcm1311>::new();
    let suppress = |value| request(Command::SetGlobalParameter, 255, 0, value);
    assert_eq!(node.exchange_frame(1, &suppress(1)).len(), 1);
    assert_eq!(node.exchange_frame(1, &GAP_4), []);
    assert_eq!(node.exchange_frame(1, &suppress(0)).len(), 1);
    assert_eq!(node.exchange_frame(1, &GAP_4).len(), 1);
}

#[test]
fn the_version_is_eight_characters_and_an_instruction_seven_bytes() {
    let mut node = Node::<Tmcm1311>::new();
    let version = request(Command::FirmwareVersion, 0, 0, 0);
    assert_eq!(node.exchange_frame(1, &version), [(2, b"1311V111".to_vec())]);
    assert_eq!(node.exchange_frame(1, &long(version)), [(2, b"1311V111".to_vec())]);
    let read = request(Command::ReadProgramMemory, 0, 0, 0);
    let stop = [28, 0, 0, 0, 0, 0, 0];
    assert_eq!(node.exchange_frame(1, &read), [(2, stop.to_vec())]);
    assert_eq!(node.exchange_frame(1, &long(read)), [(2, long(stop).to_vec())]);
}

#[test]
fn the_position_is_reported_with_a_second_frame_as_long_as_the_first() {
    let mut node = Node::<Tmcm1311>::new();
    let event = request(Command::RequestPositionReachedEvent, 0, 0, 0);
    for event in [event.to_vec(), long(event).to_vec()] {
        assert_eq!(node.exchange_frame(1, &request(Command::MoveToPosition, 1, 0, 50)).len(), 1);
        let first = node.exchange_frame(1, &event);
        assert_eq!(first.len(), 1);
        assert_eq!((first[0].0, &first[0].1[..7]), (2, &[1, 100, 138, 0, 0, 0, 1][..]));
        node.run_ms(1000);
        let second = node.frames();
        assert_eq!((second[0].0, &second[0].1[..7]), (2, &[1, 128, 138, 0, 0, 0, 1][..]));
        assert_eq!((second.len(), second[0].1.len()), (1, event.len()));
    }
}

#[test]
fn there_is_no_ascii_on_can() {
    let mut node = Node::<Tmcm1311>::new();
    let replies = node.exchange_frame(1, &request(Command::EnterAsciiMode, 0, 0, 0));
    assert_eq!(replies, [(2, vec![1, Status::NotAvailable.number(), 139, 0, 0, 0, 0])]);
    assert_eq!(node.exchange_frame(1, &GAP_4), [(2, REPLY.to_vec())]);
}

#[test]
fn programs_are_downloaded_as_over_any_port() {
    let mut node = Node::<Tmcm1311>::new();
    let status = |frames: Vec<(u16, Vec<u8>)>| frames[0].1[1];
    assert_eq!(status(node.exchange_frame(1, &request(Command::DownloadStart, 0, 0, 0))), 100);
    let load = request(Command::Calculate, 9, 0, 42);
    assert_eq!(status(node.exchange_frame(1, &load)), Status::Loaded.number());
    // Others go on as ever.
    assert_eq!(node.ok(Command::GetGlobalParameter, 129, 0, 0), 1);
    assert_eq!(status(node.exchange_frame(1, &request(Command::DownloadEnd, 0, 0, 0))), 100);
    assert_eq!(node.exchange_frame(1, &request(Command::ReadProgramMemory, 0, 0, 0)), [(2, load.to_vec())]);
    assert_eq!(status(node.exchange_frame(1, &request(Command::ApplicationRun, 1, 0, 0))), 100);
    node.run(1);
    assert_eq!(node.firmware.program().registers.accumulator, 42);
}

/// GP 75 has no effect on CAN (§10.1), nor has GP 68.
#[test]
fn there_is_neither_pause_nor_heartbeat() {
    let mut node = Node::<Tmcm1311>::new();
    node.sgp(75, 255);
    node.sgp(68, 10);
    node.ok(Command::RotateRight, 0, 0, 1000);
    node.run_ms(100);
    assert_eq!(node.exchange_frame(1, &GAP_4), [(2, REPLY.to_vec())]);
    assert_eq!(node.gap(2), 1000);
}

/// GP 69 and 88 (decisions 2a.11).
#[test]
fn rate_and_interface_change_after_the_reply() {
    let mut node = Node::<Tmcm1311>::new();
    assert_eq!(node.firmware.can_bit_rate(), 1_000_000);
    let sgp =
        |number, value| can::Frame::request(1, Request::new(Command::SetGlobalParameter, number, 0, value));
    assert!(node.firmware.receive_frame(CAN, &sgp(69, 5)));
    node.work();
    assert!(node.firmware.has_frame(CAN) && !node.firmware.has_output(CAN));
    assert_eq!((node.firmware.transmit(CAN), node.firmware.can_bit_rate()), (None, 1_000_000));
    assert_eq!(node.frames(), [(2, vec![1, 100, 9, 0, 0, 0, 5])]);
    assert_eq!(node.firmware.can_bit_rate(), 125_000);
    assert_eq!(node.exchange_frame(1, sgp(88, 0).data.as_slice()), [(2, vec![1, 100, 9, 0, 0, 0, 0])]);
    assert_eq!(node.exchange_frame(1, &GAP_4), []);
    assert_eq!(node.exchange(USB, &datagram(1, Command::GetGlobalParameter, 88, 0, 0)).len(), 9);
}

/// Who is not read is not listened to for ever: frames find no room, and none that did is lost.
#[test]
fn what_finds_room_is_answered() {
    let mut node = Node::<Tmcm1311>::new();
    let frame = can::Frame::new(1, &long(GAP_4)).expect("eight bytes");
    let mut taken = 0;
    while node.firmware.receive_frame(CAN, &frame) {
        taken += 1;
        assert!(taken < 100);
    }
    assert!(taken > 2);
    assert_eq!(node.frames(), vec![(2, long(REPLY).to_vec()); taken]);
    assert!(node.firmware.receive_frame(CAN, &frame));
}

proptest! {
    /// On CAN as on USB: the same request gets the same status and value.
    #[test]
    fn the_carrier_makes_no_difference(bytes in any::<[u8; 7]>()) {
        // Those with a reply of their own shape, or none.
        prop_assume!(![134, 136, 137, 138, 139, 255].contains(&bytes[0]));
        let mut usb = Node::<Tmcm1311>::new();
        let mut bus = usb.clone();
        let expected: Reply = usb.ask(1, Request::from_bytes(bytes));
        let frames = bus.exchange_frame(1, &bytes);
        prop_assert_eq!(frames.len(), 1);
        prop_assert_eq!(can::decode_reply(&frames[0].1), Ok((1, expected)));
    }
}
