//! The seam between firmware and physics.

/// Driver chip, motor, load and sensors of one module.
pub trait Hardware: Clone {
    /// What the sensors say.
    type Sensed;
    /// What the firmware commands.
    type Drive;

    /// What the sensors say now.
    fn sensed(&self) -> Self::Sensed;
    /// Holds `drive` until `until_ns`, an instant that never lies before the last one.
    fn advance(&mut self, drive: &Self::Drive, until_ns: u64);
    /// What really is, whatever sensors and firmware believe.
    fn physical(&self) -> Physical;
}

/// The truth about a motor shaft.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Physical {
    /// How far the rotor turned since power was first switched on; positive to the right (ROR).
    pub rotor_turns: f64,
}
