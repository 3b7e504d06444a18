//! The seam between firmware and physics.

use crate::Setting;

/// A kind of motor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotorFamily {
    /// Two-phase hybrid steppers.
    Stepper,
    /// Three-phase brushless motors.
    Brushless,
}

/// Driver chip, motor, load, sensors and supply of one module.
pub trait Hardware: Clone {
    /// What the sensors say.
    type Sensed;
    /// What the firmware commands.
    type Drive;

    /// What the sensors say now.
    fn sensed(&self) -> Self::Sensed;
    /// Holds `drive` for the control period that ends at `until_ns`. Returns whether anything changed but the time and
    /// what counts it.
    fn advance(&mut self, drive: &Self::Drive, until_ns: u64) -> bool;
    /// `periods` further control periods like the last one, in which nothing changed; the last ends at `until_ns`.
    fn rest(&mut self, periods: u64, until_ns: u64);
    /// The next instant at which something may change by itself.
    fn next_change_ns(&self) -> u64;
    /// What really is, whatever sensors and firmware believe.
    fn physical(&self) -> Physical;
}

/// Hardware whose surroundings the bench can change.
pub trait Surroundings {
    /// Changes something about them.
    fn apply(&mut self, setting: Setting);
    /// The raw count of the encoder.
    fn encoder_counts(&self) -> i32;
    /// Pulses at the step/direction connector, those to the right less those to the left.
    fn step_pulses(&self) -> i64;
    /// Levels that wires drive at STEP and DIR; low where none does.
    fn pulse_levels(&self) -> PulseLevels {
        PulseLevels::default()
    }
}

/// The levels at STEP and DIR.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PulseLevels {
    /// STEP is high.
    pub step: bool,
    /// DIR is high.
    pub dir: bool,
}

/// The truth about a motor, in the order of [`Physical::NAMES`]. What its kind of motor does not have is 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Physical {
    /// How far the rotor turned since power was first switched on; positive to the right (ROR).
    pub rotor_turns: f64,
    /// How fast it turns.
    pub velocity_rpm: f64,
    /// Torque between rotor and stator.
    pub torque_nm: f64,
    /// Torque from outside.
    pub load_nm: f64,
    /// How far the rotor lags behind the field. A stepper's field is the one that is commanded, and 90 is the limit; a
    /// brushless motor's is that of its currents, and 90 makes the most torque of them. 0 without any.
    pub load_angle_deg: f64,
    /// Current in coil A of a stepper.
    pub coil_a_a: f64,
    /// Current in coil B of a stepper.
    pub coil_b_a: f64,
    /// Voltage of the bus.
    pub bus_voltage_v: f64,
    /// Current out of the supply.
    pub supply_current_a: f64,
    /// Temperature of the windings.
    pub winding_temperature_c: f64,
    /// Temperature of the board.
    pub board_temperature_c: f64,
    /// Current along the magnets of a brushless motor, amplitude; positive strengthens them.
    pub current_d_a: f64,
    /// Current across them, amplitude: what makes torque, positive to the right.
    pub current_q_a: f64,
    /// Current into phase U of a brushless motor.
    pub phase_u_a: f64,
    /// Current into phase V.
    pub phase_v_a: f64,
    /// Current into phase W.
    pub phase_w_a: f64,
}

impl Physical {
    /// Name and unit of every quantity.
    pub const NAMES: [(&str, &str); 16] = [
        ("rotor_turns", "turn"),
        ("velocity_rpm", "rpm"),
        ("torque_nm", "Nm"),
        ("load_nm", "Nm"),
        ("load_angle_deg", "°"),
        ("coil_a_a", "A"),
        ("coil_b_a", "A"),
        ("bus_voltage_v", "V"),
        ("supply_current_a", "A"),
        ("winding_temperature_c", "°C"),
        ("board_temperature_c", "°C"),
        ("current_d_a", "A"),
        ("current_q_a", "A"),
        ("phase_u_a", "A"),
        ("phase_v_a", "A"),
        ("phase_w_a", "A"),
    ];

    /// The names that mean something for motors of one family only, by their place in [`Physical::NAMES`].
    const STEPPER_ONLY: [usize; 2] = [5, 6];
    const BRUSHLESS_ONLY: [usize; 5] = [11, 12, 13, 14, 15];

    /// The quantities of a motor of this family: place in [`Physical::NAMES`], and name.
    pub fn names_of(family: MotorFamily) -> impl Iterator<Item = (usize, &'static str)> {
        let others: &[usize] = match family {
            MotorFamily::Stepper => &Self::BRUSHLESS_ONLY,
            MotorFamily::Brushless => &Self::STEPPER_ONLY,
        };
        let names = Self::NAMES.iter().enumerate().map(|(index, (name, _))| (index, *name));
        names.filter(|(index, _)| !others.contains(index))
    }

    /// Every quantity, in the order of the names.
    #[must_use]
    pub fn values(&self) -> [f64; 16] {
        [
            self.rotor_turns,
            self.velocity_rpm,
            self.torque_nm,
            self.load_nm,
            self.load_angle_deg,
            self.coil_a_a,
            self.coil_b_a,
            self.bus_voltage_v,
            self.supply_current_a,
            self.winding_temperature_c,
            self.board_temperature_c,
            self.current_d_a,
            self.current_q_a,
            self.phase_u_a,
            self.phase_v_a,
            self.phase_w_a,
        ]
    }
}
