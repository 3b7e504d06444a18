//! The chip: its parts in the order in which a control period passes through them.

use core::f64::consts::SQRT_2;

use motor_physics::Terminal;

use super::sequencer::Sequencer;
use super::{Pins, Registers};
use crate::stepper::chopper;
use crate::stepper::coil::CoilMonitor;
use crate::stepper::coolstep::Regulator;
use crate::stepper::stallguard::{Measurement, StallGuard};
use crate::stepper::standstill::Standstill;
use crate::stepper::table::{AMPLITUDE, Command};
use crate::stepper::temperature::{Levels, Temperature};

/// The chip's clock.
const CLOCK_HZ: f64 = 16e6;

/// Datasheet, "Temperature Sensors"; the pre-warning ends 5 K lower (decision: no hysteresis is given for it), and the
/// bridges come back at the TMC262C's release level.
const LEVELS: Levels =
    Levels { warning_c: 100.0, warning_end_c: 95.0, shutdown_c: 150.0, shutdown_end_c: 120.0 };

/// What the board makes of the chip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Board {
    /// The RMS coil current at CS = 31 and VSENSE = 0, which the sense resistors set: 3 A on the TMCM-1311.
    pub full_scale_rms_a: f64,
}

/// What the chip can be asked (DRVSTATUS in all its formats).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Status {
    /// SG: the last stallGuard2 reading, 0 to 1023; more load reads lower. Means little below one revolution per second.
    pub stallguard_value: u16,
    /// The SG flag: the reading is 0.
    pub stall: bool,
    /// SE: the current scale in use, 0 to 31; coolStep's, or CS without it.
    pub current_scale: u8,
    /// MSTEP: the sequencer's position, 0 to 1023 microsteps.
    pub microstep_position: u16,
    /// OT: the chip was at 150 °C and is not yet below 120 °C. The bridges are off.
    pub over_temperature: bool,
    /// OTPW: the chip was at 100 °C and is not yet below 95 °C.
    pub over_temperature_warning: bool,
    /// S2GA and S2GB: a short to ground switched the bridges off, until the off time is set to 0.
    pub short_to_ground: [bool; 2],
    /// OLA and OLB: the current never reached its target over a half-wave. Tells nothing about a motor that stands.
    pub open_load: [bool; 2],
    /// STST: no step and no new current for 65.5 ms.
    pub standstill: bool,
}

/// A TMC262.
///
/// With unchanging registers and pins its state comes to rest bit for bit, within 67 ms: [`Self::advance`] then leaves it
/// as it is and returns the same again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tmc262 {
    board: Board,
    sequencer: Sequencer,
    standstill: Standstill,
    stallguard: Measurement,
    coolstep: Regulator,
    temperature: Temperature,
    coils: [CoilMonitor; 2],
}

impl Tmc262 {
    /// The chip after power-on.
    #[must_use]
    pub fn new(board: Board) -> Self {
        Self {
            board,
            sequencer: Sequencer::default(),
            standstill: Standstill::default(),
            stallguard: Measurement::default(),
            coolstep: Regulator::default(),
            temperature: Temperature::default(),
            coils: [CoilMonitor::default(); 2],
        }
    }

    /// Edges on the STEP input since the last [`Self::advance`], signed by DIR; they act with the next one. Positive steps
    /// turn the field from coil A towards coil B (decision: DIR's level for that is a matter of wiring).
    ///
    /// The direct mode ignores them.
    pub fn step(&mut self, steps: i32) {
        self.sequencer.step(steps);
    }

    /// What the bridges do to the coils for the next `period_s` seconds (more than 0, of the order of a chopper period).
    ///
    /// No voltage exceeds the bus. The bridges are off with an off time of 0, and after a short or at over-temperature.
    pub fn advance(&mut self, registers: &Registers, pins: &Pins, period_s: f64) -> [Terminal; 2] {
        let command = self.sequencer.advance(registers.coils);
        self.standstill.advance(command.changed, (period_s * CLOCK_HZ + 0.5) as u32);
        self.temperature.update(pins.temperature_c, &LEVELS);
        self.coolstep.follow(registers.current_scale, registers.coolstep);
        if self.off(registers) {
            return self.release(registers, pins);
        }
        self.measure_load(command, registers, pins);
        let targets_a = self.targets_a(command, registers);
        self.observe_coils(command, targets_a, registers, pins);
        if self.off(registers) {
            return self.release(registers, pins);
        }
        let (coils, [target_a, target_b]) = (pins.coils(), targets_a);
        let protected = !registers.short_protection_disabled;
        [
            chopper::terminal(target_a, coils[0], pins, protected, period_s),
            chopper::terminal(target_b, coils[1], pins, protected, period_s),
        ]
    }

    /// What the chip reports.
    #[must_use]
    pub fn status(&self) -> Status {
        let [a, b] = &self.coils;
        Status {
            stallguard_value: self.stallguard.value(),
            stall: self.stallguard.value() == 0,
            current_scale: self.coolstep.scale(),
            microstep_position: self.sequencer.position(),
            over_temperature: self.temperature.shutdown,
            over_temperature_warning: self.temperature.warning,
            short_to_ground: [a.shorted(), b.shorted()],
            open_load: [a.open_load(), b.open_load()],
            standstill: self.standstill.reached(),
        }
    }

    fn off(&self, registers: &Registers) -> bool {
        registers.off_time == 0 || self.temperature.shutdown || self.coils.iter().any(CoilMonitor::shorted)
    }

    /// All bridges off. Writing an off time of 0 clears what the coils were found to have.
    fn release(&mut self, registers: &Registers, pins: &Pins) -> [Terminal; 2] {
        if registers.off_time == 0 {
            self.coils = [CoilMonitor::default(); 2];
        }
        self.coils.iter_mut().for_each(CoilMonitor::rest);
        self.stallguard.interrupt();
        [Terminal::Floating { bus_voltage_v: pins.bus_voltage_v.max(0.0) }; 2]
    }

    fn measure_load(&mut self, command: Command, registers: &Registers, pins: &Pins) {
        if command.direction == 0 {
            return;
        }
        let peak_a = self.peak_current_a(registers);
        let settings =
            StallGuard { threshold: registers.stallguard_threshold, filter: registers.stallguard_filter };
        if let Some(reading) = self.stallguard.sample(command, peak_a, pins, settings) {
            self.coolstep.take(reading, registers.coolstep);
        }
    }

    fn observe_coils(&mut self, command: Command, targets_a: [f64; 2], registers: &Registers, pins: &Pins) {
        let measured = pins.coils().into_iter().zip(command.vector).zip(targets_a);
        for (monitor, ((coil, value), target_a)) in self.coils.iter_mut().zip(measured) {
            monitor.observe(coil.current_a, value, target_a);
            monitor.count_short(coil, !registers.short_protection_disabled);
        }
    }

    /// The current of a coil whose value is [`AMPLITUDE`].
    fn peak_current_a(&self, registers: &Registers) -> f64 {
        let scale = (f64::from(self.coolstep.scale()) + 1.0) / 32.0;
        let sense = if registers.half_scale { 0.5 } else { 1.0 };
        self.board.full_scale_rms_a * SQRT_2 * scale * sense
    }

    fn targets_a(&self, command: Command, registers: &Registers) -> [f64; 2] {
        let unit_a = self.peak_current_a(registers) / f64::from(AMPLITUDE);
        command.vector.map(|value| unit_a * f64::from(value))
    }
}
