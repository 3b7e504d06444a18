//! The TMCM-1076: a stepper driver that follows step and direction pulses. It has no motion controller and no programs; its
//! firmware keeps the registers of a TMC5160 and watches two inputs (TMCM-1076 §4, §5).

mod exchange;
mod parameters;
mod registers;

pub use tmcl_tables::tmcm_1076::{AxisParameter, Port};
use tmcl_tables::{Interrupt, ModuleSpec, tmcm_1076 as tables};
use tmcl_vm::WaitEvent;

use crate::axis::{Axis, Motion, Refused};
use crate::events::Events;
use crate::program_memory::Programs;
use crate::values::Values;
pub use exchange::{Drive, STANDSTILL_TSTEP, Sensed};
use registers::SharedRegister;

/// The axis.
#[derive(Clone, Debug)]
pub struct Tmcm1076 {
    /// Parameters that are what was written to them.
    kept: Values<{ AxisParameter::COUNT }>,
    coolconf: SharedRegister,
    /// Without its microstep resolution, which only AP 140 sets.
    chopconf: SharedRegister,
    /// stealthChop was chosen at a standstill and not given up since (§5.1).
    stealthchop: bool,
    /// Something was set since the last control period.
    touched: bool,
    sensed: Sensed,
}

impl Default for Tmcm1076 {
    fn default() -> Self {
        let mut kept = Values::zero();
        for parameter in AxisParameter::ALL {
            kept.set(parameter.index(), parameter.spec().default_bits());
        }
        Self {
            kept,
            coolconf: registers::factory_coolconf(),
            chopconf: registers::factory_chopconf(),
            stealthchop: false,
            touched: false,
            sensed: Sensed::default(),
        }
    }
}

impl Axis for Tmcm1076 {
    const SPEC: &'static ModuleSpec = &tables::SPEC;
    type Parameter = AxisParameter;
    type Port = Port;
    type Sensed = Sensed;
    type Drive = Drive;
    type Programs = Programs<{ tables::SPEC.program_memory as usize }>;

    fn tick(&mut self, sensed: &Sensed, _: &mut Events) -> Drive {
        self.sensed = *sensed;
        self.touched = false;
        self.choose_chopper();
        self.drive()
    }

    fn is_idle(&self, sensed: &Sensed) -> bool {
        self.sensed == *sensed && !self.touched
    }

    fn quiet_ticks(&self) -> u64 {
        u64::MAX
    }

    fn skip(&mut self, _: u64) {}

    fn get(&self, parameter: AxisParameter) -> i32 {
        self.parameter(parameter)
    }

    fn set(&mut self, parameter: AxisParameter, value: i32) -> Result<(), Refused> {
        self.touched = true;
        self.set_parameter(parameter, value);
        Ok(())
    }

    fn restore(&mut self, parameter: AxisParameter, stored: Option<i32>, default: i32) {
        self.touched = true;
        self.restore_parameter(parameter, stored, default);
    }

    /// What is not stored stays as the factory made it: a default must not overwrite what a stored register says.
    fn restore_at_power_on(&mut self, parameter: AxisParameter, stored: Option<i32>, default: i32) {
        if stored.is_some() {
            self.restore(parameter, stored, default);
        }
    }

    /// The pulses move it, nothing else: the tables keep motion commands away.
    fn motion(&mut self, _: Motion) -> Result<(), Refused> {
        Err(Refused::NotAvailable)
    }

    fn start_search(&mut self) -> Result<(), Refused> {
        Err(Refused::NotAvailable)
    }

    fn stop_search(&mut self) {}

    fn search_state(&self) -> i32 {
        0
    }

    fn actual_position(&self) -> i32 {
        0
    }

    fn is_position_reached(&self) -> bool {
        false
    }

    fn has_happened(&self, _: WaitEvent) -> bool {
        true
    }

    fn level(&self, _: Interrupt) -> bool {
        false
    }

    fn set_end_switch_polarity(&mut self, _: bool) {}

    fn port(bank: u8, number: u8) -> Option<Port> {
        Port::from_address(bank, number)
    }

    fn read_port(&self, port: Port) -> i32 {
        i32::from(match port {
            Port::In0 => self.sensed.chop,
            Port::In1 => self.sensed.enable,
        })
    }

    /// It has no outputs.
    fn write_port(&mut self, _: Port, _: bool) {}
}

impl Tmcm1076 {
    /// §5.1: spreadCycle as soon as CHOP is low; stealthChop once CHOP is high while the motor is powered and stands.
    fn choose_chopper(&mut self) {
        let Sensed { chop, enable, standstill, .. } = self.sensed;
        self.stealthchop = chop && (self.stealthchop || (!enable && standstill));
    }

    /// What the driver's registers hold.
    fn drive(&self) -> Drive {
        use AxisParameter as P;
        let byte = |parameter| self.kept_value(parameter) as u8; // the ranges are those of bytes
        Drive {
            enabled: !self.sensed.enable,
            stealthchop: self.stealthchop,
            irun: byte(P::MaxCurrent),
            ihold: byte(P::StandbyCurrent),
            iholddelay: byte(P::StandbyCurrentDelay),
            tpwmthrs: self.kept_value(P::StealthchopVelocityLimit).cast_unsigned(),
            tcoolthrs: self.kept_value(P::CoolstepThresholdVelocity).cast_unsigned(),
            thigh: self.kept_value(P::HighVelocityThreshold).cast_unsigned(),
            chopconf: registers::with_resolution(self.chopconf.effective(), byte(P::MicrostepResolution)),
            coolconf: self.coolconf.effective(),
            pwmconf: self.kept_value(P::Pwmconf).cast_unsigned(),
        }
    }

    fn kept_value(&self, parameter: AxisParameter) -> i32 {
        self.kept.get(parameter.index())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tick(axis: &mut Tmcm1076, chop: bool, enable: bool, standstill: bool) -> Drive {
        let sensed = Sensed { chop, enable, standstill, ..Sensed::default() };
        axis.tick(&sensed, &mut Events::default())
    }

    #[test]
    fn stealthchop_begins_at_a_powered_standstill_only_and_ends_at_once() {
        let mut axis = Tmcm1076::default();
        for (chop, enable, standstill, stealthchop) in [
            (true, false, false, false),
            (true, true, true, false),
            (true, false, true, true),
            (true, false, false, true),
            (true, true, false, true),
            (false, false, false, false),
            (true, false, false, false),
        ] {
            let drive = tick(&mut axis, chop, enable, standstill);
            assert_eq!(drive.stealthchop, stealthchop, "CHOP {chop}, ENABLE {enable}, standing {standstill}");
            assert_eq!(drive.enabled, !enable, "ENABLE is low active");
        }
    }

    #[test]
    fn the_factory_settings_become_registers() {
        let drive = tick(&mut Tmcm1076::default(), false, false, true);
        let expected = Drive {
            enabled: true,
            stealthchop: false,
            irun: 24,
            ihold: 3,
            iholddelay: 0,
            tpwmthrs: 0,
            tcoolthrs: 0,
            thigh: 0,
            chopconf: 33_011 | 4 << 24 | 1 << 28,
            coolconf: 0,
            pwmconf: 328_136,
        };
        assert_eq!(drive, expected);
    }

    #[test]
    fn every_parameter_reaches_its_field() {
        use AxisParameter as P;
        let mut axis = Tmcm1076::default();
        for (parameter, value) in [
            (P::MaxCurrent, 31),
            (P::StandbyCurrent, 0),
            (P::StandbyCurrentDelay, 15),
            (P::HighVelocityThreshold, 22),
            (P::StealthchopVelocityLimit, 1_048_575),
            (P::CoolstepThresholdVelocity, 182),
            (P::Pwmconf, -1),
            (P::MicrostepResolution, 8),
            (P::MicrostepInterpolation, 0),
            (P::DoubleEdgeSteps, 1),
            (P::CoolstepMinCurrent, 1),
            (P::CoolstepDownStep, 2),
            (P::CoolstepHysteresis, 15),
            (P::CoolstepUpStep, 1),
            (P::CoolstepHysteresisStart, 9),
            (P::Stallguard2Filter, 1),
            (P::Stallguard2Threshold, -64),
        ] {
            axis.set(parameter, value).expect("in range");
            assert_eq!(axis.get(parameter), value);
        }
        let drive = tick(&mut axis, false, false, true);
        let expected = Drive {
            enabled: true,
            stealthchop: false,
            irun: 31,
            ihold: 0,
            iholddelay: 15,
            tpwmthrs: 1_048_575,
            tcoolthrs: 182,
            thigh: 22,
            chopconf: 33_011 | 1 << 29,
            coolconf: 9 | 1 << 5 | 15 << 8 | 2 << 13 | 1 << 15 | 0x40 << 16 | 1 << 24,
            pwmconf: u32::MAX,
        };
        assert_eq!(drive, expected);
    }
}
