//! Several modules on one RS485 bus without a rate: who answers, who executes, who is silent (GP 66, 76, 87, 255, 68).

use crate::common::bus::{Bus, fine, get_variable, ggp, set_variable, sgp, twins};
use crate::common::{MODULE, TURN};
use tmcl_tables::tmcm_1311::AxisParameter as Ap;
use tmcl_tables::{Command, GlobalParameter as Gp, Status};
use tmcl_wire::{Reply, Request, serial};
use virtual_bench::{Bench, BenchConfig, ModuleKind, PortId, Wiring};

const RS485: Wiring = Wiring::Rs485 { baud: None };

#[test]
fn only_the_addressed_module_executes_and_answers() {
    let mut bus = Bus::of_two(RS485);
    assert_eq!(bus.ok(1, Request::new(Command::FirmwareVersion, 1, 0, 0)), 0x051F_010B);
    assert_eq!(bus.ok(2, Request::new(Command::FirmwareVersion, 1, 0, 0)), 0x0668_0200);
    bus.ok(1, set_variable(0, 11));
    bus.ok(2, set_variable(0, 22));
    assert_eq!((bus.read("m1.variable.0"), bus.read("m2.variable.0")), (11.0, 22.0));
    for nobody in [0, 3, 255] {
        bus.send(nobody, set_variable(0, 33));
    }
    bus.run_ms(1000);
    assert_eq!(bus.heard(), []);
    assert_eq!((bus.read("m1.variable.0"), bus.read("m2.variable.0")), (11.0, 22.0));
}

#[test]
fn every_module_moves_its_own_motor() {
    let mut bus = Bus::of_two(RS485);
    bus.ok(1, Request::new(Command::RotateRight, 0, 0, TURN));
    bus.ok(2, Request::new(Command::RotateLeft, 0, 0, 300));
    bus.run_ms(3000);
    bus.assert_turns_in_a_second(0, 1.0);
    bus.assert_turns_in_a_second(1, -5.0);
}

#[test]
fn requests_may_follow_each_other_without_a_pause() {
    let mut bus = Bus::of_two(RS485);
    let mut bytes = Vec::new();
    for value in 0..50 {
        bytes.extend(serial::encode_request(1, set_variable(1, value)));
        bytes.extend(serial::encode_request(2, set_variable(1, -value)));
    }
    bus.send_bytes(&bytes);
    let expected: Vec<_> = (0..50)
        .flat_map(|value| {
            [(1, value), (2, -value)]
                .map(|(module, value)| (2, module, fine(Command::SetGlobalParameter, value)))
        })
        .collect();
    assert_eq!(bus.heard(), expected);
}

#[test]
fn a_new_address_counts_once_the_old_one_has_answered() {
    let mut bus = Bus::of_two(RS485);
    assert_eq!(bus.ok(1, sgp(Gp::SerialAddress, 9)), 9);
    bus.send(1, ggp(Gp::SerialAddress));
    assert_eq!(bus.heard(), []);
    assert_eq!(bus.ok(9, ggp(Gp::SerialAddress)), 9);
    assert_eq!(bus.ok(2, ggp(Gp::SerialAddress)), 2);
}

#[test]
fn a_new_host_address_counts_from_the_next_reply_on() {
    let mut bus = Bus::of_two(RS485);
    bus.ok(1, sgp(Gp::HostAddress, 7));
    bus.send(1, ggp(Gp::HostAddress));
    assert_eq!(bus.heard(), [(7, 1, fine(Command::GetGlobalParameter, 7))]);
    assert_eq!(bus.ok(2, ggp(Gp::HostAddress)), 2);
}

#[test]
fn a_secondary_address_is_obeyed_by_all_and_answered_by_none() {
    let mut bus = Bus::on(&twins(1, 3), RS485);
    for address in [1, 3] {
        bus.ok(address, sgp(Gp::SerialSecondaryAddress, 100));
        bus.ok(address, Request::new(Command::SetAxisParameter, Ap::MaxVelocity.number(), 0, TURN));
    }
    bus.send(100, Request::new(Command::RotateRight, 0, 0, TURN));
    bus.run_ms(2000);
    assert_eq!(bus.heard(), []);
    bus.assert_turns_in_a_second(0, 1.0);
    bus.assert_turns_in_a_second(1, 1.0);
    bus.send(100, Request::new(Command::MotorStop, 0, 0, 0));
    bus.run_ms(2000);
    assert_eq!(bus.heard(), []);
    assert!(bus.rpm(0).abs() < 1e-3 && bus.rpm(1).abs() < 1e-3);
    bus.ok(1, sgp(Gp::SerialSecondaryAddress, 0));
    bus.send(100, set_variable(0, 5));
    assert_eq!((bus.read("m1.variable.0"), bus.read("m2.variable.0")), (0.0, 5.0));
}

#[test]
fn a_module_that_suppresses_replies_leaves_the_others_alone() {
    let mut bus = Bus::of_two(RS485);
    bus.ok(2, sgp(Gp::SuppressReply, 1));
    bus.send(2, set_variable(0, 5));
    assert_eq!(bus.heard(), []);
    assert_eq!(bus.read("m2.variable.0"), 5.0);
    assert_eq!(bus.ok(1, get_variable(0)), 0);
    bus.ok(2, sgp(Gp::SuppressReply, 0));
    assert_eq!(bus.ok(2, get_variable(0)), 5);
}

#[test]
fn modules_with_one_address_spoil_each_others_replies() {
    let mut bus = Bus::on(&twins(5, 5), RS485);
    bus.send(5, set_variable(0, 1));
    let bytes: [u8; 9] = bus.bytes().try_into().expect("as long as a reply");
    assert_eq!(bytes, [0xFF; 9]);
    assert!(serial::decode_reply(bytes).is_err(), "the host can tell");
    // Both have executed it.
    assert_eq!((bus.read("m1.variable.0"), bus.read("m2.variable.0")), (1.0, 1.0));
}

#[test]
fn a_host_that_falls_silent_stops_the_motor() {
    let mut bus = Bus::of_two(RS485);
    bus.ok(1, Request::new(Command::RotateRight, 0, 0, TURN));
    bus.run_ms(2000);
    bus.ok(1, sgp(Gp::SerialHeartbeat, 500));
    let began = bus.turns(0);
    for _ in 0..10 {
        bus.run_ms(499);
        bus.ok(1, get_variable(0));
    }
    assert!((bus.turns(0) - began - 4.99).abs() < 0.02, "{} turns", bus.turns(0) - began);
    // What is said to others does not count.
    for _ in 0..3 {
        bus.run_ms(200);
        bus.ok(2, get_variable(0));
    }
    bus.run_ms(2000);
    assert!(bus.rpm(0).abs() < 1e-3, "{} rpm", bus.rpm(0));
    assert_eq!(bus.read("m1.actual_velocity"), 0.0);
}

#[test]
fn other_lines_know_nothing_of_it() {
    let mut bus = Bus::of_two(RS485);
    let [_, usb, second, _] = PortId::ALL;
    bus.bench.wire(second, RS485);
    bus.send(2, get_variable(0));
    let mut out = Vec::new();
    bus.bench.take(second, &mut out);
    assert_eq!(out, []);
    assert_eq!(bus.heard(), [(2, 2, fine(Command::GetGlobalParameter, 0))]);
    // A line that is not wired is the first module's.
    bus.bench.converse(usb, &serial::encode_request(2, get_variable(0)), &mut out);
    assert_eq!(out, []);
    bus.bench.converse(usb, &serial::encode_request(1, get_variable(0)), &mut out);
    assert_eq!(out.len(), 9);
}

#[test]
fn a_host_that_hangs_up_leaves_nothing_to_the_next() {
    let mut bus = Bus::of_two(RS485);
    bus.send(2, get_variable(0));
    bus.send_bytes(&serial::encode_request(1, set_variable(0, 7))[..5]);
    bus.bench.hang_up(bus.line);
    assert_eq!(bus.heard(), []);
    assert_eq!(bus.ok(1, get_variable(0)), 0);
}

const HEARING: &str = "[bus]\nmodules_hear_replies = true\n";

/// On two wires a reply to host 2 is a request to module 2: address 2, command 1 (the replying module), type 100 (its
/// status), motor 10 (the command), which is no motor.
#[test]
fn on_two_wires_a_module_takes_replies_to_its_address_for_requests() {
    let mut bus = Bus::on(&format!("{HEARING}{}", twins(1, 2)), RS485);
    bus.send(1, ggp(Gp::SerialAddress));
    assert_eq!(bus.heard(), [(2, 1, fine(Command::GetGlobalParameter, 1))]);
    bus.run_ticks(1);
    let confused = Reply { status: Status::InvalidValue, command: 1, value: 0 };
    assert_eq!(bus.heard(), [(2, 2, confused)]);
    bus.run_ms(1000);
    assert_eq!(bus.heard(), [], "it does not hear itself");
    // A host with an address of its own has no such trouble.
    bus.send(1, sgp(Gp::HostAddress, 250));
    bus.run_ms(1);
    bus.bytes();
    bus.send(1, ggp(Gp::SerialAddress));
    bus.run_ms(1000);
    assert_eq!(bus.heard(), [(250, 1, fine(Command::GetGlobalParameter, 1))]);
}

#[test]
fn behind_an_adapter_they_do_not() {
    let mut bus = Bus::on(&twins(1, 2), RS485);
    bus.send(1, ggp(Gp::SerialAddress));
    bus.run_ms(1000);
    assert_eq!(bus.heard(), [(2, 1, fine(Command::GetGlobalParameter, 1))]);
}

/// Each is the other's host, and answers what it hears. Virtual time goes on nevertheless.
#[test]
fn two_that_answer_each_other_do_so_for_ever() {
    let mut bus = Bus::on(&format!("{HEARING}{}", twins(1, 2)), RS485);
    bus.send(2, sgp(Gp::HostAddress, 1));
    bus.send(1, ggp(Gp::SerialAddress));
    bus.run_ms(100);
    let replies = bus.bytes().len() / 9;
    assert!(replies > 1000, "{replies} replies in 100 ms");
    assert!(!bus.bench.is_at_rest());
    bus.bench.hang_up(bus.line);
    bus.run_ms(1);
    assert_eq!(bus.bytes(), []);
}

#[test]
fn a_module_that_is_off_is_not_on_the_bus() {
    use virtual_bench::config::{Power, Setting};
    let mut bus = Bus::on(&twins(1, 1), RS485);
    bus.bench.apply(MODULE, Setting::Power(Power::Off));
    assert_eq!(bus.ok(1, get_variable(0)), 0);
    bus.bench.apply(MODULE, Setting::Power(Power::On));
    bus.send(1, get_variable(0));
    assert_eq!(bus.bytes(), [0xFF; 9]);
}

/// The bench presets the address, and RS485 where there is a choice; on USB there is nothing to choose.
#[test]
fn modules_come_to_a_bus_with_its_interface_and_their_addresses() {
    let mut bus = Bus::on(&twins(5, 6), RS485);
    assert_eq!(bus.ok(5, ggp(Gp::InterfaceSelection)), 0);
    assert_eq!(bus.ok(6, ggp(Gp::CanId)), 6);
    let bench = Bench::new(&BenchConfig::default_for(ModuleKind::Tmcm1311));
    let read = |name| bench.read(bench.probe(name).expect("a global parameter"));
    assert_eq!((read("interface_selection"), read("can_id")), (1.0, 1.0));
}

#[test]
fn a_module_that_is_told_to_use_can_is_deaf_on_rs485_from_then_on() {
    let mut bus = Bus::on(&twins(1, 3), RS485);
    bus.ok(1, sgp(Gp::InterfaceSelection, 1));
    bus.send(1, get_variable(0));
    bus.run_ms(100);
    assert_eq!(bus.heard(), []);
    bus.bench.power_cycle(MODULE);
    bus.send(1, get_variable(0));
    assert_eq!(bus.heard(), [], "it is stored");
    assert_eq!(bus.ok(3, get_variable(0)), 0);
}
