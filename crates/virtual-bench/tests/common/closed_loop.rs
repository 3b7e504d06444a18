//! Closed loop: how it is begun, moved and judged by where the shaft really is.

use std::ops::{Deref, DerefMut};

use motor_physics::presets;
use tmcl_tables::Command;
use tmcl_tables::tmcm_1311::AxisParameter as Ap;

use super::{Module, TURN};

/// The longest that an initialisation may take, in control periods: 1.3 s.
pub(crate) const INIT_TICKS: u64 = 26_000;

/// The motor of the default bench.
pub(crate) const MOTOR: &str = "QSH5718-51-28-101";

/// Every stepper preset, and the AP 6 that is just below its rated current.
pub(crate) const MOTORS: [(&str, i32); 4] =
    [("QSH4218-35-10-027", 79), ("QSH4218-51-10-049", 79), (MOTOR, 231), ("QSH5718-76-28-189", 231)];

/// Bits of AP 18.
pub(crate) mod bit {
    pub(crate) const REACHED: u8 = 0;
    pub(crate) const VELOCITY_REACHED: u8 = 1;
    pub(crate) const CLOSED_LOOP: u8 = 2;
    pub(crate) const POSITION: u8 = 3;
    pub(crate) const VELOCITY: u8 = 4;
    pub(crate) const TORQUE: u8 = 5;
    pub(crate) const HOLD: u8 = 12;
}

/// A bench file; `load` is what stands in `[module.load]`, other sections may follow.
pub(crate) fn bench(motor: &str, counts: i32, load: &str) -> String {
    format!(
        "[[module]]\nkind = \"tmcm-1311\"\n[module.motor]\npreset = \"{motor}\"\n\
         [module.encoder]\ncounts = {counts}\n[module.load]\n{load}\n"
    )
}

/// The RMS current that a setting of AP 6 stands for (decisions 5.7).
pub(crate) fn rms_a(setting: i32) -> f64 {
    3.0 * f64::from(setting / 8 + 1) / 32.0
}

/// The torque of a field 90° ahead of the rotor with this RMS current: Km · √2 · I.
pub(crate) fn full_torque_nm(motor: &str, rms_a: f64) -> f64 {
    presets::stepper(motor).expect("a preset").motor_constant() * std::f64::consts::SQRT_2 * rms_a
}

/// Length of the current vector that flows.
pub(crate) fn amplitude_a(module: &Module) -> f64 {
    let physical = module.physical();
    physical.coil_a_a.hypot(physical.coil_b_a)
}

/// How far the rotor is from a field at 0°, in electrical degrees: -180 to 180.
pub(crate) fn electrical_deg(module: &Module) -> f64 {
    let periods = module.turns() * 50.0;
    (periods - periods.round()) * 360.0
}

/// SAP 129, 1, and virtual time until AP 133 is set. Returns the control periods that took; None: it failed, as AP 129 says.
#[track_caller]
pub(crate) fn try_initialize(module: &mut Module) -> Option<u64> {
    module.sap(Ap::ClosedLoopMode, 1);
    for ticks in 0..=INIT_TICKS {
        if module.gap(Ap::ClosedLoopInitialized) == 1 {
            return Some(ticks);
        }
        if ticks > 0 && module.gap(Ap::ClosedLoopMode) == 0 {
            return None;
        }
        module.run_ticks(1);
    }
    panic!("AP 133 is 0 and AP 129 is 1 after 1.3 s: neither initialised nor failed")
}

/// An axis in closed loop, and where its shaft stands when AP 1 is 0.
#[derive(Clone, Debug)]
pub(crate) struct Axis {
    pub(crate) module: Module,
    /// Turns of the rotor at AP 1 = 0.
    pub(crate) zero_turns: f64,
    /// Encoder steps in a turn.
    pub(crate) counts: f64,
}

impl Deref for Axis {
    type Target = Module;

    fn deref(&self) -> &Module {
        &self.module
    }
}

impl DerefMut for Axis {
    fn deref_mut(&mut self) -> &mut Module {
        &mut self.module
    }
}

impl Axis {
    /// The default bench in closed loop, at two turns a second and ten a second squared at most, with these settings.
    #[track_caller]
    pub(crate) fn new(settings: &[(Ap, i32)]) -> Self {
        Self::on(&bench(MOTOR, 40_000, ""), 40_000, settings)
    }

    /// The same on another bench.
    #[track_caller]
    pub(crate) fn on(bench_file: &str, counts: i32, settings: &[(Ap, i32)]) -> Self {
        let mut module = Module::on(bench_file);
        let common =
            [(Ap::MaxVelocity, 2 * TURN), (Ap::MaxAcceleration, 10 * TURN), (Ap::EncoderResolution, counts)];
        for &(parameter, value) in common.iter().chain(settings) {
            module.sap(parameter, value);
        }
        let ticks = try_initialize(&mut module);
        assert!(ticks.is_some(), "the initialisation failed on\n{bench_file}");
        let counts = f64::from(counts);
        let zero_turns = module.turns() - f64::from(module.gap(Ap::ActualPosition)) / counts;
        Self { module, zero_turns, counts }
    }

    /// Encoder steps in so many turns.
    pub(crate) fn steps(&self, turns: f64) -> i32 {
        (turns * self.counts).round() as i32
    }

    /// Where the shaft really is, in encoder steps.
    pub(crate) fn shaft(&self) -> f64 {
        (self.module.turns() - self.zero_turns) * self.counts
    }

    /// Sets several parameters.
    #[track_caller]
    pub(crate) fn set_all(&mut self, settings: &[(Ap, i32)]) {
        for &(parameter, value) in settings {
            self.sap(parameter, value);
        }
    }

    /// Whether a bit of AP 18 is set.
    #[track_caller]
    pub(crate) fn status_bit(&mut self, bit: u8) -> bool {
        self.gap(Ap::StatusWord) >> bit & 1 == 1
    }

    /// MVP ABS.
    #[track_caller]
    pub(crate) fn go(&mut self, position: i32) {
        self.ok(Command::MoveToPosition, 0, 0, position);
    }

    /// ROR, or ROL for a negative velocity.
    #[track_caller]
    pub(crate) fn rotate(&mut self, velocity_pps: i32) {
        if velocity_pps < 0 {
            self.ok(Command::RotateLeft, 0, 0, -velocity_pps);
        } else {
            self.ok(Command::RotateRight, 0, 0, velocity_pps);
        }
    }

    /// Runs until AP 8 is set; returns the control periods, to ten of them.
    #[track_caller]
    pub(crate) fn reach(&mut self) -> u64 {
        for tens in 0..40_000 {
            if self.gap(Ap::PositionReached) == 1 {
                return 10 * tens;
            }
            self.run_ticks(10);
        }
        let figures = self.figures();
        panic!("AP 8 is still 0 after 20 s; {figures}");
    }

    /// Moves to a position, where the shaft must be within AP 134 of it, then and a while later.
    #[track_caller]
    pub(crate) fn land(&mut self, position: i32) -> u64 {
        self.go(position);
        let ticks = self.reach();
        self.assert_at(position);
        self.run_ms(200);
        self.assert_at(position);
        ticks
    }

    /// The shaft is within AP 134 of a position, to the encoder step that a reading is uncertain by, and AP 1 says so.
    #[track_caller]
    pub(crate) fn assert_at(&mut self, position: i32) {
        let window = f64::from(self.gap(Ap::PositionReachedWindow));
        let off = self.shaft() - f64::from(position);
        let figures = self.figures();
        assert!(off.abs() <= window + 2.0, "{off:.1} encoder steps off, not within {window}; {figures}");
        self.assert_agrees();
    }

    /// AP 1 is AP 209, and both tell where the shaft is, as of a control period ago.
    #[track_caller]
    pub(crate) fn assert_agrees(&mut self) {
        let (position, counter) = (self.gap(Ap::ActualPosition), self.gap(Ap::EncoderCounter));
        assert_eq!(position, counter, "in closed loop AP 1 is AP 209");
        let a_period = self.physical().velocity_rpm.abs() / 60.0 * self.counts * 50e-6;
        let shaft = self.shaft();
        let off = (f64::from(position) - shaft).abs();
        assert!(
            off <= 2.5 + 2.0 * a_period,
            "AP 1 = {position}, but the shaft is at {shaft:.1} encoder steps"
        );
    }

    /// The mean of something over so many control periods.
    pub(crate) fn mean(&mut self, ticks: u64, mut quantity: impl FnMut(&mut Self) -> f64) -> f64 {
        let mut sum = 0.0;
        for _ in 0..ticks {
            self.run_ticks(1);
            sum += quantity(self);
        }
        sum / ticks as f64
    }

    /// Smallest and largest value of something over so many control periods.
    pub(crate) fn range(&mut self, ticks: u64, mut quantity: impl FnMut(&mut Self) -> f64) -> (f64, f64) {
        let mut range = (f64::INFINITY, f64::NEG_INFINITY);
        for _ in 0..ticks {
            self.run_ticks(1);
            let value = quantity(self);
            range = (range.0.min(value), range.1.max(value));
        }
        range
    }

    /// What a message about a failure should tell.
    pub(crate) fn figures(&mut self) -> String {
        let [target, position, velocity, lag, virtual_position] = [
            Ap::TargetPosition,
            Ap::ActualPosition,
            Ap::ActualVelocity,
            Ap::PositionError,
            Ap::VirtualPosition,
        ]
        .map(|parameter| self.gap(parameter));
        let status = self.gap(Ap::StatusWord);
        let (shaft, rpm) = (self.shaft(), self.physical().velocity_rpm);
        format!(
            "AP 0 = {target}, AP 1 = {position}, AP 3 = {velocity}, AP 18 = {status:#b}, AP 233 = {virtual_position}, \
             AP 237 = {lag}; the shaft is at {shaft:.1} encoder steps and turns at {rpm:.2} rpm"
        )
    }
}
