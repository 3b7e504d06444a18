//! Control periods of the TMCM-1311's firmware, for counting their instructions (CONTRIBUTING.md says how).
//!
//! `control_step SCENARIO [PERIODS]`: settles, then goes through so many control periods in [`control_step`] and nowhere else,
//! with sensors that say the same in every run. Without a scenario it lists them.
#![allow(clippy::disallowed_methods, reason = "a command of its own, which reads its arguments")]

use std::hint::black_box;
use std::process::ExitCode;

use module_firmware::tmcm_1311::{Drive, DriverStatus, Sensed, Tmcm1311};
use module_firmware::{Firmware, Instruction, PortId, RecordKey, Storage, StorageError};
use tmcl_tables::Command;
use tmcl_tables::tmcm_1311::AxisParameter;
use tmcl_wire::{Request, serial};

/// Control periods before counting begins: the ramps are over by then.
const SETTLING_PERIODS: u32 = 20_000;

/// µsteps in a turn at 256 µsteps per full step.
const TURN: i32 = 51_200;

/// What a module is told, and what its encoder sees of it.
struct Scenario {
    name: &'static str,
    /// Command, type and value, sent one after the other.
    requests: &'static [(Command, u8, i32)],
    /// How far the encoder counts in a control period.
    counts_per_period: i32,
}

const ACCELERATION: (Command, u8, i32) =
    (Command::SetAxisParameter, AxisParameter::MaxAcceleration.number(), 20 * TURN);
const VELOCITY: (Command, u8, i32) =
    (Command::SetAxisParameter, AxisParameter::MaxVelocity.number(), 10 * TURN);

const SCENARIOS: &[Scenario] = &[
    Scenario { name: "standing", requests: &[], counts_per_period: 0 },
    Scenario {
        name: "open-loop-velocity",
        requests: &[ACCELERATION, VELOCITY, (Command::RotateRight, 0, 5 * TURN)],
        counts_per_period: 10, // 5 turns/s, 40 000 counts a turn
    },
    Scenario {
        name: "open-loop-position",
        requests: &[ACCELERATION, VELOCITY, (Command::MoveToPosition, 0, 30_000 * TURN)],
        counts_per_period: 20,
    },
];

/// A memory that holds nothing and forgets everything.
struct Blank;

impl Storage for Blank {
    fn read(&mut self, _: RecordKey, _: &mut [u8]) -> Result<usize, StorageError> {
        Ok(0)
    }

    fn write(&mut self, _: RecordKey, _: &[u8]) -> Result<(), StorageError> {
        Ok(())
    }

    fn erase(&mut self) -> Result<(), StorageError> {
        Ok(())
    }

    fn read_program(&mut self, _: &mut [Instruction]) -> Result<(), StorageError> {
        Ok(())
    }

    fn write_instruction(&mut self, _: u16, _: Instruction) -> Result<(), StorageError> {
        Ok(())
    }

    fn erase_program(&mut self) -> Result<(), StorageError> {
        Ok(())
    }
}

/// One control period: what is counted.
#[inline(never)]
fn control_step(firmware: &mut Firmware<Tmcm1311>, sensed: &Sensed) -> Drive {
    firmware.tick(sensed)
}

fn sensed(scenario: &Scenario, period: u32) -> Sensed {
    Sensed {
        encoder_counts: scenario.counts_per_period.wrapping_mul(period.cast_signed()),
        supply_voltage_dv: 480,
        temperature_c: 30,
        driver: DriverStatus { stallguard: 400, current_scale: 16, flags: 0 },
        ..Sensed::default()
    }
}

/// A module that was told what the scenario says.
fn prepared(scenario: &Scenario) -> Firmware<Tmcm1311> {
    let mut firmware = Firmware::power_on(&mut Blank);
    for &(command, kind, value) in scenario.requests {
        for byte in serial::encode_request(1, Request::new(command, kind, 0, value)) {
            assert!(firmware.receive(PortId::ALL[0], byte), "the inbox has room");
        }
        let reply: Vec<u8> = std::iter::from_fn(|| firmware.transmit(PortId::ALL[0])).collect();
        assert_eq!(reply.get(2), Some(&100), "{}: {command:?} is refused", scenario.name);
    }
    firmware
}

fn run(scenario: &Scenario, periods: u32) {
    let mut firmware = prepared(scenario);
    for period in 0..SETTLING_PERIODS {
        firmware.tick(&sensed(scenario, period));
    }
    for period in SETTLING_PERIODS..SETTLING_PERIODS + periods {
        black_box(control_step(black_box(&mut firmware), &sensed(scenario, period)));
    }
    println!("{}: {periods} control periods", scenario.name);
}

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let name = arguments.next().unwrap_or_default();
    let periods = arguments.next().and_then(|periods| periods.parse().ok()).unwrap_or(1000);
    let Some(scenario) = SCENARIOS.iter().find(|scenario| scenario.name == name) else {
        let names: Vec<_> = SCENARIOS.iter().map(|scenario| scenario.name).collect();
        eprintln!("usage: control_step SCENARIO [PERIODS]; scenarios: {}", names.join(", "));
        return ExitCode::FAILURE;
    };
    run(scenario, periods);
    ExitCode::SUCCESS
}
