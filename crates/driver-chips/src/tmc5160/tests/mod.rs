//! The whole chip: with a real motor's equations behind it, and with whatever registers and pins.

use core::f64::consts::{SQRT_2, TAU};

use motor_physics::Terminal;
use motor_physics::mechanics::Mechanics;
use motor_physics::presets;
use motor_physics::stepper::Stepper;

use super::*;

mod choppers;
mod counting;
mod faults;
mod load;
mod properties;

const PERIOD_S: f64 = 50e-6;
const PERIOD_CLOCKS: f64 = 600.0;

/// The TMCM-1076's: linear from nothing to 3 A RMS.
const BOARD: Board = Board { full_scale_rms_a: 3.0, lowest_scale: 0.0 };

/// The registers of a TMCM-1076 with its factory settings.
fn factory() -> Registers {
    Registers {
        ihold_irun: IHoldIRun { ihold: 3, irun: 24, iholddelay: 0 },
        tpowerdown: 10,
        chopconf: ChopConf { mres: 4, intpol: true, ..ChopConf::from_bits(33_011) },
        pwmconf: PwmConf::from_bits(328_136),
        ..Registers::default()
    }
}

/// Pulses of 50 % duty at an interval in clocks, as a pulse generator makes them.
#[derive(Clone, Copy, Debug, Default)]
struct Pulses {
    interval: f64,
    reverse: bool,
    /// Half-intervals that have begun.
    phase: f64,
    rising: bool,
}

impl Pulses {
    /// The edges of a control period, at most `most`.
    fn edges(&mut self, most: u32) -> Edges {
        let half = self.interval / 2.0;
        let first = (1.0 - self.phase) * half;
        let fit = if first >= PERIOD_CLOCKS { 0 } else { 1 + ((PERIOD_CLOCKS - 1e-3 - first) / half) as u32 };
        let count = fit.min(most);
        self.phase = (self.phase + PERIOD_CLOCKS / half - f64::from(fit)).max(0.0);
        let last = first + f64::from(count.saturating_sub(1)) * half;
        let edges = Edges {
            count,
            first_clock: first as u32,
            last_clock: last as u32,
            rising_first: !self.rising,
            reverse: self.reverse,
        };
        self.rising ^= count % 2 == 1;
        edges
    }
}

/// A QSH5718-51-28-101 on a 24 V supply.
struct Rig {
    chip: Tmc5160,
    registers: Registers,
    motor: Stepper,
    bus_voltage_v: f64,
    load_nm: f64,
    enabled: bool,
    temperature_c: f64,
    pulses: Pulses,
}

impl Rig {
    fn new(registers: Registers) -> Self {
        let parameters = presets::stepper("QSH5718-51-28-101").expect("a preset");
        let mechanics = Mechanics {
            inertia_kgm2: 2.0 * parameters.rotor_inertia_kgm2,
            friction_nm: 0.02,
            viscous_nm_s_per_rad: 5e-4,
            hard_stops: None,
        };
        Self {
            chip: Tmc5160::new(BOARD),
            registers,
            motor: Stepper::new(parameters, mechanics),
            bus_voltage_v: 24.0,
            load_nm: 0.0,
            enabled: true,
            temperature_c: 25.0,
            pulses: Pulses::default(),
        }
    }

    fn pins(&self) -> Pins {
        Pins {
            currents_a: self.motor.currents_a,
            back_emf_v: self.motor.back_emf_v(),
            rotor_velocity_rps: self.motor.velocity_rad_s / TAU,
            bus_voltage_v: self.bus_voltage_v,
            resistance_ohm: self.motor.parameters().resistance_ohm,
            inductance_h: self.motor.parameters().inductance_h,
            temperature_c: self.temperature_c,
            coil_faults: [CoilFault::None; 2],
        }
    }

    fn period(&mut self, edges: &[Edges]) -> [Terminal; 2] {
        let pins = self.pins();
        let inputs = Inputs { pins: &pins, enabled: self.enabled, edges };
        let terminals = self.chip.advance(&self.registers, inputs, PERIOD_S);
        self.motor.advance(terminals, self.load_nm, PERIOD_S);
        terminals
    }

    fn wait(&mut self, time_s: f64) {
        for _ in 0..(time_s / PERIOD_S) as u32 {
            self.period(&[]);
        }
    }

    /// So many edges, whose frequency rises or falls linearly over them between two frequencies of pulses.
    fn ramp(&mut self, edges: u32, from_hz: f64, to_hz: f64) {
        let mut left = edges;
        while left > 0 {
            let done = 1.0 - f64::from(left) / f64::from(edges);
            // Linear in time, as v² is linear in the way.
            let frequency_hz = libm::sqrt(from_hz * from_hz + done * (to_hz * to_hz - from_hz * from_hz));
            self.pulses.interval = CLOCK_HZ / frequency_hz;
            let here = self.pulses.edges(left);
            left -= here.count;
            self.period(&[here]);
        }
    }

    /// Pulses at one frequency for a time.
    fn run(&mut self, frequency_hz: f64, time_s: f64) {
        self.pulses.interval = CLOCK_HZ / frequency_hz;
        for _ in 0..libm::round(time_s / PERIOD_S) as u32 {
            let edges = self.pulses.edges(u32::MAX);
            self.period(&[edges]);
        }
    }

    /// A move of so many edges at a frequency of pulses, with a tenth of them each for getting fast and slow.
    fn go(&mut self, edges: u32, frequency_hz: f64) {
        let tenth = edges / 10;
        self.ramp(tenth, 100.0, frequency_hz);
        self.ramp(edges - 2 * tenth, frequency_hz, frequency_hz);
        self.ramp(tenth, frequency_hz, 100.0);
    }

    /// RMS of a coil's current over a sine whose amplitude is the vector's length.
    fn rms_a(&self) -> f64 {
        let [a, b] = self.motor.currents_a;
        libm::hypot(a, b) / SQRT_2
    }
}
