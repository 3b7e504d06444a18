//! What the chip can be asked.

/// DRV_STATUS (0x6F), and the values of some registers that can only be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Status {
    /// SG_RESULT: the last stallGuard2 reading, 0 to 1023; more load reads lower. 0 while there is none: at standstill, with
    /// stealthChop, and slower than TCOOLTHRS.
    pub sg_result: u16,
    /// StallGuard: a reading of 0.
    pub stallguard: bool,
    /// CS_ACTUAL: the current scale in use, 0 to 31.
    pub cs_actual: u8,
    /// stealth: stealthChop is in use.
    pub stealth: bool,
    /// fsactive: full steps because of the velocity.
    pub fsactive: bool,
    /// ot: the chip was at 150 °C and is not yet below 120 °C. The bridges are off.
    pub ot: bool,
    /// otpw: the chip is at 120 °C or more.
    pub otpw: bool,
    /// s2ga, s2gb: a short to ground switched the bridges off, until the driver is disabled.
    pub s2g: [bool; 2],
    /// ola, olb: the current never reached its target over a half-wave. Judged with spreadCycle only (decision); tells
    /// nothing about a motor that stands.
    pub ol: [bool; 2],
    /// stst: no step for 2^20 clocks.
    pub stst: bool,
    /// TSTEP: clocks between two 1/256 microsteps; 2^20 − 1 at standstill.
    pub tstep: u32,
    /// MSCNT: the place in the microstep table, 0 to 1023.
    pub mscnt: u16,
    /// MSCURACT: the commanded currents A and B, in 1/248 of the current scale.
    pub mscuract: [i16; 2],
    /// PWM_SCALE_SUM: the amplitude of stealthChop, 0 to 255; 0 with spreadCycle.
    pub pwm_scale_sum: u8,
}

impl Status {
    /// DRV_STATUS as it is read.
    #[must_use]
    pub fn bits(&self) -> u32 {
        let ([s2ga, s2gb], [ola, olb]) = (self.s2g, self.ol);
        let flags = [
            (14, self.stealth),
            (15, self.fsactive),
            (24, self.stallguard),
            (25, self.ot),
            (26, self.otpw),
            (27, s2ga),
            (28, s2gb),
            (29, ola),
            (30, olb),
            (31, self.stst),
        ];
        let flags = flags.into_iter().fold(0, |bits, (bit, flag)| bits | (u32::from(flag) << bit));
        flags | u32::from(self.sg_result) | (u32::from(self.cs_actual) << 16)
    }
}
