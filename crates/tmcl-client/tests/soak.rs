//! A minute of the day that `examples/soak` lives through, and that the same seed is the same minute.

#[path = "common/bus.rs"]
mod bus;
#[path = "../examples/soak/checksum.rs"]
mod checksum;
#[path = "../examples/soak/host.rs"]
mod host;
#[path = "../examples/soak/model.rs"]
mod model;
#[path = "common/random.rs"]
mod random;
#[path = "../examples/soak/soak.rs"]
mod soak;

use std::time::Duration;

const MINUTE: Duration = Duration::from_secs(60);

#[test]
fn nothing_is_lost_in_a_minute() {
    for seed in 1..=5 {
        soak::Soak::new(seed).run_until(MINUTE);
    }
}

#[test]
fn the_same_seed_is_the_same_minute() {
    let report = |seed| {
        let mut soak = soak::Soak::new(seed);
        soak.run_until(MINUTE);
        soak.report()
    };
    assert_eq!(report(7), report(7));
    assert_ne!(report(7), report(8));
}
