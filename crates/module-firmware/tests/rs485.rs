//! RS485: who is spoken to, when an answer leaves, and what silence means (TMCM-1311 §10.1).

mod common;

use common::{CAN, Node, RS485, USB, answer, datagram};
use module_firmware::tmcm_1311::{Sensed, Tmcm1311};
use module_firmware::tmcm_1640::Tmcm1640;
use module_firmware::{Axis, Line, TICKS_PER_MS};
use tmcl_tables::{Command, Status};
use tmcl_wire::{Reply, Request, serial};

const GAP: Command = Command::GetAxisParameter;
const SGP: Command = Command::SetGlobalParameter;
const GGP: Command = Command::GetGlobalParameter;

/// A module that listens to its RS485 line.
fn node() -> Node<Tmcm1311> {
    let mut node = Node::new();
    node.sgp(88, 0);
    node
}

#[test]
fn only_the_addressed_module_answers() {
    let mut node = node();
    assert_eq!(node.exchange(RS485, &datagram(1, GAP, 4, 0, 0)), answer(1, GAP, 51_200));
    for address in [0, 2, 3, 255] {
        assert_eq!(node.exchange(RS485, &datagram(address, SGP, 0, 2, 5)), []);
    }
    assert_eq!(node.ok(GGP, 0, 2, 0), 0, "nor does it obey");
}

/// Decisions 2a.11.
#[test]
fn a_new_address_and_host_count_after_the_reply() {
    let mut node = node();
    assert_eq!(node.exchange(RS485, &datagram(1, SGP, 66, 0, 9)), answer(1, SGP, 9));
    assert_eq!(node.exchange(RS485, &datagram(1, GAP, 4, 0, 0)), []);
    assert_eq!(node.exchange(RS485, &datagram(9, SGP, 76, 0, 7)), answer(9, SGP, 7));
    let reply = Reply { status: Status::Ok, command: GAP.number(), value: 51_200 };
    assert_eq!(node.exchange(RS485, &datagram(9, GAP, 4, 0, 0)), serial::encode_reply(7, 9, reply));
}

#[test]
fn the_secondary_address_and_suppression_are_obeyed_in_silence() {
    let mut node = node();
    node.sgp(87, 20);
    assert_eq!(node.exchange(RS485, &datagram(20, SGP, 0, 2, 5)), []);
    assert_eq!(node.ok(GGP, 0, 2, 0), 5);
    node.sgp(255, 1);
    assert_eq!(node.exchange(RS485, &datagram(1, SGP, 0, 2, 6)), []);
    assert_eq!(node.exchange(RS485, &datagram(1, SGP, 255, 0, 0)), answer(1, SGP, 0));
    assert_eq!(node.ok(GGP, 0, 2, 0), 6);
}

/// Events that all come at once leave room for the reply to a request that waits for the storage.
#[test]
fn a_reply_that_waits_for_the_storage_keeps_its_room() {
    const EVENT: Command = Command::RequestPositionReachedEvent;
    const EVENTS: usize = 20;
    let mut node = node();
    node.ok(Command::MoveToPosition, 0, 0, 100);
    for _ in 0..EVENTS {
        assert_eq!(node.exchange(RS485, &datagram(1, EVENT, 0, 0, 0)), answer(1, EVENT, 1));
    }
    for byte in datagram(1, SGP, 87, 0, 20) {
        assert!(node.firmware.receive(RS485, byte));
    }
    assert!(node.firmware.has_background_work());
    for _ in 0..1000 * TICKS_PER_MS {
        let _ = node.firmware.tick(&Sensed::default());
    }
    node.work();
    let event = Reply { status: Status::Delayed, command: EVENT.number(), value: 1 };
    let events = serial::encode_reply(2, 1, event).repeat(EVENTS);
    assert_eq!(node.heard(RS485), [answer(1, SGP, 20).as_slice(), &events].concat());
}

mod pause {
    use super::*;

    #[test]
    fn a_reply_leaves_when_it_is_over_and_rest_knows_when() {
        let mut node = node();
        node.sgp(75, 15);
        node.feed(RS485, &datagram(1, GAP, 4, 0, 0));
        for passed in 0..15 * TICKS_PER_MS {
            assert!(!node.firmware.has_output(RS485), "{passed} ticks");
            assert_eq!(node.firmware.transmit(RS485), None);
            assert_eq!(node.firmware.quiet_ticks(), 15 * TICKS_PER_MS - passed - 1);
            assert_eq!(node.firmware.is_idle(&Sensed::default()), passed != 15 * TICKS_PER_MS - 1);
            node.run(1);
        }
        assert!(node.firmware.has_output(RS485));
        assert!(node.firmware.is_idle(&Sensed::default()));
        assert_eq!(node.heard(RS485), answer(1, GAP, 51_200));
    }

    /// Going through the periods at once ends where going through each does.
    #[test]
    fn skipping_is_ticking() {
        let mut node = node();
        node.sgp(75, 3);
        node.feed(RS485, &datagram(1, GAP, 4, 0, 0));
        node.firmware.skip(node.firmware.quiet_ticks());
        assert!(!node.firmware.has_output(RS485));
        node.run(1);
        assert!(node.firmware.has_output(RS485));
    }

    #[test]
    fn is_for_rs485_only_and_not_within_what_is_being_said() {
        let mut node = node();
        node.sgp(75, 255);
        assert_eq!(node.exchange(USB, &datagram(1, GAP, 4, 0, 0)), answer(1, GAP, 51_200));
        node.sgp(75, 1);
        node.feed(RS485, &datagram(1, GAP, 4, 0, 0));
        node.run_ms(1);
        assert_eq!(node.firmware.transmit(RS485), Some(2));
        node.feed(RS485, &datagram(1, GAP, 5, 0, 0));
        let expected = [answer(1, GAP, 51_200), answer(1, GAP, 51_200)].concat();
        assert_eq!(node.heard(RS485), expected[1..]);
    }

    #[test]
    fn the_reply_to_its_own_change_waits_as_long_as_before() {
        let mut node = node();
        node.sgp(75, 2);
        assert_eq!(node.exchange(RS485, &datagram(1, SGP, 75, 0, 0)), []);
        node.run_ms(2);
        assert_eq!(node.heard(RS485), answer(1, SGP, 0));
        assert_eq!(node.exchange(RS485, &datagram(1, GAP, 4, 0, 0)), answer(1, GAP, 51_200));
    }

    /// The module counts its time anew, but not the pause of the reply that is still to come.
    #[test]
    fn outlives_a_restart() {
        let mut node = node();
        node.run_ms(500);
        node.sgp(75, 10);
        assert_eq!(node.exchange(RS485, &datagram(1, Command::SoftwareReset, 0, 0, 1234)), []);
        node.run(10 * TICKS_PER_MS - 1);
        assert_eq!(node.heard(RS485), []);
        node.run(1);
        assert_eq!(node.heard(RS485), answer(1, Command::SoftwareReset, 1234));
        assert_eq!(node.exchange(RS485, &datagram(1, GAP, 4, 0, 0)), [], "the line is what it was");
        node.run_ms(10);
        assert_eq!(node.heard(RS485), answer(1, GAP, 51_200));
    }
}

mod rates {
    use super::*;

    /// Decisions 2a.11.
    #[test]
    fn a_new_rate_counts_once_the_reply_has_left() {
        let mut node = node();
        assert_eq!(node.firmware.baud_rate(), 9600);
        node.feed(RS485, &datagram(1, SGP, 65, 0, 7));
        for _ in 0..9 {
            node.run(3);
            assert_eq!(node.firmware.baud_rate(), 9600);
            assert!(node.firmware.transmit(RS485).is_some());
        }
        assert_eq!(node.firmware.baud_rate(), 115_200);
        assert_eq!(node.ok(GGP, 65, 0, 0), 7);
        node.power_cycle();
        assert_eq!(node.firmware.baud_rate(), 115_200, "stored");
    }

    #[test]
    fn an_unread_reply_elsewhere_does_not_hold_it_up() {
        let mut node = node();
        node.feed(USB, &datagram(1, GAP, 4, 0, 0));
        assert_eq!(node.exchange(RS485, &datagram(1, SGP, 65, 0, 11)), answer(1, SGP, 11));
        assert_eq!(node.firmware.baud_rate(), 1_000_000);
    }

    #[test]
    fn without_a_reply_it_counts_at_once() {
        let mut node = node();
        node.sgp(87, 20);
        node.feed(RS485, &datagram(20, SGP, 65, 0, 1));
        assert_eq!(node.firmware.baud_rate(), 14_400);
        // By a program: CALC LOAD, 2; AGP 65, 0.
        node.ok(Command::DownloadStart, 0, 0, 0);
        for instruction in [
            Request::new(Command::Calculate, 9, 0, 2),
            Request::new(Command::AccumulatorToGlobalParameter, 65, 0, 0),
        ] {
            assert_eq!(node.ask(1, instruction).status, Status::Loaded);
        }
        node.ok(Command::DownloadEnd, 0, 0, 0);
        node.ok(Command::ApplicationRun, 1, 0, 0);
        node.run(2);
        assert_eq!(node.firmware.baud_rate(), 19_200);
    }

    #[test]
    fn the_other_module_has_a_baud_rate_and_no_can() {
        let mut node = Node::<Tmcm1640>::new();
        node.sgp(65, 7);
        assert_eq!((node.firmware.baud_rate(), node.firmware.can_bit_rate()), (115_200, 0));
    }
}

mod silence {
    use super::*;

    /// Whether a datagram with this gap in it is understood.
    fn survives(node: &Node<Tmcm1311>, port: module_firmware::PortId, gap: u64) -> bool {
        let mut node = node.clone();
        let datagram = datagram(1, GAP, 4, 0, 0);
        node.feed(port, &datagram[..4]);
        node.run(gap);
        !node.exchange(port, &datagram[4..]).is_empty()
    }

    /// Decisions 1.3: nine bytes of ten bits.
    #[test]
    fn a_partial_datagram_lives_as_long_as_a_whole_one_takes() {
        for (value, ticks) in [(0, 188), (2, 94), (7, 16), (11, 2)] {
            let mut node = node();
            node.sgp(65, value);
            assert!(survives(&node, RS485, ticks), "{ticks} ticks at GP 65 = {value}");
            assert!(!survives(&node, RS485, ticks + 1), "{} ticks at GP 65 = {value}", ticks + 1);
            assert!(
                survives(&node, USB, 100 * TICKS_PER_MS) && !survives(&node, USB, 100 * TICKS_PER_MS + 1)
            );
        }
    }

    #[test]
    fn the_surroundings_may_know_better() {
        let mut node = node();
        node.firmware.set_silence(400);
        assert!(survives(&node, RS485, 400) && !survives(&node, RS485, 401));
        assert!(survives(&node, USB, 400) && !survives(&node, USB, 401));
        node.ok(Command::SoftwareReset, 0, 0, 1234);
        assert!(survives(&node, RS485, 400), "also after it began anew");
    }
}

/// GP 88 (decisions 2a.14).
mod interface {
    use super::*;

    #[test]
    fn rs485_is_deaf_as_delivered_and_usb_never_is() {
        let mut node = Node::<Tmcm1311>::new();
        assert_eq!(node.exchange(RS485, &datagram(1, GAP, 4, 0, 0)), []);
        node.sgp(88, 0);
        assert_eq!(node.exchange(RS485, &datagram(1, GAP, 4, 0, 0)), answer(1, GAP, 51_200));
        assert_eq!(node.exchange_frame(1, &[6, 4, 0, 0, 0, 0, 0]), []);
        assert_eq!(node.exchange(USB, &datagram(1, GAP, 4, 0, 0)), answer(1, GAP, 51_200));
    }

    #[test]
    fn the_line_that_is_switched_off_still_brings_the_reply() {
        let mut node = node();
        let half = &datagram(1, GAP, 4, 0, 0)[..4];
        assert_eq!(node.exchange(RS485, &datagram(1, SGP, 88, 0, 1)), answer(1, SGP, 1));
        assert_eq!(node.exchange(RS485, half), []);
        node.sgp(88, 0);
        assert_eq!(node.exchange(RS485, &datagram(1, GAP, 4, 0, 0)), answer(1, GAP, 51_200));
    }

    #[test]
    fn a_module_without_it_listens_to_rs485() {
        let mut node = Node::<Tmcm1640>::new();
        assert_eq!(node.exchange(RS485, &datagram(1, GAP, 0, 0, 0)), answer(1, GAP, 0));
        assert_eq!(node.exchange_frame(1, &[6, 0, 0, 0, 0, 0, 0]), []);
    }

    #[test]
    fn bytes_on_can_and_frames_on_a_stream_are_nothing() {
        let mut node = Node::<Tmcm1311>::new();
        assert_eq!(node.exchange(CAN, &datagram(1, GAP, 4, 0, 0)), []);
        node.firmware.set_line(CAN, Line::Usb);
        assert_eq!(node.exchange_frame(1, &[6, 4, 0, 0, 0, 0, 0]), []);
        assert_eq!(node.exchange(CAN, &datagram(1, GAP, 4, 0, 0)), answer(1, GAP, 51_200));
    }
}

/// GP 68 (decisions 2a.15).
mod heartbeat {
    use super::*;

    const TARGET_VELOCITY: u8 = 2;

    /// A module that turns, with a heartbeat of 100 ms from now on.
    fn turning() -> Node<Tmcm1311> {
        let mut node = node();
        node.ok(Command::RotateRight, 0, 0, 1000);
        node.sgp(68, 100);
        node
    }

    fn turns(node: &mut Node<Tmcm1311>) -> bool {
        node.gap(TARGET_VELOCITY) == 1000
    }

    #[test]
    fn silence_stops_the_motor() {
        let mut node = turning();
        node.run(100 * TICKS_PER_MS - 1);
        assert!(turns(&mut node));
        node.run(1);
        assert!(!turns(&mut node));
        node.run_ms(100);
        assert_eq!(node.gap(3), 0, "it ramped down");
    }

    #[test]
    fn whatever_is_for_this_module_on_rs485_restarts_it() {
        let mut node = turning();
        node.sgp(87, 20);
        let (known, unknown) =
            (datagram(1, GAP, 4, 0, 0), serial::encode_request(1, Request::from_bytes([200; 7])));
        for datagram in [known, unknown, datagram(20, GAP, 4, 0, 0)] {
            node.run_ms(99);
            node.exchange(RS485, &datagram);
        }
        node.run(100 * TICKS_PER_MS - 1);
        assert!(turns(&mut node));
        node.run(1);
        assert!(!turns(&mut node));
    }

    #[test]
    fn what_is_for_others_spoiled_or_on_usb_does_not() {
        let mut spoiled = datagram(1, GAP, 4, 0, 0);
        spoiled[8] ^= 1;
        for (port, datagram) in
            [(RS485, datagram(3, GAP, 4, 0, 0)), (RS485, spoiled), (USB, datagram(1, GAP, 4, 0, 0))]
        {
            let mut node = turning();
            node.run_ms(99);
            node.exchange(port, &datagram);
            node.run_ms(1);
            assert!(!turns(&mut node), "{datagram:02x?}");
        }
    }

    /// As MST once: a new command turns the motor until the time is up again.
    #[test]
    fn one_silence_is_one_stop() {
        let mut node = turning();
        node.run_ms(100);
        node.ok(Command::RotateRight, 0, 0, 1000);
        node.run_ms(1000);
        assert!(turns(&mut node), "over USB, which it does not watch");
        node.exchange(RS485, &datagram(1, GAP, 4, 0, 0));
        node.run_ms(100);
        assert!(!turns(&mut node));
    }

    #[test]
    fn a_program_goes_on() {
        let mut node = turning();
        node.ok(Command::DownloadStart, 0, 0, 0);
        assert_eq!(node.ask(1, Request::new(Command::Jump, 0, 0, 0)).status, Status::Loaded);
        node.ok(Command::DownloadEnd, 0, 0, 0);
        node.ok(Command::ApplicationRun, 1, 0, 0);
        node.run_ms(100);
        assert!(!turns(&mut node));
        assert_eq!(node.ok(GGP, 128, 0, 0), 1);
    }

    #[test]
    fn a_line_that_is_not_listened_to_is_not_watched() {
        let mut node = turning();
        node.sgp(88, 1);
        node.run_ms(1000);
        assert!(turns(&mut node));
        node.sgp(88, 0);
        node.run(100 * TICKS_PER_MS - 1);
        assert!(turns(&mut node), "counts from when it is");
        node.run(1);
        assert!(!turns(&mut node));
        let mut without_bus = turning();
        without_bus.firmware.set_line(RS485, Line::Usb);
        without_bus.run_ms(1000);
        assert!(turns(&mut without_bus));
    }

    #[test]
    fn is_stored_and_counts_from_power_on() {
        let mut node = turning();
        node.power_cycle();
        node.ok(Command::RotateRight, 0, 0, 1000);
        node.run(100 * TICKS_PER_MS - 1);
        assert!(turns(&mut node));
        node.run(1);
        assert!(!turns(&mut node));
    }

    #[test]
    fn rest_knows_when() {
        let mut node = node();
        node.run_ms(100);
        node.sgp(68, 50);
        node.run(1);
        assert!(node.firmware.is_idle(&Sensed::default()));
        assert_eq!(node.firmware.quiet_ticks(), 50 * TICKS_PER_MS - 2);
        node.firmware.skip(node.firmware.quiet_ticks());
        assert!(!node.firmware.is_idle(&Sensed::default()));
        assert_eq!(node.firmware.axis().get(module_firmware::tmcm_1311::AxisParameter::RampMode), 0);
        node.run(1);
        assert_eq!(node.firmware.axis().get(module_firmware::tmcm_1311::AxisParameter::RampMode), 1);
        assert!(node.firmware.quiet_ticks() > TICKS_PER_MS);
    }
}
