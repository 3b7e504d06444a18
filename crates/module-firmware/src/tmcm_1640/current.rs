//! The current regulator and the field: what voltage across the phases makes the wanted current flow (§7.2).

use motion_control::foc::pi::Gains;
use motion_control::foc::svpwm;
use motion_control::foc::transform::{RotorVector, StatorVector, limit_circle};

use super::initialization::Initialization;
use super::{AxisParameter, PWM_PERIOD, Tmcm1640};

/// The largest voltage that can be commanded: Ubus/√3.
const LARGEST: i32 = 32_767;

/// √3/2 in 1/65 536.
const HALF_SQRT_3: i64 = 56_756;

impl Tmcm1640 {
    /// A control period: the regulators when they are due, and the duties for where the rotor is now.
    pub(super) fn regulate_current(&mut self) -> [u16; 3] {
        let angle = self.commutation_angle();
        if self.current_due > 0 {
            self.current_due -= 1;
        } else {
            self.current_due = self.kept_value(AxisParameter::CurrentLoopDelay).cast_unsigned().max(1) - 1;
            self.regulate_vector(self.measured(angle));
        }
        let [d, q] = self.regulation.voltage;
        let StatorVector { alpha, beta } = RotorVector { d, q }.to_stator(angle);
        svpwm::duties(alpha, beta, PWM_PERIOD)
    }

    /// The phase currents as the rotor sees them.
    fn measured(&self, angle: u16) -> RotorVector {
        StatorVector::from_phases(self.sensed.phase_currents_ma).to_rotor(angle)
    }

    /// AP 150: the current across the magnets; during an initialisation that drags the rotor, along the field.
    pub(super) fn motor_current_ma(&self) -> i32 {
        let measured = self.measured(self.commutation_angle());
        if self.drags() { measured.d } else { measured.q }
    }

    /// The length of the current's vector.
    pub(super) fn current_amplitude_ma(&self) -> i32 {
        let StatorVector { alpha, beta } = StatorVector::from_phases(self.sensed.phase_currents_ma);
        let [alpha, beta] = [alpha, beta].map(i64::from);
        let length = (alpha * alpha + beta * beta).unsigned_abs().isqrt();
        i32::try_from(length).unwrap_or(i32::MAX)
    }

    fn drags(&self) -> bool {
        self.initialization.as_ref().is_some_and(Initialization::drags)
    }

    fn regulate_vector(&mut self, measured: RotorVector) {
        let gains = Gains {
            p: self.kept_value(AxisParameter::CurrentP),
            i: self.kept_value(AxisParameter::CurrentI),
        };
        let wanted = self.wanted_current();
        let ahead = self.known_voltage(wanted.q);
        let regulation = &mut self.regulation;
        let d = regulation.current_d.tick(wanted.d.saturating_sub(measured.d), gains, LARGEST);
        let q = regulation.current_q.tick(wanted.q.saturating_sub(measured.q), gains, LARGEST);
        let limited = limit_circle(RotorVector { d, q: q.saturating_add(ahead) }, LARGEST);
        regulation.voltage = [limited.d, limited.q];
    }

    fn wanted_current(&self) -> RotorVector {
        let start_ma = || {
            let start_ma = self.kept_value(AxisParameter::StartCurrent).cast_unsigned();
            i32::try_from(start_ma).unwrap_or(i32::MAX).min(self.max_current_ma())
        };
        match &self.initialization {
            None => RotorVector { d: 0, q: self.regulation.target_current_ma },
            Some(initialization) if initialization.drags() => RotorVector { d: start_ma(), q: 0 },
            Some(_) => RotorVector { d: 0, q: start_ma() },
        }
    }

    /// The voltage that is known before it is regulated: back EMF by AP 239, and what the winding drops by AP 240, which is
    /// measured between two terminals (decision).
    fn known_voltage(&self, wanted_ma: i32) -> i32 {
        let bus_mv = i64::from(self.sensed.supply_voltage_dv).max(1) * 100;
        let speed_constant = i64::from(self.kept_value(AxisParameter::BemfConstant));
        let velocity_rpm = i64::from(self.velocity_rpm());
        let emf_mv = (velocity_rpm * 10_000).checked_div(speed_constant).unwrap_or(0);
        let resistance_mohm = i64::from(self.kept_value(AxisParameter::MotorCoilResistance));
        let drop_uv = i64::from(wanted_ma).saturating_mul(resistance_mohm);
        let drop_mv = ((drop_uv / 1000).saturating_mul(HALF_SQRT_3)) >> 16;
        let ahead = emf_mv.saturating_add(drop_mv).saturating_mul(i64::from(LARGEST)) / bus_mv;
        i32::try_from(ahead.clamp(-i64::from(LARGEST), i64::from(LARGEST))).unwrap_or(0)
    }
}
