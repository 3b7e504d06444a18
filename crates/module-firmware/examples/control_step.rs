//! Control periods of the modules' firmware, for counting their instructions (CONTRIBUTING.md says how).
//!
//! `control_step SCENARIO [PERIODS]`: settles, then goes through so many control periods in [`control_step`] and nowhere else,
//! with sensors that say the same in every run. Without a scenario it lists them.
#![allow(clippy::disallowed_methods, reason = "a command of its own, which reads its arguments")]

#[path = "control_step/brushless.rs"]
mod brushless;

use std::f64::consts::TAU;
use std::hint::black_box;
use std::process::ExitCode;

use module_firmware::tmcm_1311::{DriverStatus, Sensed, Tmcm1311};
use module_firmware::{Axis, Firmware, Instruction, PortId, RecordKey, Storage, StorageError};
use tmcl_tables::Command;
use tmcl_tables::tmcm_1311::AxisParameter;
use tmcl_wire::{Request, serial};

/// Control periods before counting begins: the initialisation and the ramps are over by then.
const SETTLING_PERIODS: u32 = 30_000;

/// µsteps in a turn at 256 µsteps per full step, and in an electrical period.
const TURN: i32 = 51_200;
const ELECTRICAL_PERIOD: i32 = 1024;

/// Counts of the encoder in a turn.
const COUNTS: i32 = 40_000;

/// How many µsteps the rotor follows its field by in a control period at most: 12 turns/s.
const LARGEST_STEP: i32 = 31;

/// What a module is told.
struct Scenario {
    name: &'static str,
    closed_loop: bool,
    /// Command, type and value, sent one after the other; in closed loop once that is initialised.
    requests: &'static [Order],
}

type Order = (Command, u8, i32);

const ACCELERATION: Order = set(AxisParameter::MaxAcceleration, 20 * TURN);
const VELOCITY: Order = set(AxisParameter::MaxVelocity, 10 * TURN);
const CURRENT: Order = set(AxisParameter::CurrentScaleEnable, 1);

const SCENARIOS: &[Scenario] = &[
    Scenario { name: "standing", closed_loop: false, requests: &[] },
    Scenario {
        name: "open-loop-velocity",
        closed_loop: false,
        requests: &[ACCELERATION, VELOCITY, (Command::RotateRight, 0, 5 * TURN)],
    },
    Scenario {
        name: "open-loop-position",
        closed_loop: false,
        requests: &[ACCELERATION, VELOCITY, (Command::MoveToPosition, 0, 30_000 * TURN)],
    },
    Scenario { name: "closed-loop-standstill", closed_loop: true, requests: &[CURRENT] },
    Scenario {
        name: "closed-loop-velocity",
        closed_loop: true,
        requests: &[CURRENT, ACCELERATION, VELOCITY, (Command::RotateRight, 0, 5 * TURN)],
    },
    Scenario {
        name: "closed-loop-position",
        closed_loop: true,
        requests: &[CURRENT, ACCELERATION, VELOCITY, (Command::MoveToPosition, 0, 10_000 * COUNTS)],
    },
    Scenario {
        name: "closed-loop-torque",
        closed_loop: true,
        requests: &[set(AxisParameter::TorqueTargetCurrent, 1000)],
    },
];

const fn set(parameter: AxisParameter, value: i32) -> Order {
    (Command::SetAxisParameter, parameter.number(), value)
}

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
fn control_step<A: Axis>(firmware: &mut Firmware<A>, sensed: &A::Sensed) -> A::Drive {
    firmware.tick(sensed)
}

/// A motor without load or inertia: its rotor turns to where its field points.
#[derive(Default)]
struct Motor {
    microsteps: i32,
}

impl Motor {
    fn follow(&mut self, [a, b]: [i16; 2]) {
        let field = f64::from(b).atan2(f64::from(a)) / TAU * f64::from(ELECTRICAL_PERIOD);
        let half = ELECTRICAL_PERIOD / 2;
        let ahead = (field.round() as i32 - self.microsteps + half).rem_euclid(ELECTRICAL_PERIOD) - half;
        self.microsteps += ahead.clamp(-LARGEST_STEP, LARGEST_STEP);
    }

    fn sensed(&self) -> Sensed {
        let counts = i64::from(self.microsteps) * i64::from(COUNTS) / i64::from(TURN);
        Sensed {
            encoder_counts: counts as i32,
            coil_currents_ma: [1500, -1500],
            supply_voltage_dv: 480,
            temperature_c: 30,
            driver: DriverStatus { stallguard: 400, current_scale: 16, flags: 0 },
            ..Sensed::default()
        }
    }
}

/// A module and its motor.
struct Plant {
    firmware: Firmware<Tmcm1311>,
    motor: Motor,
}

impl Plant {
    fn new() -> Self {
        Self { firmware: Firmware::power_on(&mut Blank), motor: Motor::default() }
    }

    /// The status and the value of the reply.
    fn ask(&mut self, (command, kind, value): Order) -> (u8, i32) {
        for byte in serial::encode_request(1, Request::new(command, kind, 0, value)) {
            assert!(self.firmware.receive(PortId::ALL[0], byte), "the inbox has room");
        }
        let reply: Vec<u8> = std::iter::from_fn(|| self.firmware.transmit(PortId::ALL[0])).collect();
        let &[_, _, status, _, a, b, c, d, _] = reply.as_slice() else { panic!("no reply to {command:?}") };
        (status, i32::from_be_bytes([a, b, c, d]))
    }

    fn tell(&mut self, order: Order) {
        assert_eq!(self.ask(order).0, 100, "{order:?} is refused");
    }

    fn settle(&mut self) {
        for _ in 0..SETTLING_PERIODS {
            let drive = self.firmware.tick(&self.motor.sensed());
            self.motor.follow(drive.coils);
        }
    }

    fn count(&mut self, periods: u32) {
        for _ in 0..periods {
            let drive = black_box(control_step(black_box(&mut self.firmware), &self.motor.sensed()));
            self.motor.follow(drive.coils);
        }
    }

    fn close_loop(&mut self) {
        self.tell(set(AxisParameter::EncoderResolution, COUNTS));
        self.tell(set(AxisParameter::ClosedLoopMode, 1));
        self.settle();
        let initialized = AxisParameter::ClosedLoopInitialized.number();
        assert_eq!(self.ask((Command::GetAxisParameter, initialized, 0)), (100, 1), "not initialised");
    }
}

fn run(scenario: &Scenario, periods: u32) {
    let mut plant = Plant::new();
    if scenario.closed_loop {
        plant.close_loop();
    }
    for &order in scenario.requests {
        plant.tell(order);
    }
    plant.settle();
    plant.count(periods);
    let read = |plant: &mut Plant, parameter: AxisParameter| {
        plant.ask((Command::GetAxisParameter, parameter.number(), 0)).1
    };
    let velocity_pps = read(&mut plant, AxisParameter::MeasuredVelocity);
    let current_scale = read(&mut plant, AxisParameter::ActualCurrentScale);
    println!("{}: {periods} control periods, {velocity_pps} pps, AP 123 = {current_scale}", scenario.name);
}

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let name = arguments.next().unwrap_or_default();
    let periods = arguments.next().and_then(|periods| periods.parse().ok()).unwrap_or(1000);
    if let Some(scenario) = brushless::SCENARIOS.iter().find(|scenario| scenario.name == name) {
        brushless::run(scenario, periods);
        return ExitCode::SUCCESS;
    }
    let Some(scenario) = SCENARIOS.iter().find(|scenario| scenario.name == name) else {
        let brushless = brushless::SCENARIOS.iter().map(|scenario| scenario.name);
        let names: Vec<_> = SCENARIOS.iter().map(|scenario| scenario.name).chain(brushless).collect();
        eprintln!("usage: control_step SCENARIO [PERIODS]; scenarios: {}", names.join(", "));
        return ExitCode::FAILURE;
    };
    run(scenario, periods);
    ExitCode::SUCCESS
}
