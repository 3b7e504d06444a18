//! The chip: its parts in the order in which a control period passes through them.

use core::f64::consts::SQRT_2;

use motor_physics::Terminal;

use super::current::RunOrHold;
use super::sequencer::{CLOCK_HZ, Edges, Sequencer};
use super::stealthchop::{AMPLITUDE_STEPS, Situation, VoltageMode};
use super::velocity::Velocity;
use super::{CoolStep, Pins, Registers, Status};
use crate::stepper::chopper;
use crate::stepper::coil::CoilMonitor;
use crate::stepper::coolstep::Regulator;
use crate::stepper::stallguard::{Measurement, StallGuard};
use crate::stepper::table::{AMPLITUDE, Command};
use crate::stepper::temperature::{Levels, Temperature};

/// Datasheet, OTSELECT = 0: switched on again below the pre-warning, which has no hysteresis.
const LEVELS: Levels =
    Levels { warning_c: 120.0, warning_end_c: 120.0, shutdown_c: 150.0, shutdown_end_c: 120.0 };

/// What the board makes of the chip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Board {
    /// The RMS coil current at a current scale of 31, which the sense resistors set: 3 A on the TMCM-1076.
    pub full_scale_rms_a: f64,
    /// The part of it that a current scale of 0 makes; between them it is linear. The datasheet has 1/32.
    pub lowest_scale: f64,
}

impl Board {
    fn scale(&self, current_scale: u8, registers: &Registers) -> f64 {
        let part = self.lowest_scale + (1.0 - self.lowest_scale) * f64::from(current_scale) / 31.0;
        match registers.global_scaler {
            0 => part,
            scaler => part * f64::from(scaler) / 256.0,
        }
    }
}

/// What comes in from outside in a control period.
#[derive(Clone, Copy, Debug)]
pub struct Inputs<'a> {
    /// What the chip sees of bridges and coils.
    pub pins: &'a Pins,
    /// DRV_ENN is low: the bridges may be on.
    pub enabled: bool,
    /// What came on the step input in this period, in the order of time.
    pub edges: &'a [Edges],
}

/// A TMC5160.
///
/// With unchanging registers and pins and without steps its state comes to rest bit for bit: [`Self::advance`] then leaves it
/// as it is and returns the same again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tmc5160 {
    board: Board,
    sequencer: Sequencer,
    velocity: Velocity,
    current: RunOrHold,
    stallguard: Measurement,
    /// Whether the last reading still says something.
    stallguard_valid: bool,
    coolstep: Regulator,
    stealthchop: VoltageMode,
    stealth: bool,
    fsactive: bool,
    temperature: Temperature,
    coils: [CoilMonitor; 2],
    mscnt: u16,
    mscuract: [i16; 2],
}

impl Tmc5160 {
    /// The chip after power-on.
    #[must_use]
    pub fn new(board: Board) -> Self {
        Self {
            board,
            sequencer: Sequencer::default(),
            velocity: Velocity::default(),
            current: RunOrHold::default(),
            stallguard: Measurement::default(),
            stallguard_valid: false,
            coolstep: Regulator::default(),
            stealthchop: VoltageMode::default(),
            stealth: false,
            fsactive: false,
            temperature: Temperature::default(),
            coils: [CoilMonitor::default(); 2],
            mscnt: 0,
            mscuract: [0; 2],
        }
    }

    /// What the bridges do to the coils for the next `period_s` seconds (more than 0, of the order of a chopper period), in
    /// which the steps of `inputs` fall. It costs the same for any number of edges in a burst.
    ///
    /// No voltage exceeds the bus. The bridges are off while the driver is not enabled, with an off time of 0, and after a
    /// short or at over-temperature; steps are counted all the same.
    pub fn advance(&mut self, registers: &Registers, inputs: Inputs<'_>, period_s: f64) -> [Terminal; 2] {
        let clocks = (period_s * CLOCK_HZ + 0.5) as u32;
        let pins = inputs.pins;
        self.sequencer.count(inputs.edges, registers.chopconf, registers.gconf.shaft, clocks);
        self.velocity.compare(self.sequencer.tstep(), registers);
        self.stealth = registers.gconf.en_pwm_mode && self.velocity.stealthchop();
        self.fsactive = registers.chopconf.vhighfs && self.velocity.high();
        let command = self.sequencer.command(registers.chopconf, self.fsactive);
        self.mscnt = self.sequencer.position(registers.chopconf);
        self.mscuract = command.vector;
        self.current.advance(self.sequencer.stands(), registers, clocks);
        self.coolstep.follow(self.current.scale(), self.coolstep_settings(registers));
        self.temperature.update(pins.temperature_c, &LEVELS);
        if self.off(registers, inputs.enabled) {
            return self.release(registers, inputs);
        }
        self.measure_load(command, registers, pins);
        self.observe_coils(command, registers, pins);
        if self.off(registers, inputs.enabled) {
            return self.release(registers, inputs);
        }
        if self.stealth {
            self.voltages(command, registers, pins, clocks)
        } else {
            self.stealthchop.leave();
            self.regulated(command, registers, pins, period_s)
        }
    }

    /// What the chip reports.
    #[must_use]
    pub fn status(&self) -> Status {
        let [a, b] = &self.coils;
        let sg_result = if self.stallguard_valid { self.stallguard.value() } else { 0 };
        Status {
            sg_result,
            stallguard: self.stallguard_valid && sg_result == 0,
            cs_actual: self.coolstep.scale(),
            stealth: self.stealth,
            fsactive: self.fsactive,
            ot: self.temperature.shutdown,
            otpw: self.temperature.warning,
            s2g: [a.shorted(), b.shorted()],
            ol: [a.open_load(), b.open_load()],
            stst: self.sequencer.stands(),
            tstep: self.sequencer.tstep(),
            mscnt: self.mscnt,
            mscuract: self.mscuract,
            pwm_scale_sum: self.stealthchop.amplitude(),
        }
    }

    fn off(&self, registers: &Registers, enabled: bool) -> bool {
        !enabled
            || registers.chopconf.toff == 0
            || self.temperature.shutdown
            || self.coils.iter().any(CoilMonitor::shorted)
    }

    /// All bridges off. Disabling the driver clears what the coils were found to have.
    fn release(&mut self, registers: &Registers, inputs: Inputs<'_>) -> [Terminal; 2] {
        if !inputs.enabled || registers.chopconf.toff == 0 {
            self.coils = [CoilMonitor::default(); 2];
        }
        self.coils.iter_mut().for_each(CoilMonitor::rest);
        self.forget_load();
        self.stealthchop.leave();
        [Terminal::Floating { bus_voltage_v: inputs.pins.bus_voltage_v.max(0.0) }; 2]
    }

    /// coolStep works in its window of velocities, with spreadCycle.
    fn coolstep_settings(&self, registers: &Registers) -> CoolStep {
        let works = self.velocity.coolstep() && self.current.runs();
        if works { registers.coolconf.coolstep() } else { CoolStep::default() }
    }

    fn measure_load(&mut self, command: Command, registers: &Registers, pins: &Pins) {
        if self.stealth || !self.velocity.stallguard() {
            self.forget_load();
            return;
        }
        if command.direction == 0 {
            return;
        }
        let settings = StallGuard { threshold: registers.coolconf.sgt, filter: registers.coolconf.sfilt };
        let peak_a = self.peak_current_a(registers);
        if let Some(reading) = self.stallguard.sample(command, peak_a, pins, settings) {
            self.stallguard_valid = true;
            self.coolstep.take(reading, self.coolstep_settings(registers));
        }
    }

    fn forget_load(&mut self) {
        self.stallguard_valid = false;
        self.stallguard.interrupt();
    }

    fn observe_coils(&mut self, command: Command, registers: &Registers, pins: &Pins) {
        let targets_a = self.targets_a(command, registers);
        let measured = pins.coils().into_iter().zip(command.vector).zip(targets_a);
        for (monitor, ((coil, value), target_a)) in self.coils.iter_mut().zip(measured) {
            if self.stealth {
                monitor.rest();
            } else {
                monitor.observe(coil.current_a, value, target_a);
            }
            monitor.count_short(coil, !registers.chopconf.diss2g);
        }
    }

    /// spreadCycle: the currents follow their targets.
    fn regulated(
        &self,
        command: Command,
        registers: &Registers,
        pins: &Pins,
        period_s: f64,
    ) -> [Terminal; 2] {
        let ([a, b], [target_a, target_b]) = (pins.coils(), self.targets_a(command, registers));
        let protected = !registers.chopconf.diss2g;
        [
            chopper::terminal(target_a, a, pins, protected, period_s),
            chopper::terminal(target_b, b, pins, protected, period_s),
        ]
    }

    /// stealthChop: voltages of the amplitude in use, in the mean direction of the period.
    fn voltages(
        &mut self,
        command: Command,
        registers: &Registers,
        pins: &Pins,
        clocks: u32,
    ) -> [Terminal; 2] {
        let holds_nothing = !self.current.runs() && registers.ihold_irun.ihold == 0;
        let freewheel = if holds_nothing { registers.pwmconf.freewheel } else { 0 };
        if freewheel == 1 {
            self.stealthchop.leave();
            return [Terminal::Floating { bus_voltage_v: pins.bus_voltage_v.max(0.0) }; 2];
        }
        let [i_a, i_b] = pins.currents_a;
        let situation = Situation {
            scale: self.board.scale(self.coolstep.scale(), registers),
            target_a: self.peak_current_a(registers),
            measured_a: libm::sqrt(i_a * i_a + i_b * i_b),
            tstep: self.sequencer.tstep(),
            half_wave: self.mscnt >= 512,
            turned: command.changed,
            clocks,
        };
        let amplitude = self.stealthchop.advance(situation, registers.pwmconf);
        let amplitude = if freewheel == 0 { f64::from(amplitude) } else { 0.0 };
        // The largest value of the table drives with 248/256 of what the amplitude says.
        let unit_v = pins.bus_voltage_v.max(0.0) * amplitude / AMPLITUDE_STEPS / AMPLITUDE_STEPS / 2.0;
        let ([a, b], [now_a, now_b], [before_a, before_b]) = (pins.coils(), command.vector, command.before);
        let protected = !registers.chopconf.diss2g;
        [
            chopper::bridge(unit_v * f64::from(now_a + before_a), a, pins, protected),
            chopper::bridge(unit_v * f64::from(now_b + before_b), b, pins, protected),
        ]
    }

    /// The current of a coil whose value is [`AMPLITUDE`].
    fn peak_current_a(&self, registers: &Registers) -> f64 {
        self.board.full_scale_rms_a * SQRT_2 * self.board.scale(self.coolstep.scale(), registers)
    }

    fn targets_a(&self, command: Command, registers: &Registers) -> [f64; 2] {
        let unit_a = self.peak_current_a(registers) / f64::from(AMPLITUDE);
        command.vector.map(|value| unit_a * f64::from(value))
    }
}
