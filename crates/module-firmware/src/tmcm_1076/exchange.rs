//! What the TMCM-1076's firmware is told, and what it commands.

/// TSTEP of a motor that stands (AP 135).
pub const STANDSTILL_TSTEP: u32 = 1_048_575;

/// What the inputs and the driver say, once a control period.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sensed {
    /// CHOP; true = high (§5.1).
    pub chop: bool,
    /// ENABLE; true = high, which switches the motor off (§5.1).
    pub enable: bool,
    /// The driver has seen no step for 2^20 of its clocks (DRV_STATUS, stst).
    pub standstill: bool,
    /// stealthChop is in use (DRV_STATUS, stealth).
    pub stealth: bool,
    /// TSTEP.
    pub tstep: u32,
    /// The current scale in use, 0 to 31 (DRV_STATUS, CS_ACTUAL).
    pub cs_actual: u8,
    /// The stallGuard2 reading, 0 to 1023 (DRV_STATUS, SG_RESULT).
    pub sg_result: u16,
    /// The amplitude that stealthChop's current regulation came to, 0 to 255 (PWM_SCALE_SUM).
    pub pwm_scale_sum: u8,
}

impl Default for Sensed {
    /// Before the driver was first asked.
    fn default() -> Self {
        Self {
            chop: false,
            enable: false,
            standstill: false,
            stealth: false,
            tstep: STANDSTILL_TSTEP,
            cs_actual: 0,
            sg_result: 0,
            pwm_scale_sum: 0,
        }
    }
}

/// What the driver's pins and registers shall be. The default leaves the bridges off.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Drive {
    /// DRV_ENN is low.
    pub enabled: bool,
    /// GCONF, en_pwm_mode.
    pub stealthchop: bool,
    /// IHOLD_IRUN, IRUN: 0 to 31.
    pub irun: u8,
    /// IHOLD_IRUN, IHOLD: 0 to 31.
    pub ihold: u8,
    /// IHOLD_IRUN, IHOLDDELAY: 0 to 15.
    pub iholddelay: u8,
    /// TPWMTHRS: 20 bits.
    pub tpwmthrs: u32,
    /// TCOOLTHRS: 20 bits.
    pub tcoolthrs: u32,
    /// THIGH: 20 bits.
    pub thigh: u32,
    /// CHOPCONF.
    pub chopconf: u32,
    /// COOLCONF.
    pub coolconf: u32,
    /// PWMCONF.
    pub pwmconf: u32,
}
