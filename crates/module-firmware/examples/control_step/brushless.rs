//! Control periods of the TMCM-1640's firmware: a rotor that turns evenly, whatever its phases are told.

use std::hint::black_box;

use module_firmware::tmcm_1640::{Drive, Sensed, Tmcm1640};
use module_firmware::{Firmware, PortId};
use tmcl_tables::Command;
use tmcl_tables::tmcm_1640::AxisParameter;
use tmcl_wire::{Request, serial};

use super::{Blank, Order, SETTLING_PERIODS, control_step};

/// Counts of the encoder in a turn, and in one of the four electrical turns of the default motor.
const COUNTS: i32 = 4096;
const ELECTRICAL_COUNTS: i32 = COUNTS / 4;

/// Control periods in a second.
const PERIODS_PER_S: i32 = 20_000;

/// The hall sensors' lines, sector by sector (decision).
const SECTORS: [u8; 6] = [0b001, 0b011, 0b010, 0b110, 0b100, 0b101];

/// What a module is told, and how its rotor turns.
pub(crate) struct Scenario {
    pub(crate) name: &'static str,
    requests: &'static [Order],
    turns_per_s: i32,
}

pub(crate) const SCENARIOS: &[Scenario] = &[
    Scenario { name: "brushless-standing", requests: &[], turns_per_s: 0 },
    Scenario {
        name: "brushless-velocity-by-halls",
        requests: &[(Command::RotateRight, 0, 2100)],
        turns_per_s: 35,
    },
    Scenario {
        name: "brushless-velocity-by-encoder",
        requests: &[set(AxisParameter::CommutationMode, 7), (Command::RotateRight, 0, 2100)],
        turns_per_s: 35,
    },
    Scenario {
        name: "brushless-position-by-encoder",
        requests: &[set(AxisParameter::CommutationMode, 7), (Command::MoveToPosition, 0, 10_000 * COUNTS)],
        turns_per_s: 35,
    },
];

const fn set(parameter: AxisParameter, value: i32) -> Order {
    (Command::SetAxisParameter, parameter.number(), value)
}

fn sensed(scenario: &Scenario, period: i32) -> Sensed {
    let counts = i64::from(period) * i64::from(scenario.turns_per_s * COUNTS) / i64::from(PERIODS_PER_S);
    let counts = counts as i32;
    let electrical = counts.rem_euclid(ELECTRICAL_COUNTS);
    let sector = (electrical * 6 / ELECTRICAL_COUNTS) as usize;
    Sensed {
        // What friction takes of a motor that turns; a constant, for the regulators do not settle here anyway.
        phase_currents_ma: if scenario.turns_per_s == 0 { [0; 3] } else { [300, -150, -150] },
        halls: SECTORS[sector],
        encoder_counts: counts,
        supply_voltage_dv: 240,
        driver_temperature_adc: 739,
        ..Sensed::default()
    }
}

pub(crate) fn run(scenario: &Scenario, periods: u32) {
    let mut firmware = Firmware::<Tmcm1640>::power_on(&mut Blank);
    for &(command, kind, value) in scenario.requests {
        for byte in serial::encode_request(1, Request::new(command, kind, 0, value)) {
            assert!(firmware.receive(PortId::ALL[0], byte), "the inbox has room");
        }
        let reply: Vec<u8> = std::iter::from_fn(|| firmware.transmit(PortId::ALL[0])).collect();
        assert_eq!(reply.get(2), Some(&100), "{}: {command:?} is refused", scenario.name);
    }
    let settled = SETTLING_PERIODS.cast_signed();
    for period in 0..settled {
        firmware.tick(&sensed(scenario, period));
    }
    let mut drive = Drive::default();
    for period in settled..settled + periods.cast_signed() {
        drive = black_box(control_step(black_box(&mut firmware), &sensed(scenario, period)));
    }
    println!("{}: {periods} control periods, duties {:?}", scenario.name, drive.duties);
}
