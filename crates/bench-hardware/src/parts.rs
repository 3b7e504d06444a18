//! What a module's hardware is made of.

use motor_physics::load::LoadTorque;
use motor_physics::mechanics::Mechanics;
use motor_physics::pmsm::PmsmParameters;
use motor_physics::presets::{self, QBL4208_ENCODER_COUNTS};
use motor_physics::stepper::StepperParameters;
use motor_physics::supply::SupplyParameters;
use motor_physics::switch::SwitchConfig;

/// Temperature of a room (chosen).
pub const ROOM_C: f64 = 25.0;

/// Friction that lets a free shaft settle: Coulomb in Nm, viscous in Nm·s/rad.
///
/// Chosen: with a QSH5718-51-28-101 at the TMCM-1311's default current a shaft released one full step off comes to rest,
/// within a twentieth of a step, after 85 ms; it crosses its resonance near one turn a second without coming more than
/// 0.4 full steps off; it rests within 0.02 full steps; and at 20 turns a second the friction takes 6 % of the holding
/// torque. With a QBL4208-61-04-013 the friction at 4000 rpm takes 0.0134 Nm, a current of 0.37 A between two lines: what
/// such a motor takes without load.
pub const STEPPER_FRICTION: (f64, f64) = (0.01, 4e-4);
/// The same of a brushless motor.
pub const BRUSHLESS_FRICTION: (f64, f64) = (0.005, 2e-5);

/// What every module has, whatever it drives.
#[derive(Clone, Debug, PartialEq)]
pub struct CommonParts {
    /// The shaft with its load and the motor's rotor.
    pub mechanics: Mechanics,
    /// The torque from outside.
    pub load: LoadTorque,
    /// What it sees of the shaft.
    pub encoder: EncoderParts,
    /// What it runs on.
    pub supply: SupplyParameters,
    /// Ambient temperature.
    pub ambient_c: f64,
    /// The levels at inputs 0 to 7, as bits.
    pub inputs: u8,
}

/// An incremental encoder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EncoderParts {
    /// Quadrature counts of a turn, four times its lines.
    pub counts: u32,
    /// Where the shaft stands at the index pulse.
    pub offset_turns: f64,
    /// It counts down when the shaft turns to the right.
    pub inverted: bool,
    /// It has an index (N) channel, a pulse a turn.
    pub index: bool,
}

/// A source of pulses.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PulseParts {
    /// Pulses a second; positive is to the right, 0 is none.
    pub frequency_hz: f64,
    /// How fast the frequency changes, in Hz/s; 0 = at once.
    pub acceleration_hz_per_s: f64,
    /// How many it gives before it falls silent; `None`: it never does.
    pub pulses: Option<u32>,
}

/// What surrounds the firmware of a stepper module.
#[derive(Clone, Debug, PartialEq)]
pub struct StepperParts {
    /// What every module has.
    pub common: CommonParts,
    /// The motor.
    pub motor: StepperParameters,
    /// Left, right and home switch, where there are any.
    pub switches: [Option<SwitchConfig>; 3],
    /// What gives pulses at the step/direction connector.
    pub pulses: PulseParts,
    /// ENABLE of the connector is active.
    pub enabled: bool,
    /// AIN_0 and AIN_4.
    pub analog_inputs: [u16; 2],
}

/// What surrounds the firmware of a module for brushless motors.
#[derive(Clone, Debug, PartialEq)]
pub struct BldcParts {
    /// What every module has.
    pub common: CommonParts,
    /// The motor.
    pub motor: PmsmParameters,
    /// Left and right switch, where there are any.
    pub switches: [Option<SwitchConfig>; 2],
    /// Electrical angle, from phase U's axis, at which the hall sensors' first sector begins.
    pub halls_offset_deg: f64,
    /// Their lines show the opposite of what is meant.
    pub halls_inverted: bool,
    /// AIN.
    pub analog_input: u16,
}

impl CommonParts {
    /// A free shaft with a rotor of this inertia, at a supply of this voltage, with an encoder of so many counts.
    #[must_use]
    pub fn standard(
        rotor_inertia_kgm2: f64,
        (friction_nm, viscous_nm_s_per_rad): (f64, f64),
        voltage_v: f64,
        counts: u32,
    ) -> Self {
        Self {
            mechanics: Mechanics {
                inertia_kgm2: rotor_inertia_kgm2,
                friction_nm,
                viscous_nm_s_per_rad,
                hard_stops: None,
            },
            load: LoadTorque::Constant(0.0),
            encoder: EncoderParts { counts, offset_turns: 0.0, inverted: false, index: true },
            supply: SupplyParameters::standard(voltage_v),
            ambient_c: ROOM_C,
            inputs: 0,
        }
    }
}

impl StepperParts {
    /// The TMCM-1311 on the default bench: a QSH5718-51-28-101 at 48 V with an encoder of 40 000 counts.
    #[must_use]
    pub fn standard() -> Option<Self> {
        let motor = presets::stepper("QSH5718-51-28-101")?;
        Some(Self {
            common: CommonParts::standard(motor.rotor_inertia_kgm2, STEPPER_FRICTION, 48.0, 40_000),
            motor,
            switches: [None; 3],
            pulses: PulseParts::default(),
            enabled: false,
            analog_inputs: [0; 2],
        })
    }
}

impl BldcParts {
    /// The TMCM-1640 on the default bench: a QBL4208-61-04-013 at 24 V with its encoder.
    #[must_use]
    pub fn standard() -> Option<Self> {
        let motor = presets::pmsm("QBL4208-61-04-013")?;
        let common =
            CommonParts::standard(motor.rotor_inertia_kgm2, BRUSHLESS_FRICTION, 24.0, QBL4208_ENCODER_COUNTS);
        Some(Self {
            common,
            motor,
            switches: [None; 2],
            halls_offset_deg: 0.0,
            halls_inverted: false,
            analog_input: 0,
        })
    }
}
