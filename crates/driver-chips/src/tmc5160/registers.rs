//! What can be written to the chip over SPI, as far as it changes its averaged behaviour.

use crate::stepper::CoolStep;

/// Defines a register that holds named fields in its bits, with a way from the bits and back.
macro_rules! register {
    ($(#[$about:meta])* $name:ident { $($(#[$doc:meta])* $field:ident: $kind:ident = $low:literal + $width:literal,)* }) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        pub struct $name {
            $($(#[$doc])* pub $field: $kind,)*
        }

        impl $name {
            /// The register with these bits. Those of no field are lost.
            #[must_use]
            pub fn from_bits(bits: u32) -> Self {
                Self { $($field: Field::unpacked(bits >> $low, $width),)* }
            }

            /// The register's bits. What does not fit into a field is cut off.
            #[must_use]
            pub fn bits(self) -> u32 {
                0 $(| Field::packed(self.$field, $width) << $low)*
            }
        }
    };
}

/// A value in some of a register's bits.
trait Field {
    fn unpacked(bits: u32, width: u32) -> Self;
    fn packed(self, width: u32) -> u32;
}

impl Field for u8 {
    fn unpacked(bits: u32, width: u32) -> Self {
        (bits & ((1 << width) - 1)) as Self
    }

    fn packed(self, width: u32) -> u32 {
        u32::from(self) & ((1 << width) - 1)
    }
}

impl Field for i8 {
    fn unpacked(bits: u32, width: u32) -> Self {
        (bits << (32 - width)).cast_signed().wrapping_shr(32 - width) as Self
    }

    fn packed(self, width: u32) -> u32 {
        i32::from(self).cast_unsigned() & ((1 << width) - 1)
    }
}

impl Field for bool {
    fn unpacked(bits: u32, _: u32) -> Self {
        bits & 1 != 0
    }

    fn packed(self, _: u32) -> u32 {
        self.into()
    }
}

register! {
    /// GCONF (0x00): how the whole chip works.
    GConf {
        /// stealthChop wherever the velocity thresholds let it; else spreadCycle.
        en_pwm_mode: bool = 2 + 1,
        /// The motor turns the other way.
        shaft: bool = 4 + 1,
        /// Thresholds have a hysteresis of 1/32, not of 1/16.
        small_hysteresis: bool = 14 + 1,
    }
}

register! {
    /// IHOLD_IRUN (0x10): currents at rest and in motion.
    IHoldIRun {
        /// Current scale at standstill, 0 to 31.
        ihold: u8 = 0 + 5,
        /// Current scale in motion, 0 to 31.
        irun: u8 = 8 + 5,
        /// Multiples of 2^18 clocks for each step from IRUN down to IHOLD, 0 to 15; 0 = at once.
        iholddelay: u8 = 16 + 4,
    }
}

register! {
    /// CHOPCONF (0x6C): the chopper and the step input.
    ///
    /// How long the chopper is on and off, and with which hysteresis, is averaged away, and so is the difference between
    /// spreadCycle and a constant off time.
    ChopConf {
        /// Off time; 0 switches the bridges off.
        toff: u8 = 0 + 4,
        /// Hysteresis start, or the lower bits of the fast decay time.
        hstrt: u8 = 4 + 3,
        /// Hysteresis end, or the sine wave's offset.
        hend: u8 = 7 + 4,
        /// Highest bit of the fast decay time.
        fd3: bool = 11 + 1,
        /// No current comparator ends the fast decay.
        disfdcc: bool = 12 + 1,
        /// Constant off time instead of spreadCycle.
        chm: bool = 14 + 1,
        /// Blank time.
        tbl: u8 = 15 + 2,
        /// Full steps at high velocity.
        vhighfs: bool = 18 + 1,
        /// Constant off time at high velocity.
        vhighchm: bool = 19 + 1,
        /// Passive fast decay time.
        tpfd: u8 = 20 + 4,
        /// A step moves by 2^MRES of the 256 microsteps of a full step, 0 to 8; more acts as 8.
        mres: u8 = 24 + 4,
        /// MicroPlyer: each step is spread over microsteps of 1/256.
        intpol: bool = 28 + 1,
        /// Falling edges on the step input make steps, too.
        dedge: bool = 29 + 1,
        /// Shorts to ground do not switch the bridges off.
        diss2g: bool = 30 + 1,
        /// Shorts to the supply do not either; there are none to be modelled.
        diss2vs: bool = 31 + 1,
    }
}

register! {
    /// COOLCONF (0x6D): coolStep and stallGuard2.
    CoolConf {
        /// Readings below 32 · SEMIN raise the current; 0 switches coolStep off.
        semin: u8 = 0 + 4,
        /// The current rises by 1, 2, 4 or 8 a reading.
        seup: u8 = 5 + 2,
        /// Readings from 32 · (SEMIN + SEMAX + 1) on lower the current.
        semax: u8 = 8 + 4,
        /// The current falls by 1 after 32, 8, 2 or 1 readings.
        sedn: u8 = 13 + 2,
        /// The current may fall to a quarter of IRUN, not only to a half.
        seimin: bool = 15 + 1,
        /// A higher value makes stallGuard2 less sensitive, −64 to 63.
        sgt: i8 = 16 + 7,
        /// One stallGuard2 reading in four full steps instead of one in each.
        sfilt: bool = 24 + 1,
    }
}

register! {
    /// PWMCONF (0x70): stealthChop.
    PwmConf {
        /// Amplitude at standstill at the full current scale, where automatic scaling starts from.
        pwm_ofs: u8 = 0 + 8,
        /// What a velocity of one 1/256 microstep in 256 clocks adds to the amplitude.
        pwm_grad: u8 = 8 + 8,
        /// PWM frequency; averaged away.
        pwm_freq: u8 = 16 + 2,
        /// The amplitude is regulated so that the current is what it should be.
        pwm_autoscale: bool = 18 + 1,
        /// PWM_GRAD is found automatically, too.
        pwm_autograd: bool = 19 + 1,
        /// With a current of 0 at standstill: 0 = none, 1 = the coils are let go, 2, 3 = they are short-circuited.
        freewheel: u8 = 20 + 2,
        /// The regulated amplitude changes by at most half this in a half-wave. 0 acts as 1 (decision).
        pwm_reg: u8 = 24 + 4,
        /// The regulated amplitude is at most 16 · PWM_LIM + 15 when stealthChop begins.
        pwm_lim: u8 = 28 + 4,
    }
}

impl CoolConf {
    /// The fields of coolStep.
    #[must_use]
    pub fn coolstep(self) -> CoolStep {
        CoolStep {
            lower_threshold: self.semin,
            hysteresis: self.semax,
            up_step: self.seup,
            down_step: self.sedn,
            quarter_minimum: self.seimin,
        }
    }
}

/// The chip's registers. The default is all zero, with the bridges off.
///
/// A field that holds more than its register has bits for acts as the largest value that fits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Registers {
    /// GCONF.
    pub gconf: GConf,
    /// GLOBAL_SCALER (0x0B): the full-scale current in 1/256; 0 = 256/256.
    pub global_scaler: u8,
    /// IHOLD_IRUN.
    pub ihold_irun: IHoldIRun,
    /// TPOWERDOWN (0x11): multiples of 2^18 clocks between standstill and the reduction of the current.
    pub tpowerdown: u8,
    /// TPWMTHRS (0x13): stealthChop where TSTEP is at least this; 0 = at all velocities.
    pub tpwmthrs: u32,
    /// TCOOLTHRS (0x14): coolStep and stallGuard2, and no stealthChop, where TSTEP is at most this.
    pub tcoolthrs: u32,
    /// THIGH (0x15): no coolStep and no stealthChop, and what `vhighfs` and `vhighchm` say, where TSTEP is at most this.
    pub thigh: u32,
    /// CHOPCONF.
    pub chopconf: ChopConf,
    /// COOLCONF.
    pub coolconf: CoolConf,
    /// PWMCONF.
    pub pwmconf: PwmConf,
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn bits_that_have_a_field_survive(bits in any::<u32>()) {
            for (through, named) in [
                (GConf::from_bits(bits).bits(), 0x0000_4014),
                (IHoldIRun::from_bits(bits).bits(), 0x000F_1F1F),
                (ChopConf::from_bits(bits).bits(), 0xFFFD_DFFF),
                (CoolConf::from_bits(bits).bits(), 0x017F_EF6F),
                (PwmConf::from_bits(bits).bits(), 0xFF3F_FFFF),
            ] {
                prop_assert_eq!(through, bits & named);
            }
        }
    }

    #[test]
    fn fields_lie_where_the_datasheet_puts_them() {
        let chopconf = ChopConf::from_bits(0x1401_80C3);
        let expected =
            ChopConf { toff: 3, hstrt: 4, hend: 1, tbl: 3, mres: 4, intpol: true, ..ChopConf::default() };
        assert_eq!(chopconf, expected);
        assert_eq!(CoolConf::from_bits(0x0040_80E3).sgt, -64);
        assert_eq!(CoolConf::from_bits(0x003F_0000).sgt, 63);
        assert_eq!(CoolConf::from_bits(0x007F_0000).sgt, -1);
        let pwmconf = PwmConf::from_bits(0xC40C_001E);
        let expected = PwmConf {
            pwm_ofs: 30,
            pwm_autoscale: true,
            pwm_autograd: true,
            pwm_reg: 4,
            pwm_lim: 12,
            ..PwmConf::default()
        };
        assert_eq!(pwmconf, expected);
    }
}
