//! What is commanded of the driver, whatever is written: never more than AP 6 or AP 200, and nothing with the driver off
//! (issue 5).

use module_firmware::tmcm_1311::{AxisParameter as Ap, DriverStatus, Sensed, Tmcm1311};
use module_firmware::{Axis, Events, Motion};
use proptest::prelude::*;

/// What a host may do, and what may happen.
#[derive(Clone, Debug)]
enum Step {
    Write(Ap, i32),
    Motion(Motion),
    Encoder(i32),
    Ticks(u32),
}

/// Any value of any parameter that may be written.
fn write() -> impl Strategy<Value = Step> {
    let writable: Vec<Ap> =
        Ap::ALL.iter().copied().filter(|parameter| parameter.spec().access.write).collect();
    (proptest::sample::select(writable), any::<i32>(), any::<proptest::sample::Index>()).prop_map(
        |(parameter, bits, index)| {
            let spec = parameter.spec();
            let value = [bits, bits % 256, bits % 16, i32::from(bits % 2 == 0)][index.index(4)];
            let fits = spec.range.contains(spec.from_wire(value));
            Step::Write(parameter, if fits { value } else { spec.default_bits() })
        },
    )
}

/// The parameters that decide about the current, in the ranges in which something happens.
fn write_current() -> impl Strategy<Value = Step> {
    let currents = vec![Ap::MaxCurrent, Ap::StandbyCurrent, Ap::BoostCurrent, Ap::CoolstepSlowRunCurrent];
    prop_oneof![
        (proptest::sample::select(currents), 0..=255)
            .prop_map(|(parameter, value)| Step::Write(parameter, value)),
        (2..=15).prop_map(|value| Step::Write(Ap::ChopperOffTime, value)),
        Just(Step::Write(Ap::ChopperOffTime, 0)),
        (0..=15).prop_map(|value| Step::Write(Ap::CoolstepHysteresisStart, value)),
        (1..=5).prop_map(|value| Step::Write(Ap::PowerDownDelay, value)),
        (0..=60).prop_map(|value| Step::Write(Ap::FreewheelingDelay, value)),
        (0..=100_000).prop_map(|value| Step::Write(Ap::MaxVelocity, value)),
        (-500..=500).prop_map(|value| Step::Write(Ap::MaxEncoderDeviation, value)),
    ]
}

fn step() -> impl Strategy<Value = Step> {
    prop_oneof![
        2 => write(),
        4 => write_current(),
        1 => (-100_000..100_000).prop_map(|velocity| Step::Motion(Motion::Rotate(velocity))),
        1 => (-20_000..20_000).prop_map(|offset| Step::Motion(Motion::MoveBy(offset))),
        1 => Just(Step::Motion(Motion::Stop)),
        1 => (-1000..1000).prop_map(Step::Encoder),
        6 => (1_u32..3000).prop_map(Step::Ticks),
    ]
}

proptest! {
    #[test]
    fn the_commanded_current_is_within_its_limits(steps in proptest::collection::vec(step(), 1..60)) {
        let mut axis = Tmcm1311::default();
        let mut sensed = Sensed { driver: DriverStatus { stallguard: 500, ..Default::default() }, ..Default::default() };
        // Told apart from the firmware's own: how long it has stood on its target, and whether the power is cut for it.
        let (mut rested, mut cut) = (0_u32, false);
        for step in steps {
            match step {
                // What is refused has changed nothing.
                Step::Write(parameter, value) => {
                    let moves = matches!(parameter, Ap::TargetPosition | Ap::TargetVelocity | Ap::RampMode);
                    if axis.set(parameter, value).is_ok() && moves {
                        (rested, cut) = (0, false);
                    }
                }
                Step::Motion(motion) => {
                    axis.motion(motion).expect("open loop refuses no motion");
                    (rested, cut) = (0, false);
                }
                Step::Encoder(counts) => sensed.encoder_counts = counts,
                Step::Ticks(ticks) => {
                    for _ in 0..ticks {
                        let stood = axis.is_position_reached();
                        let drive = axis.tick(&sensed, &mut Events::default());
                        let limit = axis.get(Ap::MaxCurrent).max(axis.get(Ap::BoostCurrent)) / 8;
                        prop_assert!(i32::from(drive.chip.current_scale) <= limit);
                        if axis.get(Ap::ChopperOffTime) == 0 {
                            prop_assert_eq!(drive.chip.off_time, 0);
                        }
                        if stood && axis.is_position_reached() {
                            let delay = axis.get(Ap::FreewheelingDelay).unsigned_abs() * 20;
                            cut |= delay != 0 && rested >= delay;
                            rested += 1;
                        } else {
                            (rested, cut) = (0, false);
                        }
                        if cut {
                            prop_assert_eq!(drive.chip.off_time, 0);
                        }
                    }
                }
            }
        }
    }
}
