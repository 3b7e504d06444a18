//! stealthChop: a voltage instead of a current, whose amplitude follows the current only slowly.
//!
//! PWM_SCALE_SUM = PWM_OFS_AUTO · current scale + PWM_GRAD_AUTO · 256 / TSTEP + PWM_SCALE_AUTO, 0 to 255 (datasheet,
//! "StealthChop"): what the resistance needs, what the back-EMF is expected to need, and what a regulator adds that changes
//! by at most PWM_REG / 2 in a half-wave. A motor that stands lets the chip measure what the resistance needs: the automatic
//! tuning of PWM_OFS_AUTO. Both compare the length of the current vector with the one commanded.

use super::PwmConf;

/// Steps of the amplitude; this many would be the whole supply.
pub(super) const AMPLITUDE_STEPS: f64 = 256.0;

/// How long a motor must stand for its currents to have settled (decision): 5.5 ms, some time constants of a winding.
const SETTLING_CLOCKS: u32 = 1 << 16;

/// Half-waves of a change of PWM_GRAD_AUTO: eight full steps.
const GRADIENT_HALF_WAVES: u8 = 4;

/// PWM_SCALE_AUTO's range in halves.
const LARGEST_CORRECTION: i16 = 510;

/// What the chip knows in a control period.
#[derive(Clone, Copy)]
pub(super) struct Situation {
    /// The current scale in use as a part of the full-scale current.
    pub(super) scale: f64,
    /// The length of the current vector that it stands for.
    pub(super) target_a: f64,
    /// The length that the current vector has.
    pub(super) measured_a: f64,
    pub(super) tstep: u32,
    /// Which half of the electrical period it is.
    pub(super) half_wave: bool,
    /// Whether the commanded vector turned.
    pub(super) turned: bool,
    pub(super) clocks: u32,
}

/// The amplitude and what it is made of.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct VoltageMode {
    active: bool,
    /// PWM_OFS and PWM_GRAD that the automatic values started from.
    configured: [u8; 2],
    /// PWM_OFS_AUTO.
    offset: u8,
    /// PWM_GRAD_AUTO.
    gradient: u8,
    /// PWM_SCALE_AUTO, in halves.
    correction: i16,
    /// PWM_SCALE_SUM.
    amplitude: u8,
    /// The scale that the amplitude is for.
    scale: f64,
    window: Window,
    /// Clocks since the amplitude changed at a vector that does not turn, at most those of the settling.
    still: u32,
    half_waves: u8,
}

/// What was measured in the half-wave that is not over yet.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Window {
    half_wave: bool,
    sum_a: f64,
    periods: u32,
}

impl VoltageMode {
    /// PWM_SCALE_SUM, 0 to 255; 0 while stealthChop is not in use.
    pub(super) fn amplitude(&self) -> u8 {
        if self.active { self.amplitude } else { 0 }
    }

    /// Another chopper is in use, or none.
    pub(super) fn leave(&mut self) {
        self.active = false;
    }

    /// Finds the amplitude for a control period.
    pub(super) fn advance(&mut self, situation: Situation, pwmconf: PwmConf) -> u8 {
        self.configure(pwmconf);
        if !self.active {
            self.begin(situation, pwmconf);
        }
        if situation.turned || situation.scale != self.scale {
            self.still = 0;
            self.scale = situation.scale;
        } else {
            self.still = (self.still + situation.clocks).min(SETTLING_CLOCKS);
        }
        if !pwmconf.pwm_autoscale {
            (self.offset, self.gradient, self.correction) = (pwmconf.pwm_ofs, pwmconf.pwm_grad, 0);
        } else if self.still == SETTLING_CLOCKS {
            self.tune_offset(situation);
        } else {
            self.regulate(situation, pwmconf);
        }
        self.amplitude = self.sum(situation);
        self.amplitude
    }

    /// Newly written values are what automatic tuning starts from.
    fn configure(&mut self, pwmconf: PwmConf) {
        let configured = [pwmconf.pwm_ofs, pwmconf.pwm_grad];
        if configured != self.configured {
            let [offset, gradient] = configured;
            *self = Self { configured, offset, gradient, active: false, ..Self::default() };
        }
        if !pwmconf.pwm_autograd {
            self.gradient = pwmconf.pwm_grad;
        }
    }

    /// PWM_LIM bounds the regulated amplitude. So that a PWM_OFS that fits no motor makes no jerk either, it bounds that too
    /// as long as it has not been tuned (decision).
    fn begin(&mut self, situation: Situation, pwmconf: PwmConf) {
        let limit = pwmconf.pwm_lim.min(15) * 16 + 15;
        if pwmconf.pwm_autoscale && self.offset == pwmconf.pwm_ofs {
            self.offset = self.offset.min(limit);
        }
        self.correction = self.correction.min(i16::from(limit) * 2);
        self.window = Window { half_wave: situation.half_wave, ..Window::default() };
        (self.active, self.still, self.half_waves) = (true, 0, 0);
    }

    /// The motor stands and its currents have settled: they are the voltage through the resistance.
    fn tune_offset(&mut self, situation: Situation) {
        self.window = Window { half_wave: situation.half_wave, ..Window::default() };
        let wanted = libm::round(self.wanted(situation));
        if situation.target_a <= 0.0 || wanted == f64::from(self.amplitude) {
            return;
        }
        let offset = libm::round(wanted / situation.scale).clamp(0.0, 255.0) as u8;
        if offset != self.offset || self.correction != 0 {
            (self.offset, self.correction, self.still) = (offset, 0, 0);
        }
    }

    /// A turning motor: once in a half-wave the correction goes a little into the direction that is needed.
    fn regulate(&mut self, situation: Situation, pwmconf: PwmConf) {
        self.window.sum_a += situation.measured_a;
        self.window.periods += 1;
        if situation.half_wave == self.window.half_wave {
            return;
        }
        let measured_a = self.window.sum_a / f64::from(self.window.periods);
        self.window = Window { half_wave: situation.half_wave, ..Window::default() };
        let error = self.wanted(Situation { measured_a, ..situation }) - f64::from(self.amplitude);
        let most = f64::from(pwmconf.pwm_reg.clamp(1, 15));
        let halves = error.clamp(-most, most) as i16;
        // What no amplitude could follow is not summed up.
        let [room_down, room_up] = [0 - i16::from(self.amplitude), 255 - i16::from(self.amplitude)];
        self.correction = (self.correction + halves.clamp(2 * room_down, 2 * room_up))
            .clamp(-LARGEST_CORRECTION, LARGEST_CORRECTION);
        if pwmconf.pwm_autograd {
            self.tune_gradient(situation);
        }
    }

    /// The amplitude that would bring the current to its target if it were proportional, within a factor of four or two.
    fn wanted(&self, Situation { target_a, measured_a, .. }: Situation) -> f64 {
        let amplitude = f64::from(self.amplitude).max(0.5);
        let (least, most) = (amplitude / 4.0, amplitude * 2.0 + 1.0);
        let wanted = if measured_a > 0.0 { amplitude * target_a / measured_a } else { most };
        wanted.clamp(least, most).min(255.0)
    }

    /// Where the back-EMF takes a good part of the amplitude, the gradient takes over from the correction.
    fn tune_gradient(&mut self, situation: Situation) {
        self.half_waves = (self.half_waves + 1) % GRADIENT_HALF_WAVES;
        let (amplitude, offset) = (f64::from(self.amplitude), f64::from(self.offset) * situation.scale);
        if self.half_waves != 0 || amplitude <= 1.5 * offset || amplitude >= (4.0 * offset).min(255.0) {
            return;
        }
        let before = self.gradient;
        self.gradient = match self.correction {
            2.. => before.saturating_add(1),
            ..=-2 => before.saturating_sub(1),
            _ => before,
        };
        let taken = (i16::from(self.gradient) - i16::from(before)) as f64 * per_gradient(situation.tstep);
        self.correction -= libm::round(2.0 * taken) as i16;
    }

    fn sum(&self, situation: Situation) -> u8 {
        let offset = f64::from(self.offset) * situation.scale;
        let gradient = f64::from(self.gradient) * per_gradient(situation.tstep);
        libm::round(offset + gradient + f64::from(self.correction) / 2.0).clamp(0.0, 255.0) as u8
    }
}

/// What a PWM_GRAD of 1 adds to the amplitude.
fn per_gradient(tstep: u32) -> f64 {
    256.0 / f64::from(tstep.max(1))
}
