//! What can be changed on a running bench.

/// A change to a running bench.
#[derive(Clone, Debug, PartialEq)]
pub enum Setting {
    /// Torque from outside, constant from now on; positive drives to the right. -100 to 100 Nm.
    LoadTorqueNm(f64),
    /// Inertia of the load, 0 to 10 kgm².
    LoadInertiaKgm2(f64),
    /// Coulomb friction, 0 to 100 Nm.
    LoadFrictionNm(f64),
    /// Level of a digital input.
    Input {
        /// Which.
        number: u8,
        /// High or low.
        high: bool,
    },
    /// Reading of an analogue input.
    AnalogInput {
        /// Which.
        number: u8,
        /// 0 to 4095 for 0 to 10 V.
        reading: u16,
    },
    /// Voltage of the supply's source, 0 to 100 V.
    SupplyVoltageV(f64),
    /// Ambient temperature, -55 to 150 °C.
    AmbientC(f64),
    /// An encoder line that has come off; `None`: all lines are well.
    EncoderLine(Option<EncoderLine>),
    /// A coil that is open; `None`: neither.
    CoilOpen(Option<Coil>),
    /// A coil that is shorted to ground; `None`: neither.
    CoilShort(Option<Coil>),
    /// A phase whose wire is off; `None`: none.
    PhaseOpen(Option<Phase>),
    /// A phase that is shorted to ground; `None`: none.
    PhaseShort(Option<Phase>),
    /// A hall sensor whose line shows one level only.
    HallLine {
        /// Which.
        sensor: HallSensor,
        /// The level, high or low; `None`: it works.
        stuck: Option<bool>,
    },
    /// A switch whose contact is stuck.
    SwitchContact {
        /// Which.
        switch: SwitchName,
        /// How; `None`: it works.
        stuck: Option<Contact>,
    },
    /// What the board's temperature is, whatever the physics says, -55 to 150 °C; `None`: what the physics says.
    BoardTemperatureC(Option<f64>),
    /// The rotor slips by this many full steps at once, to the right if positive.
    DroppedSteps(i32),
    /// The module's power fails after so many further byte writes to its EEPROM; `None`: it does not.
    EepromCut(Option<u32>),
    /// Pulses a second at the step/direction connector, -1 000 000 to 1 000 000; positive is to the right.
    StepFrequencyHz(f64),
    /// How fast that changes to another value, 0 to 1 000 000 000 Hz/s; 0 = at once.
    StepAccelerationHzPerS(f64),
    /// How many pulses come from now on; `None`: any number.
    StepPulses(Option<u32>),
    /// Whether the ENABLE input of the step/direction connector is active.
    StepEnable(bool),
    /// Level of STEP, where a wire drives it.
    StepLevel(bool),
    /// Level of DIR, where a wire drives it.
    DirLevel(bool),
    /// The module's power.
    Power(Power),
}

/// A line of an encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EncoderLine {
    /// Channel A.
    A,
    /// Channel B.
    B,
    /// The index (N) channel.
    Index,
}

/// A coil of a two-phase motor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coil {
    /// Coil A.
    A,
    /// Coil B.
    B,
}

/// A phase of a three-phase motor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Phase U.
    U,
    /// Phase V.
    V,
    /// Phase W.
    W,
}

/// A hall sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HallSensor {
    /// H1.
    H1,
    /// H2.
    H2,
    /// H3.
    H3,
}

/// A switch of a module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SwitchName {
    /// The left stop switch.
    Left,
    /// The right stop switch.
    Right,
    /// The home switch.
    Home,
}

impl SwitchName {
    /// What people call it.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Right => "right",
            Self::Home => "home",
        }
    }
}

/// The state of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Contact {
    /// Open: what a normally closed switch is when it is pressed.
    Open,
    /// Closed.
    Closed,
}

/// What happens to a module's power.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Power {
    /// It is switched off.
    Off,
    /// It is switched on.
    On,
    /// It is switched off and on again at once.
    Cycle,
}
