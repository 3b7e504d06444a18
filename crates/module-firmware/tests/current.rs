//! What is commanded of the driver, whatever is written and in whatever loop: never more than AP 6, or AP 200 in open loop, and
//! nothing with the driver off.

use module_firmware::tmcm_1311::{AxisParameter as Ap, DriverStatus, Sensed, Tmcm1311};
use module_firmware::{Axis, Events, Motion};
use proptest::prelude::*;

/// What a host may do, and what may happen.
#[derive(Clone, Debug)]
enum Step {
    Write(Ap, i32),
    Motion(Motion),
    Encoder(i32),
    /// A whole initialisation, with an encoder that follows the field.
    CloseLoop,
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

/// What leads into closed loop and out of it, and what only means something there.
fn write_closed_loop() -> impl Strategy<Value = Step> {
    prop_oneof![
        (0..=1).prop_map(|on| Step::Write(Ap::ClosedLoopMode, on)),
        (0..=1).prop_map(|on| Step::Write(Ap::EncoderInitialization, on)),
        (-3000..=3000).prop_map(|current_ma| Step::Write(Ap::TorqueTargetCurrent, current_ma)),
        (-3000..=3000).prop_map(|current_ma| Step::Write(Ap::TorqueActualCurrent, current_ma)),
        (0..=255).prop_map(|scale| Step::Write(Ap::CurrentScaleMax, scale)),
        (0..=1).prop_map(|on| Step::Write(Ap::CurrentScaleEnable, on)),
    ]
}

fn step() -> impl Strategy<Value = Step> {
    prop_oneof![
        2 => write(),
        4 => write_current(),
        3 => write_closed_loop(),
        1 => Just(Step::CloseLoop),
        1 => (-100_000..100_000).prop_map(|velocity| Step::Motion(Motion::Rotate(velocity))),
        1 => (-20_000..20_000).prop_map(|offset| Step::Motion(Motion::MoveBy(offset))),
        1 => Just(Step::Motion(Motion::Stop)),
        1 => (-1000..1000).prop_map(Step::Encoder),
        6 => (1_u32..3000).prop_map(Step::Ticks),
    ]
}

/// What the axis is asked, and what is known of it without asking its insides.
struct Driven {
    axis: Tmcm1311,
    sensed: Sensed,
    /// How long it has stood on its target, and whether the power is cut for it.
    rested: u32,
    cut: bool,
}

impl Driven {
    fn new() -> Self {
        let driver = DriverStatus { stallguard: 500, ..Default::default() };
        let sensed = Sensed { driver, ..Default::default() };
        Self { axis: Tmcm1311::default(), sensed, rested: 0, cut: false }
    }

    fn is_open_loop(&self) -> bool {
        self.axis.get(Ap::ClosedLoopMode) == 0 && self.axis.get(Ap::EncoderInitialization) != 1
    }

    fn take(&mut self, step: &Step) {
        match *step {
            // What is refused has changed nothing.
            Step::Write(parameter, value) => {
                let moves = matches!(
                    parameter,
                    Ap::TargetPosition
                        | Ap::TargetVelocity
                        | Ap::RampMode
                        | Ap::ClosedLoopMode
                        | Ap::EncoderInitialization
                );
                if self.axis.set(parameter, value).is_ok() && moves {
                    (self.rested, self.cut) = (0, false);
                }
            }
            Step::Motion(motion) => {
                if self.axis.motion(motion).is_ok() {
                    (self.rested, self.cut) = (0, false);
                }
            }
            Step::Encoder(counts) => self.sensed.encoder_counts = counts,
            Step::Ticks(ticks) => (0..ticks).for_each(|_| self.tick()),
            Step::CloseLoop => self.close_loop(),
        }
    }

    /// The field goes from 90° to 0°, and the encoder by the full step that AP 202 and AP 210 make it.
    fn close_loop(&mut self) {
        if self.axis.set(Ap::ClosedLoopMode, 1).is_err() {
            return;
        }
        let full_step = self.axis.get(Ap::EncoderResolution) / self.axis.get(Ap::MotorFullSteps).max(1);
        (0..10_000).for_each(|_| self.tick());
        self.sensed.encoder_counts = self.sensed.encoder_counts.wrapping_sub(full_step);
        (0..10_001).for_each(|_| self.tick());
    }

    fn tick(&mut self) {
        let stood = self.axis.is_position_reached() && self.is_open_loop();
        let drive = self.axis.tick(&self.sensed, &mut Events::default());
        let get = |parameter| self.axis.get(parameter);
        let boost = if self.is_open_loop() { get(Ap::BoostCurrent) } else { 0 };
        assert!(i32::from(drive.chip.current_scale) <= get(Ap::MaxCurrent).max(boost) / 8, "{drive:?}");
        let [a, b] = drive.coils.map(i32::from);
        assert!(a * a + b * b <= 249 * 249, "{drive:?}");
        if get(Ap::ChopperOffTime) == 0 {
            assert_eq!(drive.chip.off_time, 0);
        }
        if stood && self.axis.is_position_reached() && self.is_open_loop() {
            let delay = get(Ap::FreewheelingDelay).unsigned_abs() * 20;
            self.cut |= delay != 0 && self.rested >= delay;
            self.rested += 1;
        } else {
            (self.rested, self.cut) = (0, false);
        }
        if self.cut {
            assert_eq!(drive.chip.off_time, 0);
        }
    }
}

#[test]
fn the_steps_lead_into_closed_loop() {
    let mut driven = Driven::new();
    driven.take(&Step::CloseLoop);
    assert_eq!(driven.axis.get(Ap::ClosedLoopInitialized), 1);
}

proptest! {
    #[test]
    fn the_commanded_current_is_within_its_limits(steps in proptest::collection::vec(step(), 1..60)) {
        let mut driven = Driven::new();
        for step in &steps {
            driven.take(step);
        }
    }
}
