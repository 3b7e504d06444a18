extern crate std;

use std::vec::Vec;

use proptest::prelude::*;

use super::*;

/// The defaults of the TMCM-1311, a step in each millisecond.
const DEFAULTS: CurrentScaleSettings = CurrentScaleSettings {
    minimum: 15,
    maximum: 255,
    lower_error: 0,
    upper_error: 255,
    increment: 1,
    decrement: 1,
    increment_ticks: 20,
    decrement_ticks: 20,
};

fn settings() -> impl Strategy<Value = CurrentScaleSettings> {
    let factors = (any::<u8>(), any::<u8>());
    let errors = prop_oneof![(0_u32..400, 0_u32..400), (any::<u32>(), any::<u32>())];
    (factors, errors, (any::<u8>(), any::<u8>()), (0_u32..30, 0_u32..30)).prop_map(
        |(factors, errors, steps, ticks)| CurrentScaleSettings {
            minimum: factors.0,
            maximum: factors.1,
            lower_error: errors.0,
            upper_error: errors.1,
            increment: steps.0,
            decrement: steps.1,
            increment_ticks: ticks.0,
            decrement_ticks: ticks.1,
        },
    )
}

#[test]
fn the_target_is_linear_between_the_limits() {
    let settings =
        CurrentScaleSettings { lower_error: 100, upper_error: 300, minimum: 50, maximum: 250, ..DEFAULTS };
    for (error, expected) in
        [(0, 50), (100, 50), (101, 51), (200, 150), (299, 249), (300, 250), (u32::MAX, 250)]
    {
        assert_eq!(target(error, &settings), expected, "{error}");
    }
    let falling = CurrentScaleSettings { minimum: 250, maximum: 50, ..settings };
    for (error, expected) in [(0, 250), (101, 249), (200, 150), (299, 51), (300, 50)] {
        assert_eq!(target(error, &falling), expected, "{error}");
    }
}

#[test]
fn limits_the_wrong_way_round_are_a_step_after_the_lower_one() {
    for upper_error in [0, 99, 100, 101] {
        let settings = CurrentScaleSettings { lower_error: 100, upper_error, ..DEFAULTS };
        assert_eq!([99, 100, 101, 102].map(|error| target(error, &settings)), [15, 15, 255, 255]);
    }
    let at_the_end = CurrentScaleSettings { lower_error: u32::MAX, upper_error: 0, ..DEFAULTS };
    assert_eq!(target(u32::MAX, &at_the_end), 15);
}

#[test]
fn the_first_step_is_immediate_and_each_further_one_waits() {
    let mut scale = CurrentScale::new(15);
    let factors: Vec<u8> = (0..41)
        .map(|_| {
            scale.tick(1000, &DEFAULTS);
            scale.actual()
        })
        .collect();
    assert_eq!([0, 19, 20, 39, 40].map(|tick: usize| factors[tick]), [16, 16, 17, 17, 18]);
    assert_eq!(scale.target(), 255);
}

#[test]
fn a_delay_of_zero_goes_there_at_once() {
    let settings = CurrentScaleSettings { increment_ticks: 0, increment: 0, ..DEFAULTS };
    let mut scale = CurrentScale::new(15);
    scale.tick(1000, &settings);
    assert_eq!(scale.actual(), 255);
    (0..20).for_each(|_| scale.tick(0, &settings));
    assert_eq!((scale.actual(), scale.target()), (254, 15));
}

#[test]
fn an_increase_does_not_wait_for_the_delay_of_the_decrease() {
    let settings = CurrentScaleSettings { decrement_ticks: 20_000, ..DEFAULTS };
    let mut scale = CurrentScale::new(200);
    scale.tick(0, &settings);
    assert_eq!(scale.actual(), 199);
    (0..20).for_each(|_| scale.tick(1000, &settings));
    assert_eq!(scale.actual(), 200);
}

#[test]
fn a_step_of_zero_never_moves() {
    let settings = CurrentScaleSettings { increment: 0, ..DEFAULTS };
    let mut scale = CurrentScale::new(15);
    (0..1000).for_each(|_| scale.tick(1000, &settings));
    assert_eq!(scale.actual(), 15);
}

#[test]
fn off_is_full_at_once_and_comes_back_without_waiting() {
    let mut scale = CurrentScale::new(15);
    scale.tick(1000, &DEFAULTS);
    scale.full();
    assert_eq!((scale.actual(), scale.target()), (255, 255));
    scale.tick(0, &DEFAULTS);
    assert_eq!(scale.actual(), 254);
}

#[test]
fn scaling_rounds_halves_away_from_zero() {
    for (value, factor, expected) in [
        (1000, 255, 1000),
        (1000, 127, 500),
        (1, 127, 1),
        (-1, 127, -1),
        (1, 126, 0),
        (i16::MIN, 255, i16::MIN),
        (i16::MIN, 0, -128),
        (i16::MAX, 255, i16::MAX),
    ] {
        assert_eq!(scaled(value, factor), expected, "{value} by {factor}");
    }
}

proptest! {
    #[test]
    fn scaling_is_the_nearest_and_alike_in_both_directions(value: i16, factor: u8) {
        let result = scaled(value, factor);
        let error = i32::from(result) * 256 - i32::from(value) * (i32::from(factor) + 1);
        prop_assert!(error.abs() <= 128);
        prop_assert!(result.unsigned_abs() <= value.unsigned_abs());
        if let Some(mirrored) = value.checked_neg() {
            prop_assert_eq!(scaled(mirrored, factor), -result);
        }
    }

    /// The target is the nearest factor to the straight line, also where 32 bits do not do.
    #[test]
    fn the_target_is_on_the_line(settings in settings(), error: u32, share in 0_u64..=256) {
        let (lower, upper) = (u64::from(settings.lower_error), u64::from(settings.upper_error));
        let between = lower + upper.saturating_sub(lower) * share / 256;
        for error in [error, between as u32] {
            let target = i128::from(target(error, &settings));
            let (minimum, maximum) = (i128::from(settings.minimum), i128::from(settings.maximum));
            let span = i128::from(upper.max(lower + 1) - lower);
            let above = (i128::from(error) - i128::from(lower)).clamp(0, span);
            let off = (target - minimum) * span - (maximum - minimum) * above;
            prop_assert!(2 * off.abs() <= span, "{target} at {error}");
        }
    }

    /// Between two ticks the factor moves towards the target and not past it, never by more than a step, and never sooner
    /// after a step than its delay.
    #[test]
    fn steps_keep_size_and_delay(
        start: u8,
        settings in settings(),
        errors in proptest::collection::vec((prop_oneof![0_u32..500, any::<u32>()], 1_u32..60), 1..20),
    ) {
        let mut scale = CurrentScale::new(start);
        let mut since_step = u32::MAX;
        for (error, ticks) in errors {
            for _ in 0..ticks {
                let before = scale.actual();
                scale.tick(error, &settings);
                since_step = since_step.saturating_add(1);
                let (target, actual) = (scale.target(), scale.actual());
                prop_assert!((before.min(target)..=before.max(target)).contains(&actual));
                let (step, delay) = if target > before {
                    (settings.increment, settings.increment_ticks)
                } else {
                    (settings.decrement, settings.decrement_ticks)
                };
                let due = since_step >= delay;
                let expected = if delay == 0 { u8::MAX } else if due { step } else { 0 }.min(target.abs_diff(before));
                prop_assert_eq!(actual.abs_diff(before), expected);
                since_step = if actual == before { since_step } else { 0 };
            }
        }
    }

    #[test]
    fn once_the_delays_are_over_rest_is_exact(start: u8, settings in settings(), error in 0_u32..500) {
        let mut scale = CurrentScale::new(start);
        for _ in 0..20_000 {
            scale.tick(error, &settings);
        }
        let before = scale;
        scale.tick(error, &settings);
        prop_assert_eq!(before, scale);
    }
}
