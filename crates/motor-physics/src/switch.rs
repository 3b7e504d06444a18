//! A limit switch: a normally closed contact that opens over a stretch of travel, and bounces.

/// How long the contact stays in one state while it bounces.
const BOUNCE_SLOT_NS: u64 = 20_000;

/// Where a switch is, and how it bounces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SwitchConfig {
    /// Where the stretch begins in which it is active; may be −∞.
    pub from_turns: f64,
    /// Where that stretch ends; may be +∞.
    pub to_turns: f64,
    /// How long the contact bounces after a change.
    pub bounce_ns: u64,
}

/// What is broken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SwitchFault {
    /// Nothing.
    #[default]
    None,
    /// The contact never closes, or its wire is cut.
    StuckOpen,
    /// The contact never opens.
    StuckClosed,
}

/// A switch beside the travel.
#[derive(Clone, Debug, PartialEq)]
pub struct LimitSwitch {
    config: SwitchConfig,
    /// What is broken; may be changed in operation.
    pub fault: SwitchFault,
    active: bool,
    changed_at_ns: u64,
    settled_at_ns: u64,
}

impl LimitSwitch {
    /// A switch at rest while the shaft is at `turns`.
    #[must_use]
    pub fn new(config: SwitchConfig, turns: f64) -> Self {
        let active = config.contains(turns);
        Self { config, fault: SwitchFault::None, active, changed_at_ns: 0, settled_at_ns: 0 }
    }

    /// Whether the contact is closed, with the shaft at `turns`. Time must not run backwards.
    pub fn sample(&mut self, turns: f64, now_ns: u64) -> bool {
        let active = self.config.contains(turns);
        if active != self.active {
            self.active = active;
            self.changed_at_ns = now_ns;
            self.settled_at_ns = now_ns.saturating_add(self.config.bounce_ns);
        }
        match self.fault {
            SwitchFault::StuckOpen => false,
            SwitchFault::StuckClosed => true,
            SwitchFault::None if now_ns < self.settled_at_ns => self.bounces_closed(now_ns),
            SwitchFault::None => !active,
        }
    }

    /// From when on only the shaft's position can change the contact.
    #[must_use]
    pub fn settled_at_ns(&self) -> u64 {
        self.settled_at_ns
    }

    /// A coin toss that falls the same way in every run.
    fn bounces_closed(&self, now_ns: u64) -> bool {
        let slot = (now_ns - self.changed_at_ns) / BOUNCE_SLOT_NS;
        mixed(self.changed_at_ns ^ mixed(slot)) & 1 == 1
    }
}

impl SwitchConfig {
    fn contains(&self, turns: f64) -> bool {
        (self.from_turns..=self.to_turns).contains(&turns)
    }
}

/// The mixing function of SplitMix64: every bit of the result depends on every bit of `bits`.
fn mixed(bits: u64) -> u64 {
    let bits = bits.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    bits ^ (bits >> 31)
}

#[cfg(test)]
mod tests {
    extern crate std;

    use std::vec::Vec;

    use super::*;

    const LEFT: SwitchConfig =
        SwitchConfig { from_turns: f64::NEG_INFINITY, to_turns: -1.0, bounce_ns: 2_000_000 };

    #[test]
    fn the_contact_opens_over_its_stretch() {
        let mut switch = LimitSwitch::new(SwitchConfig { bounce_ns: 0, ..LEFT }, 0.0);
        let closed = [0.0, -0.99, -1.0, -50.0, 3.0].map(|turns| switch.sample(turns, 5));
        assert_eq!(closed, [true, true, false, false, true]);
    }

    #[test]
    fn it_bounces_for_so_long_and_the_same_every_time() {
        let contact = |start_ns: u64| {
            let mut switch = LimitSwitch::new(LEFT, 0.0);
            assert!(switch.sample(0.0, start_ns));
            let bounces: Vec<_> =
                (0..100).map(|slot| switch.sample(-2.0, start_ns + slot * 20_000)).collect();
            assert_eq!(switch.settled_at_ns(), start_ns + 2_000_000);
            assert!(!switch.sample(-2.0, switch.settled_at_ns()), "settled open");
            bounces
        };
        let bounces = contact(1_000);
        let changes = bounces.windows(2).filter(|pair| pair[0] != pair[1]).count();
        assert!((20..80).contains(&changes), "{changes} changes");
        assert_eq!(contact(1_000), bounces);
        assert_ne!(contact(2_000), bounces);
    }

    #[test]
    fn how_often_it_is_looked_at_does_not_matter() {
        let mut often = LimitSwitch::new(LEFT, -2.0);
        let mut seldom = often.clone();
        for step in 0..4000 {
            let now_ns = step * 1_000;
            let closed = often.sample(0.0, now_ns);
            if step % 50 == 0 {
                assert_eq!(seldom.sample(0.0, now_ns), closed);
            }
        }
        assert_eq!(often, seldom);
    }

    #[test]
    fn a_broken_switch_shows_one_state_only() {
        for (fault, closed) in [(SwitchFault::StuckOpen, false), (SwitchFault::StuckClosed, true)] {
            let mut switch = LimitSwitch::new(LEFT, 0.0);
            switch.fault = fault;
            let shown = [0.0, -2.0, 0.0].map(|turns| switch.sample(turns, 0));
            assert_eq!(shown, [closed; 3]);
        }
    }
}
