//! Lines with stand-ins for modules, which say what they are told to.

use std::collections::VecDeque;

use tmcl_wire::can::Frame;

use super::wire::SPOILED;
use super::{CanBus, CanStations, SerialBus, SerialStations};

/// Stand-ins.
#[derive(Default)]
struct Stations(Vec<Station>);

#[derive(Default)]
struct Station {
    baud: u32,
    heard: Vec<u8>,
    says: VecDeque<u8>,
    frames_heard: Vec<Frame>,
    frames: VecDeque<Frame>,
}

impl Stations {
    fn at(bauds: &[u32]) -> Self {
        Self(bauds.iter().map(|baud| Station { baud: *baud, ..Station::default() }).collect())
    }

    fn says(&mut self, place: usize, bytes: &[u8]) {
        self.0[place].says.extend(bytes);
    }

    fn heard(&self) -> Vec<&[u8]> {
        self.0.iter().map(|station| station.heard.as_slice()).collect()
    }
}

impl SerialStations for Stations {
    fn count(&self) -> usize {
        self.0.len()
    }

    fn baud(&self, place: usize) -> u32 {
        self.0[place].baud
    }

    fn speaks(&self, place: usize) -> bool {
        !self.0[place].says.is_empty()
    }

    fn take(&mut self, place: usize) -> Option<u8> {
        self.0[place].says.pop_front()
    }

    fn give(&mut self, place: usize, byte: u8) {
        self.0[place].heard.push(byte);
    }
}

impl CanStations for Stations {
    fn count(&self) -> usize {
        self.0.len()
    }

    fn bit_rate(&self, place: usize) -> u32 {
        self.0[place].baud
    }

    fn take_frame(&mut self, place: usize) -> Option<Frame> {
        self.0[place].frames.pop_front()
    }

    fn give_frame(&mut self, place: usize, frame: &Frame) {
        self.0[place].frames_heard.push(*frame);
    }
}

fn taken(bus: &mut SerialBus) -> Vec<u8> {
    let mut out = Vec::new();
    bus.take(&mut out);
    out
}

fn frame(id: u16, bytes: &[u8]) -> Frame {
    Frame::new(id, bytes).expect("up to eight bytes")
}

/// A byte at 1 Mbit/s.
const BYTE_NS: u64 = 10_000;

#[test]
fn without_a_rate_bytes_take_no_time_and_rates_do_not_matter() {
    let mut stations = Stations::at(&[9600, 115_200]);
    let mut bus = SerialBus::new(None, false);
    stations.says(1, b"ab");
    assert_eq!(bus.send(b"12", 0, &mut stations), 2);
    assert_eq!(stations.heard(), [b"12", b"12"]);
    assert_eq!(taken(&mut bus), b"ab");
    assert_eq!(bus.next_change_ns(), u64::MAX);
}

#[test]
fn without_a_rate_only_what_is_said_at_one_instant_collides() {
    let mut stations = Stations::at(&[9600; 3]);
    let mut bus = SerialBus::new(None, true);
    stations.says(0, b"abc");
    stations.says(2, b"de");
    assert!(bus.step(0, true, &mut stations));
    stations.says(2, b"f");
    assert!(bus.step(50, true, &mut stations));
    assert_eq!(taken(&mut bus), [SPOILED, SPOILED, SPOILED, b'f']);
    assert_eq!(stations.heard(), [&b"f"[..], &[SPOILED, SPOILED, SPOILED, b'f'], &[]]);
}

#[test]
fn bytes_take_the_time_of_ten_bits_and_no_rounding_adds_up() {
    const BAUD: u32 = 115_200;
    let mut stations = Stations::at(&[BAUD]);
    let mut bus = SerialBus::new(Some(BAUD), false);
    let sent: Vec<u8> = (0..=255).cycle().take(4000).collect();
    assert_eq!(bus.send(&sent, 0, &mut stations), 4000);
    for count in 1..=4000_u64 {
        let end_ns = (count * 10_000_000_000).div_ceil(BAUD.into());
        assert_eq!(bus.next_change_ns(), end_ns);
        bus.step(end_ns - 1, false, &mut stations);
        assert_eq!(stations.0[0].heard.len() as u64, count - 1);
        bus.step(end_ns, false, &mut stations);
    }
    assert_eq!(stations.0[0].heard, sent);
    assert_eq!(bus.next_change_ns(), u64::MAX);
}

#[test]
fn a_burst_may_last_for_ever() {
    const BAUD: u32 = 300;
    let mut stations = Stations::at(&[BAUD]);
    let mut bus = SerialBus::new(Some(BAUD), false);
    for minute in 0..60 {
        // So many bytes fill the minute to the nanosecond.
        assert_eq!(bus.send(&[7; 1800], minute * 60_000_000_000, &mut stations), 1800);
        bus.step((minute + 1) * 60_000_000_000, false, &mut stations);
        assert_eq!(bus.next_change_ns(), u64::MAX);
    }
    assert_eq!(stations.0[0].heard.len(), 60 * 1800);
}

#[test]
fn a_full_buffer_takes_no_more_until_bytes_have_left() {
    let mut stations = Stations::at(&[1_000_000]);
    let mut bus = SerialBus::new(Some(1_000_000), false);
    assert_eq!(bus.send(&[0; 5000], 0, &mut stations), 4096);
    // One of them is on the line.
    assert_eq!(bus.send(&[0; 5000], 0, &mut stations), 1);
    assert_eq!(bus.send(&[0; 5000], 0, &mut stations), 0);
    bus.step(10 * BYTE_NS, false, &mut stations);
    assert_eq!(bus.send(&[0; 5000], 10 * BYTE_NS, &mut stations), 10);
}

#[test]
fn who_listens_at_another_rate_hears_nothing_and_is_not_understood() {
    let mut stations = Stations::at(&[1_000_000, 500_000]);
    let mut bus = SerialBus::new(Some(1_000_000), false);
    bus.send(b"12", 0, &mut stations);
    bus.step(2 * BYTE_NS, false, &mut stations);
    assert_eq!(stations.heard(), [&b"12"[..], b""]);
    stations.says(1, b"ab");
    bus.step(2 * BYTE_NS, true, &mut stations);
    assert_eq!(bus.next_change_ns(), 4 * BYTE_NS, "it talks at its own pace");
    bus.step(6 * BYTE_NS, false, &mut stations);
    assert_eq!(taken(&mut bus), [SPOILED, SPOILED]);
}

#[test]
fn a_rate_that_changes_counts_from_the_next_burst_on() {
    let mut stations = Stations::at(&[1_000_000]);
    let mut bus = SerialBus::new(Some(1_000_000), false);
    stations.says(0, b"abc");
    bus.step(0, true, &mut stations);
    stations.0[0].baud = 500_000;
    bus.step(3 * BYTE_NS, false, &mut stations);
    assert_eq!(taken(&mut bus), b"abc");
    stations.says(0, b"d");
    bus.step(3 * BYTE_NS, true, &mut stations);
    bus.set_baud(500_000);
    bus.step(5 * BYTE_NS, false, &mut stations);
    assert_eq!(taken(&mut bus), b"d");
}

#[test]
fn modules_that_talk_at_once_spoil_each_other() {
    let mut stations = Stations::at(&[1_000_000; 3]);
    let mut bus = SerialBus::new(Some(1_000_000), true);
    stations.says(0, b"abcd");
    stations.says(1, b"abcd");
    bus.step(0, true, &mut stations);
    bus.step(4 * BYTE_NS, false, &mut stations);
    assert_eq!(taken(&mut bus), [SPOILED; 4], "even the same words");
    assert_eq!(stations.heard(), [&[][..], &[], &[SPOILED; 4]]);
}

#[test]
fn what_overlaps_is_spoiled_and_the_rest_is_not() {
    let mut stations = Stations::at(&[1_000_000; 2]);
    let mut bus = SerialBus::new(Some(1_000_000), false);
    stations.says(0, b"abc");
    bus.step(0, true, &mut stations);
    bus.step(15_000, false, &mut stations);
    stations.says(1, b"wxyz");
    bus.step(15_000, true, &mut stations);
    assert_eq!(stations.0[1].says.len(), 3, "it waits for nobody");
    bus.step(60_000, false, &mut stations);
    // w and x begin within b and c, and are not heard by themselves.
    assert_eq!(taken(&mut bus), [b'a', SPOILED, SPOILED, b'y', b'z']);
}

#[test]
fn a_host_that_does_not_wait_for_the_reply_spoils_it() {
    let mut stations = Stations::at(&[1_000_000; 2]);
    let mut bus = SerialBus::new(Some(1_000_000), false);
    bus.send(b"123", 0, &mut stations);
    bus.step(BYTE_NS, false, &mut stations);
    stations.says(0, b"ab");
    bus.step(BYTE_NS, true, &mut stations);
    bus.step(10 * BYTE_NS, false, &mut stations);
    assert_eq!(taken(&mut bus), [SPOILED, SPOILED]);
    assert_eq!(stations.heard(), [&b"1"[..], &[b'1', SPOILED, SPOILED]], "who talks does not listen");
}

#[test]
fn bytes_that_follow_each_other_do_not_overlap() {
    let mut stations = Stations::at(&[1_000_000; 2]);
    let mut bus = SerialBus::new(Some(1_000_000), true);
    bus.send(b"1", 0, &mut stations);
    bus.step(BYTE_NS, false, &mut stations);
    stations.says(0, b"a");
    bus.step(BYTE_NS, true, &mut stations);
    bus.step(2 * BYTE_NS, false, &mut stations);
    stations.says(1, b"b");
    bus.step(2 * BYTE_NS, true, &mut stations);
    bus.step(3 * BYTE_NS, false, &mut stations);
    assert_eq!(taken(&mut bus), b"ab");
    assert_eq!(stations.heard(), [b"1b", b"1a"]);
}

#[test]
fn a_host_that_goes_leaves_nothing_behind() {
    let mut stations = Stations::at(&[1_000_000]);
    let mut bus = SerialBus::new(Some(1_000_000), false);
    bus.send(b"12", 0, &mut stations);
    stations.says(0, b"a");
    bus.step(BYTE_NS, true, &mut stations);
    bus.hang_up();
    assert_eq!(bus.next_change_ns(), u64::MAX);
    bus.step(10 * BYTE_NS, true, &mut stations);
    assert_eq!(taken(&mut bus), []);
    assert_eq!(stations.heard(), [b"1"]);
}

#[test]
fn frames_reach_whoever_has_the_rate() {
    let mut stations = Stations::at(&[500_000, 250_000, 500_000]);
    let mut bus = CanBus::new(500_000, false);
    stations.0[1].frames.push_back(frame(2, b"lost"));
    stations.0[2].frames.push_back(frame(2, b"reply"));
    bus.send(&frame(1, b"request"), &mut stations);
    let heard = |place: usize, stations: &Stations| stations.0[place].frames_heard.clone();
    assert_eq!(heard(0, &stations), [frame(1, b"request")]);
    assert_eq!(heard(1, &stations), []);
    assert_eq!(heard(2, &stations), [frame(1, b"request")]);
    assert_eq!(bus.take(), Some(frame(2, b"reply")));
    assert_eq!(bus.take(), None);
    bus.set_bit_rate(250_000);
    bus.send(&frame(1, b"again"), &mut stations);
    assert_eq!(heard(1, &stations), [frame(1, b"again")]);
}

#[test]
fn frames_that_come_at_once_go_by_their_identifiers() {
    let mut stations = Stations::at(&[1_000_000; 3]);
    let mut bus = CanBus::new(1_000_000, true);
    for (place, id) in [(0, 7), (1, 3), (2, 7)] {
        stations.0[place].frames.push_back(frame(id, &[place as u8]));
    }
    assert!(bus.round(&mut stations));
    let all = [frame(3, &[1]), frame(7, &[0]), frame(7, &[2])];
    assert_eq!(std::iter::from_fn(|| bus.take()).collect::<Vec<_>>(), all);
    assert_eq!(stations.0[0].frames_heard, [frame(3, &[1]), frame(7, &[2])]);
    assert_eq!(stations.0[1].frames_heard, [frame(7, &[0]), frame(7, &[2])]);
    assert!(!bus.round(&mut stations));
}
