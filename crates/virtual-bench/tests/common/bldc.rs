//! A host of a virtual TMCM-1640: how its motor is moved, loaded, held, and judged by where the shaft really is.

use std::ops::{Deref, DerefMut};

use tmcl_tables::Command;
use tmcl_tables::tmcm_1640::AxisParameter;

use super::Module;

/// The motor of the default bench: rated 0.125 Nm, 4096 encoder counts, 24 hall counts.
pub(crate) const MOTOR: &str = "QBL4208-61-04-013";

/// Its rated torque (decisions 8.3).
pub(crate) const RATED_NM: f64 = 0.125;

/// Its pole pairs.
pub(crate) const POLE_PAIRS: f64 = 4.0;

/// Encoder counts in a turn of it.
pub(crate) const ENCODER_TURN: i32 = 4096;

/// Hall counts in a turn of it: six to a pole pair (decisions 6.1).
pub(crate) const HALL_TURN: i32 = 24;

/// A whole electrical turn in the unit of AP 210, 211 and 212.
pub(crate) const ELECTRICAL_TURN: f64 = 65_536.0;

/// Torque of an ampere along the q axis: 3/2 · p · ψ with ψ = Kt / (√3 · p) (decisions 8.2, 8.3).
pub(crate) fn torque_nm(current_q_a: f64) -> f64 {
    1.5 * 0.036 / 3.0_f64.sqrt() * current_q_a
}

/// The current along the q axis that makes this torque.
pub(crate) fn current_ma(torque: f64) -> f64 {
    torque / torque_nm(1.0) * 1000.0
}

/// What the bench calls what breaks.
pub(crate) mod fault {
    /// Each sticks at `"low"` or `"high"`.
    pub(crate) const HALLS: [&str; 3] = ["fault.hall_1", "fault.hall_2", "fault.hall_3"];
    /// A phase, `"u"`, that is shorted to ground: the TMC603 reports it.
    pub(crate) const PHASE_SHORT: &str = "fault.phase_short";
    /// A phase, `"u"`, whose wire comes off.
    pub(crate) const PHASE_OPEN: &str = "fault.phase_open";
    /// The right switch's contact is stuck: `"open"`, as a cut wire, or `"closed"`.
    pub(crate) const SWITCH_RIGHT: &str = "fault.switch_right";
    /// What the NTC of §8 measures.
    pub(crate) const DRIVER_TEMPERATURE: &str = "fault.board_temperature_c";
    /// `"a"`, `"b"` or `"index"` comes off.
    pub(crate) const ENCODER_LINE: &str = "fault.encoder_line";
}

/// Bits of AP 156.
pub(crate) mod flag {
    pub(crate) const OVERCURRENT: u8 = 0;
    pub(crate) const UNDERVOLTAGE: u8 = 1;
    pub(crate) const OVERVOLTAGE: u8 = 2;
    pub(crate) const OVERTEMPERATURE: u8 = 3;
    pub(crate) const HALTED: u8 = 4;
    pub(crate) const HALL_ERROR: u8 = 5;
    pub(crate) const DRIVER_ERROR: u8 = 6;
    pub(crate) const VELOCITY_MODE: u8 = 9;
    pub(crate) const POSITION_MODE: u8 = 10;
    pub(crate) const TORQUE_MODE: u8 = 11;
    pub(crate) const POSITION_END: u8 = 14;
    pub(crate) const I2T: u8 = 17;
}

/// Friction of a shaft that is let go by [`Bldc::release`].
const FREE_NM: f64 = 0.002;

/// A bench file with a TMCM-1640; `more` are further sections of the module.
pub(crate) fn bench(more: &str) -> String {
    format!("[[module]]\nkind = \"tmcm-1640\"\n{more}\n")
}

/// The default bench with this in `[module.load]`.
pub(crate) fn loaded(load: &str) -> String {
    bench(&format!("[module.load]\n{load}"))
}

/// A TMCM-1640; wherever [`Module`] speaks of axis parameters, this speaks of its own.
#[derive(Clone, Debug)]
pub(crate) struct Bldc {
    module: Module,
}

impl Deref for Bldc {
    type Target = Module;

    fn deref(&self) -> &Module {
        &self.module
    }
}

impl DerefMut for Bldc {
    fn deref_mut(&mut self) -> &mut Module {
        &mut self.module
    }
}

impl Bldc {
    /// As delivered, on the default bench.
    #[track_caller]
    pub(crate) fn new() -> Self {
        Self::on(&bench(""))
    }

    /// The module of a bench file.
    #[track_caller]
    pub(crate) fn on(bench_file: &str) -> Self {
        Self { module: Module::on(bench_file) }
    }

    /// With current for twice the rated torque, and an I²t limit that never trips.
    #[track_caller]
    pub(crate) fn strong() -> Self {
        Self::strong_on(&bench(""))
    }

    /// [`Bldc::strong`] on another bench.
    #[track_caller]
    pub(crate) fn strong_on(bench_file: &str) -> Self {
        let mut axis = Self::on(bench_file);
        axis.set_all(&[(AxisParameter::MaxCurrent, 7000), (AxisParameter::I2tLimit, -1)]);
        axis
    }

    /// [`Bldc::strong`] with encoder commutation whose offset is found to a few electrical degrees: little friction, and time
    /// for the rotor to come to rest.
    #[track_caller]
    pub(crate) fn aligned() -> Self {
        let mut axis = Self::strong();
        axis.release();
        axis.set_all(&[(AxisParameter::StartCurrent, 2000), (AxisParameter::InitSineDelay, 2000)]);
        axis.use_encoder();
        axis
    }

    /// SAP, which must succeed.
    #[track_caller]
    pub(crate) fn sap(&mut self, parameter: AxisParameter, value: i32) {
        self.ok(Command::SetAxisParameter, parameter.number(), 0, value);
    }

    /// GAP, which must succeed.
    #[track_caller]
    pub(crate) fn gap(&mut self, parameter: AxisParameter) -> i32 {
        self.ok(Command::GetAxisParameter, parameter.number(), 0, 0)
    }

    /// Several SAP.
    #[track_caller]
    pub(crate) fn set_all(&mut self, settings: &[(AxisParameter, i32)]) {
        for &(parameter, value) in settings {
            self.sap(parameter, value);
        }
    }

    /// Whether a bit of AP 156 is set.
    #[track_caller]
    pub(crate) fn flag(&mut self, bit: u8) -> bool {
        self.gap(AxisParameter::StatusFlags) >> bit & 1 == 1
    }

    /// ROR, or ROL for a negative velocity.
    #[track_caller]
    pub(crate) fn rotate(&mut self, rpm: i32) {
        let command = if rpm < 0 { Command::RotateLeft } else { Command::RotateRight };
        self.ok(command, 0, 0, rpm.abs());
    }

    /// MST.
    #[track_caller]
    pub(crate) fn halt(&mut self) {
        self.ok(Command::MotorStop, 0, 0, 0);
    }

    /// MVP ABS.
    #[track_caller]
    pub(crate) fn go(&mut self, position: i32) {
        self.ok(Command::MoveToPosition, 0, 0, position);
    }

    /// MVP REL.
    #[track_caller]
    pub(crate) fn go_by(&mut self, offset: i32) {
        self.ok(Command::MoveToPosition, 1, 0, offset);
    }

    /// Encoder commutation by the initialisation that AP 249 says, and the time it takes.
    #[track_caller]
    pub(crate) fn use_encoder(&mut self) {
        self.sap(AxisParameter::CommutationMode, 7);
        let ms = self.gap(AxisParameter::InitSineDelay);
        self.run_ms(u64::from(ms.unsigned_abs()) + 100);
    }

    /// Runs until AP 8 is set, at most so long; returns the milliseconds.
    #[track_caller]
    pub(crate) fn reach(&mut self, at_most_ms: u64) -> u64 {
        for ms in 0..at_most_ms {
            if self.gap(AxisParameter::PositionReached) == 1 {
                return ms;
            }
            self.run_ms(1);
        }
        let figures = self.figures();
        panic!("AP 8 is still 0 after {at_most_ms} ms; {figures}");
    }

    /// How far the rotor really turned.
    pub(crate) fn turns(&self) -> f64 {
        self.read("physical.rotor_turns")
    }

    /// How fast it really turns.
    pub(crate) fn rpm(&self) -> f64 {
        self.read("physical.velocity_rpm")
    }

    /// The current that really makes torque.
    pub(crate) fn current_q_ma(&self) -> f64 {
        self.read("physical.current_q_a") * 1000.0
    }

    /// The current that really makes none.
    pub(crate) fn current_d_ma(&self) -> f64 {
        self.read("physical.current_d_a") * 1000.0
    }

    /// Length of the current vector that really flows.
    pub(crate) fn amplitude_ma(&self) -> f64 {
        self.current_q_ma().hypot(self.current_d_ma())
    }

    /// Where the rotor really stands electrically, in the unit of AP 210 to 212: 0 to 65 536.
    pub(crate) fn electrical(&self) -> f64 {
        (self.turns() * POLE_PAIRS).rem_euclid(1.0) * ELECTRICAL_TURN
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

    /// Clamps the shaft where it is, so that no torque of the motor moves it.
    #[track_caller]
    pub(crate) fn clamp(&mut self) {
        self.set("load.friction_nm", 100);
        self.run_ms(1);
    }

    /// Lets go of the shaft.
    #[track_caller]
    pub(crate) fn release(&mut self) {
        self.set("load.friction_nm", FREE_NM);
    }

    /// Turns the shaft by hand, with the power stage off, until it stands so many turns from where it began.
    #[track_caller]
    pub(crate) fn place(&mut self, turns: f64) {
        let enabled = self.gap(AxisParameter::EnableDriver);
        self.sap(AxisParameter::EnableDriver, 0);
        self.release();
        let direction = (turns - self.turns()).signum();
        self.set("load.torque_nm", 0.006 * direction);
        let mut ticks = 0;
        while (turns - self.turns()) * direction > 0.0 {
            self.run_ticks(1);
            ticks += 1;
            assert!(ticks < 100_000, "the shaft does not turn: {} turns", self.turns());
        }
        self.clamp();
        self.set("load.torque_nm", 0);
        // By halls the speed reads 0 only half a second after the last edge (decisions 6.2).
        self.run_ms(600);
        assert!(self.rpm().abs() < 1e-6, "{} rpm", self.rpm());
        self.release();
        self.run_ms(1);
        self.sap(AxisParameter::EnableDriver, enabled);
    }

    /// What a message about a failure should tell.
    pub(crate) fn figures(&mut self) -> String {
        use AxisParameter as Ap;
        let [target, position, velocity, ramp, wanted, current] = [
            Ap::TargetPosition,
            Ap::ActualPosition,
            Ap::ActualVelocity,
            Ap::RampVelocity,
            Ap::TargetCurrent,
            Ap::MotorCurrent,
        ]
        .map(|parameter| self.gap(parameter));
        let flags = self.gap(Ap::StatusFlags);
        format!(
            "AP 0 = {target}, AP 1 = {position}, AP 3 = {velocity}, AP 13 = {ramp}, AP 155 = {wanted}, AP 150 = {current}, \
             AP 156 = {flags:#b}; the shaft is at {:.5} turns and turns at {:.2} rpm with {:.0} mA along q, {:.0} along d",
            self.turns(),
            self.rpm(),
            self.current_q_ma(),
            self.current_d_ma(),
        )
    }
}

/// How far apart two electrical angles are, in electrical degrees: −180 to 180.
pub(crate) fn apart_deg(angle: f64, other: f64) -> f64 {
    let turns = (angle - other) / ELECTRICAL_TURN;
    (turns - turns.round()) * 360.0
}
