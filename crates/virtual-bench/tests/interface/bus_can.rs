//! Several modules on one CAN bus: identifiers, rates, lengths (GP 69, 70, 71, 83, 88).

use crate::common::bus::{Bus, fine, get_variable, ggp, set_variable, sgp, twins};
use crate::common::{MODULE, TURN};
use tmcl_tables::{Command, GlobalParameter as Gp, Status};
use tmcl_wire::{Reply, Request};
use virtual_bench::can::{self, Frame, Length};
use virtual_bench::{ModuleId, TICK_NS, Wiring};

/// Sends a frame, and takes what is heard at once.
fn exchange(bus: &mut Bus, frame: &Frame) -> Vec<Frame> {
    bus.bench.send_frame(bus.line, frame);
    frames(bus)
}

fn frames(bus: &mut Bus) -> Vec<Frame> {
    let Bus { bench, line } = bus;
    std::iter::from_fn(|| bench.take_frame(*line)).collect()
}

fn request(bus: &mut Bus, id: u16, request: Request) -> Vec<Frame> {
    exchange(bus, &Frame::request(id, request))
}

fn reply(id: u16, module: u8, reply: Reply) -> Frame {
    let data = can::encode_reply(module, reply, Length::Seven);
    Frame::new(id, data.as_slice()).expect("seven bytes")
}

fn read(id: u16, module: u8, value: i32) -> Frame {
    reply(id, module, fine(Command::GetGlobalParameter, value))
}

fn written(id: u16, module: u8, value: i32) -> Frame {
    reply(id, module, fine(Command::SetGlobalParameter, value))
}

fn of_two() -> Bus {
    Bus::on(&twins(1, 3), Wiring::CAN)
}

#[test]
fn only_the_module_with_the_identifier_answers() {
    let mut bus = of_two();
    assert_eq!(request(&mut bus, 1, set_variable(0, 11)), [written(2, 1, 11)]);
    assert_eq!(request(&mut bus, 3, set_variable(0, 33)), [written(2, 3, 33)]);
    assert_eq!((bus.read("m1.variable.0"), bus.read("m2.variable.0")), (11.0, 33.0));
    for nobody in [0, 2, 4, 0x101, 0x7FF] {
        assert_eq!(request(&mut bus, nobody, set_variable(0, 44)), []);
    }
    bus.run_ms(100);
    assert_eq!(frames(&mut bus), []);
    assert_eq!((bus.read("m1.variable.0"), bus.read("m2.variable.0")), (11.0, 33.0));
}

#[test]
fn a_reply_has_the_length_of_the_request() {
    let mut bus = of_two();
    let command = Request::new(Command::FirmwareVersion, 1, 0, 0);
    let [seven] = exchange(&mut bus, &Frame::request(3, command))[..] else { panic!("one frame") };
    assert_eq!(seven.data.as_slice(), [3, 100, 136, 0x05, 0x1F, 0x01, 0x0B]);
    let mut bytes = [0; 8];
    bytes[..7].copy_from_slice(&command.to_bytes());
    let long = Frame::new(3, &bytes).expect("eight bytes");
    let [eight] = exchange(&mut bus, &long)[..] else { panic!("one frame") };
    assert_eq!(eight.data.as_slice(), [3, 100, 136, 0x05, 0x1F, 0x01, 0x0B, 0x1F]);
    let [text] = request(&mut bus, 3, Request::new(Command::FirmwareVersion, 0, 0, 0))[..] else {
        panic!("one frame")
    };
    assert_eq!((text.id, text.data.as_slice()), (2, &b"1311V111"[..]));
    for length in 0..7 {
        let short = Frame::new(3, &bytes[..length]).expect("short");
        assert_eq!(exchange(&mut bus, &short), [], "{length} bytes are no request");
    }
}

#[test]
fn new_identifiers_count_after_the_reply() {
    let mut bus = of_two();
    assert_eq!(request(&mut bus, 1, sgp(Gp::CanId, 0x123)), [written(2, 1, 0x123)]);
    assert_eq!(request(&mut bus, 1, get_variable(0)), []);
    assert_eq!(request(&mut bus, 0x123, sgp(Gp::CanReplyId, 0x7FF)), [written(2, 0x23, 0x7FF)]);
    assert_eq!(request(&mut bus, 0x123, get_variable(0)), [read(0x7FF, 0x23, 0)]);
    assert_eq!(request(&mut bus, 3, get_variable(0)), [read(2, 3, 0)]);
}

#[test]
fn a_secondary_identifier_is_obeyed_by_all_and_answered_by_none() {
    let mut bus = of_two();
    for id in [1, 3] {
        assert_eq!(request(&mut bus, id, sgp(Gp::CanSecondaryId, 0x200)).len(), 1);
    }
    assert_eq!(request(&mut bus, 0x200, Request::new(Command::RotateRight, 0, 0, TURN)), []);
    bus.run_ms(2000);
    assert_eq!(frames(&mut bus), []);
    bus.assert_turns_in_a_second(0, 1.0);
    bus.assert_turns_in_a_second(1, 1.0);
}

#[test]
fn a_new_rate_counts_after_the_reply_and_the_host_has_to_follow() {
    let mut bus = of_two();
    assert_eq!(request(&mut bus, 1, sgp(Gp::CanBitRate, 6)), [written(2, 1, 6)], "at the old rate");
    assert_eq!(request(&mut bus, 1, set_variable(0, 5)), []);
    assert_eq!(bus.read("m1.variable.0"), 0.0);
    assert_eq!(request(&mut bus, 3, get_variable(0)), [read(2, 3, 0)]);
    bus.bench.set_rate(bus.line, 250_000);
    assert_eq!(request(&mut bus, 1, get_variable(0)), [read(2, 1, 0)]);
    assert_eq!(request(&mut bus, 3, get_variable(0)), []);
    bus.bench.power_cycle(MODULE);
    assert_eq!(request(&mut bus, 1, ggp(Gp::CanBitRate)), [read(2, 1, 6)], "it is stored");
}

#[test]
fn every_rate_of_the_module_can_be_met() {
    let rates = [20_000, 50_000, 100_000, 125_000, 250_000, 500_000, 1_000_000];
    let mut bus = of_two();
    for (value, rate) in (2..).zip(rates) {
        assert_eq!(request(&mut bus, 1, sgp(Gp::CanBitRate, value)), [written(2, 1, value)]);
        bus.bench.set_rate(bus.line, rate);
        assert_eq!(request(&mut bus, 1, ggp(Gp::CanBitRate)), [read(2, 1, value)], "{rate} bit/s");
    }
}

#[test]
fn what_is_said_unasked_is_heard() {
    let mut bus = of_two();
    assert_eq!(request(&mut bus, 3, Request::new(Command::MoveToPosition, 0, 0, TURN / 4)).len(), 1);
    let asked = request(&mut bus, 3, Request::new(Command::RequestPositionReachedEvent, 0, 0, 0));
    assert_eq!(asked, [reply(2, 3, fine(Command::RequestPositionReachedEvent, 1))]);
    bus.run_ms(3000);
    let event =
        Reply { status: Status::Delayed, command: Command::RequestPositionReachedEvent.number(), value: 1 };
    assert_eq!(frames(&mut bus), [reply(2, 3, event)]);
    assert!((bus.bench.physical(ModuleId(1)).rotor_turns - 0.25).abs() < 0.005);
}

/// The pause of GP 75 is one of RS485.
#[test]
fn there_is_no_pause() {
    let mut bus = of_two();
    assert_eq!(request(&mut bus, 1, sgp(Gp::TelegramPause, 100)), [written(2, 1, 100)]);
    assert_eq!(request(&mut bus, 1, ggp(Gp::TelegramPause)), [read(2, 1, 100)]);
}

/// A reply under identifier 2 is a request to the module with this identifier: command 1, type 100, motor 10.
#[test]
fn a_module_may_take_replies_for_requests() {
    let file = format!("[bus]\nmodules_hear_replies = true\n{}", twins(1, 2));
    let mut bus = Bus::on(&file, Wiring::CAN);
    assert_eq!(request(&mut bus, 1, get_variable(0)), [read(2, 1, 0)]);
    bus.bench.advance_by(TICK_NS);
    let confused = Reply { status: Status::InvalidValue, command: 1, value: 0 };
    assert_eq!(frames(&mut bus), [reply(2, 2, confused)]);
    bus.run_ms(100);
    assert_eq!(frames(&mut bus), []);
}

#[test]
fn a_module_that_is_told_to_use_rs485_is_deaf_on_can() {
    let mut bus = of_two();
    assert_eq!(request(&mut bus, 1, sgp(Gp::InterfaceSelection, 0)), [written(2, 1, 0)]);
    assert_eq!(request(&mut bus, 1, get_variable(0)), []);
    assert_eq!(request(&mut bus, 3, ggp(Gp::InterfaceSelection)), [read(2, 3, 1)]);
}

#[test]
fn bytes_mean_nothing_on_can_and_frames_nothing_elsewhere() {
    let mut bus = of_two();
    bus.send(1, set_variable(0, 5));
    assert_eq!(bus.heard(), []);
    assert_eq!(bus.read("m1.variable.0"), 0.0);
    let mut serial = Bus::on(&twins(1, 3), Wiring::Rs485 { baud: None });
    assert_eq!(request(&mut serial, 1, set_variable(0, 5)), []);
    assert_eq!(serial.read("m1.variable.0"), 0.0);
}
