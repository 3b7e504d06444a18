//! The TMCM-1640: one axis for a brushless motor, field-oriented control, hall sensors and encoder.
//!
//! A control period finds out where the rotor is ([`angles`]), whether the power stage may be on ([`protection`]), what velocity
//! and current are wanted ([`cascade`]), and what voltage makes that current flow ([`current`]).

mod angles;
mod cascade;
mod current;
mod exchange;
mod initialization;
mod motion;
mod parameters;
mod ports;
mod protection;
mod switches;
mod velocity;

use motion_control::foc::hall::HallTracker;
use motion_control::foc::pi::Pi;
use motion_control::foc::speed::{EncoderTachometer, HallTachometer};
use motion_control::foc::velocity_ramp::VelocityRamp;
use motion_control::i2t::I2t;
pub use tmcl_tables::tmcm_1640::{AxisParameter, Port};
use tmcl_tables::{Interrupt, ModuleSpec, tmcm_1640 as tables};
use tmcl_vm::WaitEvent;

use crate::axis::{Axis, Motion, Refused};
use crate::events::Events;
use crate::program_memory::Programs;
use crate::values::Values;
use crate::{TICKS_PER_MS, TICKS_PER_SECOND};
use angles::EncoderAngle;
pub use exchange::{Drive, PWM_PERIOD, Sensed};
use initialization::Initialization;
use protection::Protection;

/// What the motor shall do (§7.1; AP 156 bits 9 to 11).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum RegulationMode {
    Torque,
    Velocity,
    Position,
}

/// Control periods in the minute of AP 30.
const TICKS_PER_MINUTE: u64 = 60 * TICKS_PER_SECOND;

/// What regulates, and what it came to: whatever changes while the motor is not at rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Regulation {
    ramp: VelocityRamp,
    velocity: Pi,
    current_q: Pi,
    current_d: Pi,
    /// AP 155: what the current regulator drives at.
    target_current_ma: i32,
    /// Voltage along and across the rotor's magnets, ±32 767 for Ubus/√3.
    voltage: [i32; 2],
    /// AP 226.
    position_error: i32,
    /// Flag 14.
    position_reached: bool,
}

/// The axis.
#[derive(Clone, Debug)]
pub struct Tmcm1640 {
    /// Parameters that are what was written to them.
    kept: Values<{ AxisParameter::COUNT }>,
    mode: RegulationMode,
    target_position: i32,
    target_velocity: i32,
    /// AP 1, in encoder counts or hall sectors, as AP 159 says.
    position: i32,
    /// Encoder counts or hall sectors that were taken into account.
    counted: i32,
    encoder: EncoderAngle,
    halls: HallTracker,
    encoder_speed: EncoderTachometer,
    hall_speed: HallTachometer,
    initialization: Option<Initialization>,
    regulation: Regulation,
    protection: Protection,
    i2t: I2t,
    /// Control periods until the current regulator is due, and until position and velocity regulators are.
    current_due: u32,
    velocity_due: u32,
    /// Control periods in which nothing changed.
    calm_ticks: u64,
    /// Control periods of the minute that runs (AP 30).
    minute_ticks: u64,
    switches_before: [bool; 2],
    sensed: Sensed,
    output: bool,
}

impl Default for Tmcm1640 {
    fn default() -> Self {
        let mut kept = Values::zero();
        for parameter in AxisParameter::ALL {
            kept.set(parameter.index(), parameter.spec().default_bits());
        }
        let i2t = I2t::new(protection::window_ticks(&kept));
        Self {
            kept,
            mode: RegulationMode::Velocity,
            target_position: 0,
            target_velocity: 0,
            position: 0,
            counted: 0,
            encoder: EncoderAngle::default(),
            halls: HallTracker::new(),
            encoder_speed: EncoderTachometer::new(0),
            hall_speed: HallTachometer::new(0),
            initialization: None,
            regulation: Regulation::default(),
            protection: Protection::default(),
            i2t,
            current_due: 0,
            velocity_due: 0,
            calm_ticks: 0,
            minute_ticks: 0,
            switches_before: [false; 2],
            sensed: Sensed::default(),
            output: false,
        }
    }
}

impl Axis for Tmcm1640 {
    const SPEC: &'static ModuleSpec = &tables::SPEC;
    type Parameter = AxisParameter;
    type Port = Port;
    type Sensed = Sensed;
    type Drive = Drive;
    type Programs = Programs<{ tables::SPEC.program_memory as usize }>;

    fn is_idle(&self, sensed: &Sensed) -> bool {
        self.sensed == *sensed && self.calm_ticks > self.longest_interval() && self.quiet_ticks() > 0
    }

    fn quiet_ticks(&self) -> u64 {
        let minute = TICKS_PER_MINUTE.saturating_sub(self.minute_ticks + 1);
        minute.min(self.i2t.quiet_ticks(self.current_square(), self.i2t_limit()))
    }

    fn skip(&mut self, ticks: u64) {
        self.minute_ticks += ticks;
        self.calm_ticks = self.calm_ticks.saturating_add(ticks);
        self.i2t.skip(ticks, self.current_square(), self.i2t_limit());
        self.current_due = later(self.current_due, ticks, self.current_interval());
        self.velocity_due = later(self.velocity_due, ticks, self.velocity_interval());
    }

    fn tick(&mut self, sensed: &Sensed, events: &mut Events) -> Drive {
        let before = self.snapshot();
        events.alarm = sensed.driver_error && !self.sensed.driver_error;
        self.sensed = *sensed;
        self.count_minutes(events);
        self.follow_sensors();
        self.clear_on_switch();
        self.watch();
        let drive = self.drive();
        let measured = self.encoder_speed.is_at_rest() && self.hall_speed.is_at_rest();
        let calm = measured && before == self.snapshot();
        self.calm_ticks = if calm { self.calm_ticks.saturating_add(1) } else { 0 };
        drive
    }

    fn get(&self, parameter: AxisParameter) -> i32 {
        self.parameter(parameter)
    }

    fn set(&mut self, parameter: AxisParameter, value: i32) -> Result<(), Refused> {
        self.calm_ticks = 0;
        self.set_parameter(parameter, value)
    }

    fn motion(&mut self, motion: Motion) -> Result<(), Refused> {
        self.calm_ticks = 0;
        match motion {
            Motion::Rotate(velocity_rpm) => self.turn(velocity_rpm),
            Motion::Stop => self.turn(0),
            Motion::MoveTo(position) => self.move_to(position),
            // Relative to where the motor is (§4.6.4).
            Motion::MoveBy(offset) => self.move_to(self.position.wrapping_add(offset)),
        }
        Ok(())
    }

    /// The TMCM-1640 has no reference search: the tables keep RFS away.
    fn start_search(&mut self) -> Result<(), Refused> {
        Err(Refused::NotAvailable)
    }

    fn stop_search(&mut self) {}

    fn search_state(&self) -> i32 {
        0
    }

    fn actual_position(&self) -> i32 {
        self.position
    }

    fn is_position_reached(&self) -> bool {
        self.regulation.position_reached
    }

    fn has_happened(&self, event: WaitEvent) -> bool {
        match event {
            WaitEvent::PositionReached => self.regulation.position_reached,
            WaitEvent::ReferenceSwitch | WaitEvent::LimitSwitch => {
                self.active_switches().into_iter().any(|active| active)
            }
            WaitEvent::ReferenceSearch => true,
        }
    }

    /// The TMCM-1640 has no interrupts.
    fn level(&self, _: Interrupt) -> bool {
        false
    }

    /// It has AP 166 instead of the global parameter.
    fn set_end_switch_polarity(&mut self, _: bool) {}

    fn port(bank: u8, number: u8) -> Option<Port> {
        Port::from_address(bank, number)
    }

    fn read_port(&self, port: Port) -> i32 {
        self.port_level(port)
    }

    fn write_port(&mut self, port: Port, high: bool) {
        self.set_port(port, high);
    }
}

impl Tmcm1640 {
    /// What the power stage shall do.
    fn drive(&mut self) -> Drive {
        if !self.may_drive() {
            self.interrupt_initialization();
            self.reset_regulation();
            self.judge_position(self.velocity_rpm());
            return Drive { duties: [0; 3], enabled: false, output: self.output };
        }
        if self.initialization.is_some() {
            self.initialize_on();
            // It turns the motor, away from a target too.
            self.judge_position(self.velocity_rpm());
        } else {
            self.regulate_motion();
        }
        Drive { duties: self.regulate_current(), enabled: true, output: self.output }
    }

    /// AP 30: the minute is stored, so that it is there after power-on.
    fn count_minutes(&mut self, events: &mut Events) {
        self.minute_ticks += 1;
        if self.minute_ticks >= TICKS_PER_MINUTE {
            self.minute_ticks = 0;
            let counter = AxisParameter::MinuteCounter;
            self.kept.set(counter.index(), self.kept_value(counter).wrapping_add(1));
            events.store = Some(counter.number());
        }
    }

    /// Whatever changes while the motor is not at rest.
    fn snapshot(&self) -> (Regulation, Option<Initialization>, Protection, HallTracker, i32) {
        (self.regulation, self.initialization, self.protection, self.halls, self.position)
    }

    fn current_interval(&self) -> u32 {
        self.kept_value(AxisParameter::CurrentLoopDelay).cast_unsigned().max(1)
    }

    fn velocity_interval(&self) -> u32 {
        self.velocity_interval_ms().saturating_mul(TICKS_PER_MS as u32)
    }

    /// So long nothing has to change for nothing to change any more.
    fn longest_interval(&self) -> u64 {
        u64::from(self.current_interval()) + u64::from(self.velocity_interval())
    }

    fn kept_value(&self, parameter: AxisParameter) -> i32 {
        self.kept.get(parameter.index())
    }
}

/// A countdown that starts anew from `interval` − 1 whenever it is over, `ticks` later.
fn later(due: u32, ticks: u64, interval: u32) -> u32 {
    match u64::from(due).checked_sub(ticks) {
        Some(left) => left as u32, // no more than it was
        None => {
            let beyond = (ticks - u64::from(due) - 1).checked_rem(interval.into()).unwrap_or(0);
            interval - 1 - beyond as u32 // less than the interval
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_countdown_skips_as_it_counts() {
        for interval in [1, 2, 7, 20] {
            let mut due = 3;
            for ticks in 0..100 {
                assert_eq!(later(3, ticks, interval), due, "{ticks} of {interval}");
                due = if due > 0 { due - 1 } else { interval - 1 };
            }
        }
    }
}
