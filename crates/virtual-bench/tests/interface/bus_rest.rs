//! Modules on a bus rest one by one, with the same result bit for bit as if every control period were gone through.

use crate::common::TURN;
use crate::common::bus::{Bus, get_variable, set_variable, sgp};
use motor_physics::load::{LoadTorque, Profile};
use tmcl_tables::{Command, GlobalParameter as Gp};
use tmcl_wire::{Request, serial};
use virtual_bench::{TICK_NS, Wiring};

const RATES: [Option<u32>; 2] = [None, Some(9600)];

const MODULES: &str = r#"
[[module]]
kind = "tmcm-1311"
address = 1
[module.load]
LOAD
[[module]]
kind = "tmcm-1311"
address = 2
[module.load]
LOAD
[[module]]
kind = "tmcm-1640"
address = 3
[module.load]
LOAD
[[wire]]
from = "m1.output.0"
to = "m2.input.2"
[[event]]
at = "4.00001s"
set = { "m3.load.torque_nm" = 0.02 }
"#;

/// Modules that rest when they can.
fn resting(baud: Option<u32>) -> Bus {
    Bus::on(&MODULES.replace("LOAD", "torque_nm = 0.0"), Wiring::Rs485 { baud })
}

/// The same ones kept awake: their load might change with time, though it never does.
fn stepping(baud: Option<u32>) -> Bus {
    let load = "torque = { by = \"time\", points = [[0.0, 0.0]] }";
    Bus::on(&MODULES.replace("LOAD", load), Wiring::Rs485 { baud })
}

/// What a host does in a while.
fn act(bus: &mut Bus, step: u64) {
    let request = match step {
        0 => (1, Request::new(Command::MoveToPosition, 0, 0, TURN / 3)),
        1 => (2, sgp(Gp::TelegramPause, 37)),
        2 => (2, Request::new(Command::RotateLeft, 0, 0, TURN)),
        3 => (1, Request::new(Command::SetOutput, 0, 2, 1)),
        4 => (3, Request::new(Command::RotateRight, 0, 0, 500)),
        5 => (2, sgp(Gp::SerialHeartbeat, 700)),
        6 => (1, Request::new(Command::RequestPositionReachedEvent, 0, 0, 0)),
        7 => (3, Request::new(Command::MotorStop, 0, 0, 0)),
        8 => (2, set_variable(1, 2)),
        _ => (9, get_variable(0)),
    };
    bus.send(request.0, request.1);
}

/// All state there is, to the last bit, but for how the load is said.
fn state(bus: &Bus) -> String {
    let restless = LoadTorque::ByTime(Profile::new(&[(0.0, 0.0)], None).expect("a profile"));
    format!("{:?}", bus.bench).replace(&format!("{restless:?}"), &format!("{:?}", LoadTorque::Constant(0.0)))
}

#[test]
fn resting_is_stepping() {
    for baud in RATES {
        let (mut resting, mut stepping) = (resting(baud), stepping(baud));
        for step in 0..12 {
            act(&mut resting, step);
            act(&mut stepping, step);
            // Into a reply, and on until most of it rests.
            for ms in [13, 280] {
                resting.run_ms(ms);
                stepping.run_ms(ms);
                assert!(state(&resting) == state(&stepping), "step {step} at {baud:?} baud");
            }
            let bytes = resting.bytes();
            assert_eq!(bytes, stepping.bytes());
            assert_eq!(bytes.is_empty(), step >= 9, "step {step}");
        }
    }
}

#[test]
fn how_finely_a_run_is_sliced_does_not_matter() {
    for baud in RATES {
        let run = |slice_ticks: u64| {
            let mut bus = resting(baud);
            for step in 0..10 {
                act(&mut bus, step);
                let until_ns = bus.bench.time_ns() + 250_000_000;
                while bus.bench.time_ns() + slice_ticks * TICK_NS < until_ns {
                    bus.run_ticks(slice_ticks);
                }
                bus.bench.advance_to(until_ns);
            }
            state(&bus)
        };
        let whole = run(u64::MAX / TICK_NS / 2);
        for slice_ticks in [1, 7, 333] {
            assert!(run(slice_ticks) == whole, "slices of {slice_ticks} control periods at {baud:?} baud");
        }
    }
}

#[test]
fn a_snapshot_taken_within_a_reply_goes_on_as_the_original() {
    let mut bus = resting(Some(9600));
    bus.send(2, Request::new(Command::RotateRight, 0, 0, TURN));
    bus.run_ms(14);
    let mut snapshot = bus.clone();
    assert!(!bus.bytes().is_empty(), "it has begun");
    for bus in [&mut bus, &mut snapshot] {
        bus.run_ms(500);
    }
    let rest = bus.bytes();
    assert!(snapshot.bytes().ends_with(&rest) && !rest.is_empty());
    assert_eq!(state(&bus), state(&snapshot));
    assert_eq!(serial::DATAGRAM_LENGTH, 9);
}
