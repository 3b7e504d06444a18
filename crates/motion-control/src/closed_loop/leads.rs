//! The torque block: how far the ramp and the field are ahead of the rotor (TMCM-1311 §8.2, §8.4 to §8.7; decision).
//!
//! Three places on one axis: the rotor; the place the ramp generator says it should be (the virtual position); and the
//! place the field points at. Only the field makes torque, the more the further it is ahead, up to 90°; beyond that it makes
//! less, and the motor would lose steps. So the field never gets further ahead than that, whatever the ramp does: it waits
//! for the rotor, and makes up for it as far as it is allowed to.

use crate::TICKS_PER_SECOND;
use crate::division::divided_down;
use crate::ramp::UNITS_PER_STEP;

/// 90° electrical in µsteps: the lead with the largest torque.
pub const QUARTER_PERIOD: i32 = 256;

/// In velocity mode the virtual position stays so near to the rotor: three full steps.
const VELOCITY_MODE_WINDOW: i64 = 3 * 256;

/// Ramp units that a velocity of 1 pps covers in a control period.
const UNITS_PER_PPS: i64 = UNITS_PER_STEP / TICKS_PER_SECOND;

/// How far the field may be ahead of the rotor, and behind it, in µsteps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LeadLimits {
    lowest: i32,
    highest: i32,
}

impl LeadLimits {
    /// 90° both ways, and `gamma` more on the side the rotor turns to: the sign of `velocity_pps`. On the other side it
    /// would brake less and less, and run away.
    #[must_use]
    pub fn new(gamma: i32, velocity_pps: i32) -> Self {
        let beyond = |sign| if velocity_pps.signum() == sign { gamma } else { 0 };
        Self { lowest: -(QUARTER_PERIOD + beyond(-1)), highest: QUARTER_PERIOD + beyond(1) }
    }

    /// The lead with the largest torque in this direction; 0 for none.
    #[must_use]
    pub fn towards(&self, direction: i32) -> i32 {
        match direction.signum() {
            1 => self.highest,
            -1 => self.lowest,
            _ => 0,
        }
    }
}

/// How an overload is made up for during a move (TMCM-1311 §8.4, AP 124 to 126).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Correction {
    /// Correction velocity in pps for each 256 µsteps of lag.
    pub proportional: u32,
    /// Lag in µsteps that is left alone.
    pub max_following_error: u32,
    /// Largest velocity of the field, correction included.
    pub max_velocity_pps: u32,
}

impl Correction {
    /// What comes on top of the ramp's velocity at this lag, in pps.
    fn velocity_pps(&self, lag: i64) -> i64 {
        let beyond = lag.saturating_abs().saturating_sub(self.max_following_error.into()).max(0);
        // Larger lags get the largest velocity anyway.
        let beyond = beyond.min(u32::MAX.into());
        beyond.saturating_mul(self.proportional.into()) / 256 * lag.signum()
    }
}

/// The leads of ramp and field over the rotor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Leads {
    /// Of the virtual position, in whole µsteps.
    ramp: i64,
    /// Of the field, in units of [`UNITS_PER_STEP`], within the limits.
    field: i64,
    /// What the ramp gave way in the overload that goes on, in µsteps.
    given_way: i64,
}

impl Leads {
    /// How far the virtual position is ahead of the rotor, in µsteps; negative where it is behind.
    #[must_use]
    pub fn ramp(&self) -> i64 {
        self.ramp
    }

    /// How far the field is ahead of the rotor, in µsteps; negative where it is behind.
    #[must_use]
    pub fn field(&self) -> i32 {
        i32::try_from(divided_down(self.field, UNITS_PER_STEP).0).unwrap_or(0)
    }

    /// The rotor went on by so many µsteps.
    pub fn rotor_moved(&mut self, microsteps: i64) {
        self.ramp = self.ramp.saturating_sub(microsteps);
        self.field = self.field.saturating_sub(microsteps.saturating_mul(UNITS_PER_STEP));
    }

    /// How far the virtual position would be ahead of the rotor, had it not given way to the overload that goes on.
    #[must_use]
    pub fn shortfall(&self) -> i64 {
        self.ramp.saturating_add(self.given_way)
    }

    /// The ramp starts anew from where the rotor is.
    pub fn forget_ramp(&mut self) {
        self.ramp = 0;
        self.given_way = 0;
    }

    /// The field points at the rotor.
    pub fn forget_field(&mut self) {
        self.field = 0;
    }

    /// The virtual position gives way to an overload: it gets no further from the rotor than `window`, in µsteps.
    pub fn give_way(&mut self, window: i64) {
        let wanted = self.ramp;
        self.ramp = wanted.min(window).max(-window);
        self.given_way = self.given_way.saturating_add(wanted.saturating_sub(self.ramp));
    }

    /// What the ramp gave way counts no more: the overload is over.
    pub fn forget_overload(&mut self) {
        self.given_way = 0;
    }

    /// The ramp went on by so many µsteps.
    pub fn ramp_moved(&mut self, microsteps: i64) {
        self.ramp = self.ramp.saturating_add(microsteps);
    }

    /// The field follows the virtual position, and makes up for what it is behind (positioning, §8.4). The ramp went on by
    /// `ramp_units` in this control period.
    pub fn follow(&mut self, ramp_units: i64, correction: &Correction, limits: LeadLimits) {
        let lag = self.ramp.saturating_sub(divided_down(self.field, UNITS_PER_STEP).0);
        let largest = i64::from(correction.max_velocity_pps) * UNITS_PER_PPS;
        let wanted = ramp_units.saturating_add(correction.velocity_pps(lag).saturating_mul(UNITS_PER_PPS));
        self.point(self.field.saturating_add(wanted.min(largest).max(-largest)), limits);
    }

    /// The field stands at the virtual position, which gives way to an overload, so that none is made up for later (velocity
    /// mode, §8.6).
    pub fn follow_closely(&mut self, limits: LeadLimits) {
        self.give_way(VELOCITY_MODE_WINDOW);
        // A full step nearer, the overload is over.
        if self.ramp.saturating_abs() <= VELOCITY_MODE_WINDOW - i64::from(QUARTER_PERIOD) {
            self.forget_overload();
        }
        self.point(self.ramp * UNITS_PER_STEP, limits);
    }

    /// The field is ahead by so many µsteps, as far as the limits let it.
    pub fn lead_by(&mut self, microsteps: i64, limits: LeadLimits) {
        self.point(microsteps.saturating_mul(UNITS_PER_STEP), limits);
    }

    fn point(&mut self, field: i64, limits: LeadLimits) {
        let units = |microsteps| i64::from(microsteps) * UNITS_PER_STEP;
        self.field = field.min(units(limits.highest)).max(units(limits.lowest));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const STILL: LeadLimits = LeadLimits { lowest: -256, highest: 256 };

    fn correction(max_velocity_pps: u32) -> Correction {
        Correction { proportional: 10_000, max_following_error: 0, max_velocity_pps }
    }

    /// A ramp at `velocity_pps` for so many control periods, the rotor held.
    fn blocked(leads: &mut Leads, velocity_pps: i64, ticks: i64) {
        let per_tick = velocity_pps / TICKS_PER_SECOND;
        for _ in 0..ticks {
            leads.ramp_moved(per_tick);
            leads.follow(per_tick * UNITS_PER_STEP, &correction(100_000), STILL);
        }
    }

    #[test]
    fn without_an_overload_the_field_goes_with_the_ramp() {
        let mut leads = Leads::default();
        for _ in 0..1000 {
            leads.rotor_moved(3);
            leads.ramp_moved(3);
            leads.follow(3 * UNITS_PER_STEP, &correction(0), STILL);
        }
        // The largest velocity is 0: it stayed where the rotor left it.
        assert_eq!((leads.ramp(), leads.field()), (0, -256));
        let mut leads = Leads::default();
        for _ in 0..1000 {
            leads.rotor_moved(3);
            leads.ramp_moved(3);
            leads.follow(3 * UNITS_PER_STEP, &correction(60_000), STILL);
        }
        assert_eq!((leads.ramp(), leads.field()), (0, 0));
    }

    #[test]
    fn the_field_waits_for_a_blocked_rotor_and_the_ramp_does_not() {
        let mut leads = Leads::default();
        blocked(&mut leads, 40_000, 500);
        assert_eq!((leads.ramp(), leads.field()), (1000, 256));
    }

    #[test]
    fn a_lag_is_made_up_for_at_the_largest_velocity_and_then_in_proportion() {
        let mut leads = Leads::default();
        blocked(&mut leads, 40_000, 5000);
        assert_eq!(leads.ramp(), 10_000);
        // Freed, the rotor goes with the field: 100 000 pps are 5 µsteps a control period.
        for _ in 0..100 {
            let before = leads.field();
            leads.rotor_moved(5);
            leads.follow(0, &correction(100_000), STILL);
            assert_eq!(leads.field(), before, "as fast as the rotor");
        }
        assert_eq!(leads.ramp(), 9500);
        for _ in 0..20_000 {
            let field = leads.field();
            leads.rotor_moved(i64::from(field.signum()).min(leads.ramp()));
            leads.follow(0, &correction(100_000), STILL);
        }
        assert_eq!(leads.ramp(), 0);
        assert!(leads.field().abs() <= 1, "{leads:?}");
    }

    #[test]
    fn a_small_lag_may_be_left_alone() {
        let mut leads = Leads { ramp: 100, ..Leads::default() };
        let lazy = Correction { max_following_error: 100, ..correction(100_000) };
        for _ in 0..1000 {
            leads.follow(0, &lazy, STILL);
        }
        assert_eq!(leads.field(), 0);
    }

    #[test]
    fn gamma_extends_the_lead_on_the_side_of_motion_only() {
        let limits = LeadLimits::new(100, -5);
        assert_eq!([1, 0, -1].map(|direction| limits.towards(direction)), [256, 0, -356]);
    }

    #[test]
    fn in_velocity_mode_an_overload_is_forgotten() {
        let mut leads = Leads::default();
        leads.ramp_moved(100_000);
        leads.follow_closely(STILL);
        assert_eq!((leads.ramp(), leads.field()), (768, 256));
    }

    #[test]
    fn what_was_given_way_is_known_until_the_overload_is_over() {
        let mut leads = Leads::default();
        for _ in 0..100 {
            leads.ramp_moved(50);
            leads.follow_closely(STILL);
        }
        assert_eq!((leads.ramp(), leads.shortfall()), (768, 5000));
        leads.rotor_moved(200);
        leads.follow_closely(STILL);
        assert_eq!((leads.ramp(), leads.shortfall()), (568, 4800));
        leads.rotor_moved(56);
        leads.follow_closely(STILL);
        assert_eq!((leads.ramp(), leads.shortfall()), (512, 512));
    }

    proptest! {
        #[test]
        fn the_field_stays_within_its_limits_and_nothing_overflows(
            steps in proptest::collection::vec((any::<i64>(), any::<i32>(), any::<u32>(), any::<u32>(), 0..=255_i32), 1..50),
        ) {
            let mut leads = Leads::default();
            for (rotor, ramp, proportional, error, gamma) in steps {
                let limits = LeadLimits::new(gamma, ramp);
                leads.rotor_moved(rotor);
                leads.ramp_moved(ramp.into());
                let correction = Correction { proportional, max_following_error: error, max_velocity_pps: proportional };
                leads.follow(i64::from(ramp) * UNITS_PER_STEP, &correction, limits);
                prop_assert!((limits.lowest..=limits.highest).contains(&leads.field()));
                leads.follow_closely(limits);
                prop_assert!((limits.lowest..=limits.highest).contains(&leads.field()));
                prop_assert!(leads.ramp().abs() <= 768);
            }
        }
    }
}
