//! What takes time on an RS485 bus: the pause before a reply (GP 75), and bytes where the line has a rate (GP 65).

use crate::common::bus::{Bus, fine, get_variable, ggp, set_variable, sgp, twins};
use crate::common::{MODULE, TURN};
use tmcl_tables::{Command, GlobalParameter as Gp, Status};
use tmcl_wire::{Reply, Request, serial};
use virtual_bench::{TICK_NS, Wiring};

const UNTIMED: Wiring = Wiring::Rs485 { baud: None };

fn at(baud: u32) -> Wiring {
    Wiring::Rs485 { baud: Some(baud) }
}

/// The end of the control period in which something is noticed that happens at this instant.
fn noticed(time_ns: u64) -> u64 {
    time_ns.next_multiple_of(TICK_NS)
}

/// When so many bytes have left a line, rounded up to a nanosecond.
fn bytes_ns(count: u64, baud: u64) -> u64 {
    (count * 10_000_000_000).div_ceil(baud)
}

/// Runs until there is something to hear, and returns when that was.
#[track_caller]
fn next_answer_ns(bus: &mut Bus) -> u64 {
    for _ in 0..100_000 {
        if bus.bench.has_answer(bus.line) {
            return bus.bench.time_ns();
        }
        bus.run_ticks(1);
    }
    panic!("silence");
}

#[test]
fn a_pause_is_exact_to_the_control_period() {
    let mut bus = Bus::of_two(UNTIMED);
    for pause_ms in [1, 7, 255] {
        // The pause in effect is that at the request, which had none yet.
        bus.ok(1, sgp(Gp::TelegramPause, pause_ms));
        bus.run_ms(50);
        let sent_ns = bus.bench.time_ns();
        bus.send(1, sgp(Gp::TelegramPause, 0));
        assert_eq!(bus.read("m1.telegram_pause"), 0.0, "executed at once");
        assert_eq!(next_answer_ns(&mut bus) - sent_ns, pause_ms.unsigned_abs() as u64 * 1_000_000);
        assert_eq!(bus.heard(), [(2, 1, fine(Command::SetGlobalParameter, 0))]);
    }
}

#[test]
fn a_pause_is_exact_however_the_run_is_sliced() {
    let mut started = Bus::of_two(UNTIMED);
    started.ok(1, sgp(Gp::TelegramPause, 200));
    started.run_ms(3000);
    started.send(1, get_variable(0));
    let mut sliced = started.clone();
    started.run_ticks(200 * 20 - 1);
    assert_eq!(started.heard(), []);
    started.run_ticks(1);
    assert_eq!(started.heard(), [(2, 1, fine(Command::GetGlobalParameter, 0))]);
    (0..200 * 20).for_each(|_| sliced.run_ticks(1));
    assert_eq!(sliced.heard(), [(2, 1, fine(Command::GetGlobalParameter, 0))]);
    assert_eq!(format!("{:?}", started.bench), format!("{:?}", sliced.bench));
}

#[test]
fn others_talk_during_a_pause() {
    let mut bus = Bus::of_two(UNTIMED);
    bus.ok(1, sgp(Gp::TelegramPause, 10));
    bus.send(1, get_variable(0));
    assert_eq!(bus.ok(2, set_variable(3, 4)), 4);
    bus.run_ms(10);
    assert_eq!(bus.heard(), [(2, 1, fine(Command::GetGlobalParameter, 0))]);
}

#[test]
fn two_whose_pauses_end_at_one_instant_collide() {
    let mut bus = Bus::of_two(UNTIMED);
    bus.ok(1, sgp(Gp::TelegramPause, 10));
    bus.ok(2, sgp(Gp::TelegramPause, 8));
    bus.send(1, get_variable(0));
    bus.run_ms(2);
    bus.send(2, get_variable(0));
    bus.run_ms(8);
    assert_eq!(bus.bytes(), [0xFF; 9]);
}

/// Nine bytes to the module, at the next control period its reply, nine bytes back.
#[test]
fn a_request_and_its_reply_take_the_time_of_their_bits() {
    for (baud, value) in [(9600, 0), (19_200, 2), (115_200, 7), (1_000_000, 11)] {
        let mut bus = Bus::on(&twins(1, 3), at(9600));
        set_baud(&mut bus, 1, value, baud);
        bus.run_ms(20);
        let sent_ns = bus.bench.time_ns();
        bus.send(1, get_variable(0));
        let executed_ns = noticed(sent_ns + bytes_ns(9, baud.into()));
        let mut reply = Vec::new();
        for count in 1..=9 {
            let arrived_ns = noticed(executed_ns + bytes_ns(count, baud.into()));
            if bus.bench.time_ns() < arrived_ns {
                bus.bench.advance_to(arrived_ns - TICK_NS);
                reply.extend(bus.bytes());
                assert!((reply.len() as u64) < count, "byte {count} at {baud} baud came early");
            }
            bus.bench.advance_to(arrived_ns);
            reply.extend(bus.bytes());
            assert!(reply.len() as u64 >= count, "byte {count} at {baud} baud came late");
        }
        let reply = reply.try_into().expect("nine bytes");
        assert_eq!(serial::decode_reply(reply), Ok((2, 1, fine(Command::GetGlobalParameter, 0))));
        bus.run_ms(100);
        assert_eq!(bus.bytes(), []);
    }
}

/// Sets a module's rate over a line at 9600 baud, and the line to it.
#[track_caller]
fn set_baud(bus: &mut Bus, address: u8, value: i32, baud: u32) {
    bus.send(address, sgp(Gp::BaudRate, value));
    bus.run_ms(30);
    assert_eq!(bus.heard(), [(2, address, fine(Command::SetGlobalParameter, value))], "at the old rate");
    bus.bench.set_rate(bus.line, baud);
}

#[test]
fn the_pause_begins_when_the_request_is_complete() {
    let mut bus = Bus::of_two(at(9600));
    bus.send(2, sgp(Gp::TelegramPause, 4));
    bus.run_ms(30);
    bus.bytes();
    let sent_ns = bus.bench.time_ns();
    bus.send(2, get_variable(0));
    let executed_ns = noticed(sent_ns + bytes_ns(9, 9600));
    assert_eq!(next_answer_ns(&mut bus), noticed(executed_ns + 4_000_000 + bytes_ns(1, 9600)));
}

#[test]
fn a_module_at_another_rate_is_deaf_until_the_host_follows() {
    let mut bus = Bus::of_two(at(9600));
    bus.send(1, sgp(Gp::BaudRate, 7));
    bus.run_ms(30);
    assert_eq!(bus.heard(), [(2, 1, fine(Command::SetGlobalParameter, 7))], "at the old rate");
    bus.send(1, set_variable(0, 1));
    bus.run_ms(100);
    assert_eq!(bus.heard(), []);
    assert_eq!(bus.read("m1.variable.0"), 0.0);
    bus.bench.set_rate(bus.line, 115_200);
    bus.send(1, set_variable(0, 2));
    bus.run_ms(3);
    assert_eq!(bus.heard(), [(2, 1, fine(Command::SetGlobalParameter, 2))]);
    // The other one is still where it was.
    bus.send(2, set_variable(0, 3));
    bus.run_ms(100);
    assert_eq!(bus.heard(), []);
    assert_eq!(bus.read("m2.variable.0"), 0.0);
}

/// It is stored as it is set.
#[test]
fn a_rate_survives_a_power_cycle() {
    let mut bus = Bus::of_two(at(9600));
    bus.send(1, sgp(Gp::BaudRate, 7));
    bus.run_ms(30);
    bus.bytes();
    bus.bench.power_cycle(MODULE);
    bus.bench.set_rate(bus.line, 115_200);
    bus.send(1, ggp(Gp::BaudRate));
    bus.run_ms(3);
    assert_eq!(bus.heard(), [(2, 1, fine(Command::GetGlobalParameter, 7))]);
    assert_eq!(bus.bench.baud_rate(MODULE), Some(115_200));
}

/// What a module says unasked at another rate is noise to the host.
#[test]
fn an_event_at_another_rate_is_noise() {
    let mut bus = Bus::of_two(at(9600));
    bus.send(1, Request::new(Command::MoveToPosition, 0, 0, TURN / 4));
    bus.run_ms(30);
    bus.send(1, Request::new(Command::RequestPositionReachedEvent, 0, 0, 0));
    bus.run_ms(30);
    bus.send(1, sgp(Gp::BaudRate, 7));
    bus.run_ms(30);
    assert_eq!(bus.heard().len(), 3);
    bus.run_ms(3000);
    assert_eq!(bus.bytes(), [0xFF; 9]);
}

#[test]
fn an_event_at_the_rate_of_the_line_is_heard() {
    let mut bus = Bus::of_two(at(9600));
    bus.send(1, Request::new(Command::MoveToPosition, 0, 0, TURN / 4));
    bus.run_ms(30);
    bus.send(1, Request::new(Command::RequestPositionReachedEvent, 0, 0, 0));
    bus.run_ms(30);
    assert_eq!(bus.heard().len(), 2);
    bus.run_ms(3000);
    let command = Command::RequestPositionReachedEvent.number();
    assert_eq!(bus.heard(), [(2, 1, Reply { status: Status::Delayed, command, value: 1 })]);
}

#[test]
fn modules_with_one_address_collide_byte_by_byte() {
    let mut bus = Bus::on(&twins(1, 1), at(9600));
    bus.send(1, set_variable(0, 1));
    bus.run_ms(100);
    assert_eq!(bus.bytes(), [0xFF; 9]);
    assert_eq!((bus.read("m1.variable.0"), bus.read("m2.variable.0")), (1.0, 1.0));
}

/// One of two twins takes its time: their replies overlap in part.
#[test]
fn replies_that_overlap_in_part_are_spoiled_in_part() {
    let mut bus = Bus::on(&twins(1, 3), at(9600));
    bus.send(3, sgp(Gp::TelegramPause, 5));
    bus.run_ms(30);
    bus.send(3, sgp(Gp::SerialAddress, 1));
    bus.run_ms(30);
    assert_eq!(bus.heard().len(), 2);
    bus.send(1, set_variable(0, 1));
    bus.run_ms(100);
    let bytes = bus.bytes();
    let reply = serial::encode_reply(2, 1, fine(Command::SetGlobalParameter, 1));
    // The second begins 5 ms after the first, within its fifth byte.
    assert_eq!(bytes[..4], reply[..4]);
    assert_eq!(bytes[4..9], [0xFF; 5]);
    assert_eq!(bytes[9..], reply[9 - bytes[9..].len()..], "the end of the second is heard again");
    assert!((4..=5).contains(&bytes[9..].len()), "{bytes:02X?}");
}

/// Half duplex: who sends the next request before the reply has come spoils both.
#[test]
fn a_host_that_does_not_wait_is_not_understood() {
    let mut bus = Bus::of_two(at(9600));
    let mut bytes = serial::encode_request(1, set_variable(0, 1)).to_vec();
    bytes.extend(serial::encode_request(2, set_variable(0, 2)));
    bus.send_bytes(&bytes);
    bus.run_ms(100);
    assert_eq!(bus.bytes()[..8], [0xFF; 8]);
    assert_eq!((bus.read("m1.variable.0"), bus.read("m2.variable.0")), (1.0, 0.0));
    // After silence everybody is in step again.
    bus.send(2, set_variable(0, 3));
    bus.run_ms(100);
    assert_eq!(bus.heard(), [(2, 2, fine(Command::SetGlobalParameter, 3))]);
}

/// A partial datagram lives as long as a whole one takes (decisions 1.3): 9.375 ms.
#[test]
fn a_pause_within_a_datagram_may_last_as_long_as_one() {
    let datagram = serial::encode_request(1, set_variable(0, 1));
    for (silence_ms, understood) in [(9, true), (12, false)] {
        let mut bus = Bus::of_two(at(9600));
        bus.send_bytes(&datagram[..5]);
        // The last of them arrives after 5.2 ms, and the next a millisecond after it was sent.
        bus.run_ticks(105 + (silence_ms - 1) * 20);
        bus.send_bytes(&datagram[5..]);
        bus.run_ms(50);
        assert_eq!(bus.bytes().len(), if understood { 9 } else { 0 }, "{silence_ms} ms");
        bus.run_ms(50);
        bus.send(1, get_variable(0));
        bus.run_ms(50);
        assert_eq!(bus.heard(), [(2, 1, fine(Command::GetGlobalParameter, i32::from(understood)))]);
    }
}

/// The bytes on their way keep the bench awake, and nothing else does.
#[test]
fn a_bus_is_at_rest_when_nothing_is_on_its_way() {
    let mut bus = Bus::of_two(at(9600));
    bus.run_ms(5000);
    assert!(bus.bench.is_at_rest());
    bus.send(1, get_variable(0));
    bus.run_ms(5);
    assert!(!bus.bench.is_at_rest(), "half of the request is on its way");
    bus.run_ms(100);
    assert!(bus.bench.is_at_rest());
}
