//! The TMCM-1640's axis, whatever is written to it and whatever its sensors say: it never panics, commands what a bridge can do,
//! and nothing while something forbids it. And what whole modules hardly show of its initialisation.

use module_firmware::tmcm_1640::{AxisParameter as Ap, Drive, PWM_PERIOD, Sensed, Tmcm1640};
use module_firmware::{Axis, Events, Motion};
use proptest::prelude::*;

/// What a host may do, and what may happen.
#[derive(Clone, Debug)]
enum Step {
    Write(Ap, i32),
    Motion(Motion),
    Sensed(Sensed),
    /// So many control periods, in which the encoder counts and the hall sensors pass sectors.
    Turning {
        ticks: u32,
        counts: i32,
        sector_every: u32,
    },
    /// So long nothing comes from the sensors that was not there before, and then for so long nobody looks.
    Rest {
        ticks: u32,
        skipped: u64,
    },
}

/// Numbers of all sizes, and the ends.
fn number() -> impl Strategy<Value = i32> {
    prop_oneof![
        4 => any::<i32>(),
        4 => -300..5000,
        2 => 0..4,
        1 => proptest::sample::select(vec![i32::MIN, i32::MIN + 1, -1, i32::MAX]),
    ]
}

fn write() -> impl Strategy<Value = Step> {
    let writable: Vec<Ap> =
        Ap::ALL.iter().copied().filter(|parameter| parameter.spec().access.write).collect();
    (proptest::sample::select(writable), number()).prop_map(|(parameter, value)| {
        let spec = parameter.spec();
        // Of small ranges each value is met.
        let small = [value, value.rem_euclid(256), value.rem_euclid(4), value.rem_euclid(2)];
        let fits = small.into_iter().find(|value| spec.range.contains(spec.from_wire(*value)));
        Step::Write(parameter, fits.unwrap_or(spec.default_bits()))
    })
}

/// What leads into each mode, and lets the power stage be on and off.
fn mode() -> impl Strategy<Value = Step> {
    prop_oneof![
        (6..=7).prop_map(|mode| Step::Write(Ap::CommutationMode, mode)),
        (0..=2).prop_map(|mode| Step::Write(Ap::InitSineMode, mode)),
        (0..100).prop_map(|delay| Step::Write(Ap::InitSineDelay, delay)),
        Just(Step::Write(Ap::ReinitCommutation, 0)),
        (0..=1).prop_map(|on| Step::Write(Ap::EnableDriver, on)),
        Just(Step::Write(Ap::I2tLimit, -1)),
        Just(Step::Write(Ap::ThermalWindingTimeConstant, 0)),
        Just(Step::Write(Ap::ClearI2tFlag, 0)),
        number().prop_map(|current_ma| Step::Write(Ap::TargetCurrent, current_ma)),
        number().prop_map(|velocity| Step::Motion(Motion::Rotate(velocity))),
        number().prop_map(|position| Step::Motion(Motion::MoveTo(position))),
        number().prop_map(|offset| Step::Motion(Motion::MoveBy(offset))),
        Just(Step::Motion(Motion::Stop)),
    ]
}

fn sensed() -> impl Strategy<Value = Step> {
    let voltage_dv = prop_oneof![4 => 200_u16..300, 1 => any::<u16>(), 1 => 285_u16..305];
    let adc = prop_oneof![4 => 500_u16..1500, 1 => any::<u16>(), 1 => 2700_u16..2840];
    let error = proptest::bool::weighted(0.1);
    let currents = prop_oneof![(-3000_i16..3000, -3000_i16..3000).boxed(), any::<(i16, i16)>().boxed()];
    (currents, any::<(i16, u8, i32, bool, u8, u16)>(), voltage_dv, adc, error).prop_map(
        |(
            (u, v),
            (w, halls, encoder_counts, encoder_index, inputs, analog_input),
            voltage_dv,
            adc,
            error,
        )| {
            Step::Sensed(Sensed {
                phase_currents_ma: [u, v, w],
                halls,
                encoder_counts,
                encoder_index,
                supply_voltage_dv: voltage_dv,
                driver_temperature_adc: adc,
                driver_error: error,
                inputs,
                analog_input,
            })
        },
    )
}

fn step() -> impl Strategy<Value = Step> {
    prop_oneof![
        4 => write(),
        4 => mode(),
        2 => sensed(),
        4 => (1_u32..600, prop_oneof![-20..20, any::<i32>()], 1_u32..200)
            .prop_map(|(ticks, counts, sector_every)| Step::Turning { ticks, counts, sector_every }),
        1 => (9_990_u32..10_100, 1_u64..3000).prop_map(|(ticks, skipped)| Step::Rest { ticks, skipped }),
    ]
}

const RESTING: Sensed = Sensed {
    phase_currents_ma: [0; 3],
    halls: 0b001,
    encoder_counts: 0,
    encoder_index: false,
    supply_voltage_dv: 240,
    driver_temperature_adc: 739,
    driver_error: false,
    inputs: 0,
    analog_input: 0,
};

struct Driven {
    axis: Tmcm1640,
    sensed: Sensed,
}

impl Driven {
    fn new() -> Self {
        Self { axis: Tmcm1640::default(), sensed: RESTING }
    }

    fn set(&mut self, parameter: Ap, value: i32) {
        self.axis.set(parameter, value).expect("never refused");
    }

    fn take(&mut self, step: &Step) {
        match *step {
            Step::Write(parameter, value) => self.set(parameter, value),
            Step::Motion(motion) => self.axis.motion(motion).expect("never refused"),
            Step::Sensed(sensed) => self.sensed = sensed,
            Step::Turning { ticks, counts, sector_every } => {
                const SECTORS: [u8; 6] = [0b001, 0b011, 0b010, 0b110, 0b100, 0b101];
                for tick in 0..ticks {
                    self.sensed.encoder_counts = self.sensed.encoder_counts.wrapping_add(counts);
                    self.sensed.halls = SECTORS[(tick / sector_every % 6) as usize];
                    self.sensed.encoder_index = tick % 97 == 96;
                    self.tick();
                }
            }
            Step::Rest { ticks, skipped } => {
                self.sensed.encoder_index = false;
                self.run(ticks);
                self.skip(skipped);
            }
        }
        self.read_all();
    }

    fn run(&mut self, ticks: u32) {
        (0..ticks).for_each(|_| self.tick());
    }

    /// At rest, many control periods at once are the same as one by one.
    fn skip(&mut self, ticks: u64) {
        if !self.axis.is_idle(&self.sensed) {
            return;
        }
        let mut skipped = Self { axis: self.axis.clone(), sensed: self.sensed };
        let ticks = ticks.min(self.axis.quiet_ticks());
        (0..ticks).for_each(|_| self.tick());
        skipped.axis.skip(ticks);
        self.sensed.phase_currents_ma = [100, -50, -50];
        skipped.sensed = self.sensed;
        for _ in 0..100 {
            let [one, other] = [&mut *self, &mut skipped]
                .map(|driven| driven.axis.tick(&driven.sensed, &mut Events::default()));
            assert_eq!(one, other, "{ticks} ticks");
            for parameter in Ap::ALL.iter().filter(|parameter| parameter.spec().access.read) {
                assert_eq!(self.axis.get(*parameter), skipped.axis.get(*parameter), "{parameter:?}");
            }
        }
    }

    fn tick(&mut self) {
        let drive = self.axis.tick(&self.sensed, &mut Events::default());
        self.judge(&drive);
    }

    /// What is commanded, by what is written, sensed and read.
    fn judge(&self, drive: &Drive) {
        assert!(drive.duties.iter().all(|duty| *duty <= PWM_PERIOD), "{drive:?}");
        let flags = self.axis.get(Ap::StatusFlags);
        let is_set = |bit: u32| flags >> bit & 1 == 1;
        let (voltage_dv, adc) = (self.sensed.supply_voltage_dv, self.sensed.driver_temperature_adc);
        assert!(!self.sensed.driver_error || is_set(6));
        assert!(adc < 2827 || is_set(3));
        assert_eq!(is_set(1), voltage_dv < 100);
        let protects = self.axis.get(Ap::OvervoltageProtection) == 1;
        assert!(if protects { voltage_dv <= 300 || is_set(2) } else { !is_set(2) });
        let forbidden = self.axis.get(Ap::EnableDriver) == 0 || [1, 2, 3, 6, 17].into_iter().any(is_set);
        assert_eq!(drive.enabled, !forbidden, "{drive:?} with flags {flags:#b}");
        if forbidden {
            assert_eq!(drive.duties, [0; 3]);
        }
        let wanted_ma = self.axis.get(Ap::TargetCurrent).unsigned_abs();
        let torque = is_set(11);
        assert!(torque || wanted_ma <= self.axis.get(Ap::MaxCurrent).cast_unsigned(), "{wanted_ma} mA");
    }

    /// Whatever can be read is in the range that the tables promise.
    fn read_all(&self) {
        for parameter in Ap::ALL.iter().filter(|parameter| parameter.spec().access.read) {
            let (spec, value) = (parameter.spec(), self.axis.get(*parameter));
            assert!(spec.range.contains(spec.from_wire(value)), "{parameter:?} = {value}");
        }
    }
}

proptest! {
    #[test]
    fn whatever_is_written_and_sensed_the_bridge_is_driven_as_allowed(
        steps in proptest::collection::vec(step(), 1..60),
    ) {
        let mut driven = Driven::new();
        for step in &steps {
            driven.take(step);
        }
    }
}

#[test]
fn the_steps_lead_to_rest() {
    let mut driven = Driven::new();
    driven.take(&Step::Rest { ticks: 10_100, skipped: 100 });
    driven.sensed = RESTING;
    driven.run(100);
    assert!(driven.axis.is_idle(&driven.sensed));
}

/// A period that was far too long does not outlast its correction.
#[test]
fn a_shorter_loop_delay_holds_at_once() {
    let mut driven = Driven::new();
    driven.set(Ap::PidLoopDelay, -1);
    driven.set(Ap::CurrentLoopDelay, -1);
    driven.run(100);
    driven.set(Ap::PidLoopDelay, 1);
    driven.set(Ap::CurrentLoopDelay, 2);
    driven.axis.motion(Motion::Rotate(1000)).expect("never refused");
    driven.run(1000);
    assert_eq!(driven.axis.get(Ap::RampVelocity), 100);
    assert_ne!(driven.axis.get(Ap::CurrentPidError), 0);
}

#[test]
fn a_target_current_does_not_wait_for_the_velocity_regulator() {
    let mut driven = Driven::new();
    driven.set(Ap::PidLoopDelay, 1000);
    driven.run(100);
    driven.set(Ap::TargetCurrent, 500);
    driven.run(3);
    assert_eq!(driven.axis.get(Ap::CurrentPidError), 500);
}

/// As the stored settings come at power-on, by their numbers: AP 159 is there before what says how to initialise.
#[test]
fn an_initialisation_has_the_settings_of_when_it_begins() {
    let mut driven = Driven::new();
    for (parameter, value) in [(Ap::CommutationMode, 7), (Ap::InitVelocity, 60), (Ap::InitSineMode, 2)] {
        driven.set(parameter, value);
    }
    // 4 pole pairs at 1 turn/s, 50 ms.
    driven.run(1001);
    let angle = driven.axis.get(Ap::ActualControlledAngle);
    assert!((angle - 13_107).abs() <= 1, "{angle}");
}

/// Far beyond what a motor does the field still turns as AP 241 says.
#[test]
fn any_initialisation_velocity_is_exact() {
    for (rpm, angle_wanted) in [(100_000, 21_845), (-100_000, -21_845), (75_000, 16_384), (i32::MIN, -18_273)]
    {
        let mut driven = Driven::new();
        driven.set(Ap::InitVelocity, rpm);
        driven.set(Ap::InitSineMode, 2);
        driven.set(Ap::CommutationMode, 7);
        driven.run(2);
        let turns = f64::from(rpm) * 4.0 / 1_200_000.0;
        let truth = (turns - turns.round()) * 65_536.0;
        assert!((truth - f64::from(angle_wanted)).abs() <= 1.0, "{truth}");
        let angle = driven.axis.get(Ap::ActualControlledAngle);
        assert!((angle - angle_wanted).abs() <= 1, "{rpm} rpm: {angle}");
    }
}

/// With the power stage off the rotor may go anywhere: the pull begins anew.
#[test]
fn an_interrupted_initialisation_begins_anew() {
    let mut driven = Driven::new();
    driven.set(Ap::CommutationMode, 7);
    driven.run(18_000);
    assert_eq!(driven.axis.get(Ap::ActualControlledAngle), 0, "the second half");
    driven.set(Ap::EnableDriver, 0);
    driven.run(100);
    driven.set(Ap::EnableDriver, 1);
    driven.run(9_000);
    assert_eq!(driven.axis.get(Ap::ActualControlledAngle), 16_384, "the first half");
}

/// The pull takes the rotor from its target, and the end flag goes at once.
#[test]
fn the_end_flag_is_judged_during_an_initialisation() {
    let mut driven = Driven::new();
    driven.set(Ap::CommutationMode, 7);
    driven.axis.motion(Motion::MoveTo(0)).expect("never refused");
    driven.run(2);
    assert_eq!(driven.axis.get(Ap::PositionReached), 1);
    driven.sensed.encoder_counts = 512;
    driven.tick();
    assert_eq!(driven.axis.get(Ap::PositionReached), 0);
    assert_eq!(driven.axis.get(Ap::PositionPidError), -512);
}

/// Turns to the N channel and on, so many counts each.
fn pass_index(driven: &mut Driven, before: i32, after: i32) {
    driven.sensed.encoder_counts += before;
    driven.sensed.encoder_index = true;
    driven.tick();
    driven.sensed.encoder_index = false;
    driven.sensed.encoder_counts += after;
    driven.tick();
}

/// An offset that was stored is a place on the disc: with hall commutation too the N channel leaves it.
#[test]
fn the_first_index_moves_only_an_offset_that_was_found_without_it() {
    let mut stored = Driven::new();
    stored.set(Ap::EncoderCommutationOffset, 819);
    pass_index(&mut stored, 300, 819);
    assert_eq!(stored.axis.get(Ap::EncoderCommutationOffset), 819);
    assert_eq!(stored.axis.get(Ap::ActualEncoderAngle), 0, "there the angle is 0");
    let mut found = Driven::new();
    found.set(Ap::InitSineDelay, 0);
    found.set(Ap::CommutationMode, 7);
    found.run(10);
    assert_eq!(found.axis.get(Ap::EncoderCommutationOffset), 0);
    pass_index(&mut found, 300, 0);
    assert_eq!(found.axis.get(Ap::EncoderCommutationOffset), 4096 - 300);
    assert_eq!(found.axis.get(Ap::ActualEncoderAngle), 300 * 4 * 16);
}

/// Counts of a turn of another length, or in the other direction, are no place on the disc.
#[test]
fn after_other_encoder_settings_the_index_is_taken_anew() {
    for (parameter, value) in [(Ap::EncoderResolution, 4000), (Ap::EncoderDirection, 1)] {
        let mut driven = Driven::new();
        pass_index(&mut driven, 300, 5000);
        driven.set(parameter, value);
        pass_index(&mut driven, 10, 0);
        assert_eq!(driven.axis.get(Ap::ActualEncoderAngle), 0, "{parameter:?}");
    }
}

/// Counts that were lost since are found again by a new turn to the N channel.
#[test]
fn turning_to_the_index_counts_anew_from_there() {
    let mut driven = Driven::new();
    driven.set(Ap::InitSineMode, 2);
    driven.set(Ap::CommutationMode, 7);
    driven.run(2);
    pass_index(&mut driven, 300, 0);
    driven.set(Ap::ReinitCommutation, 0);
    driven.run(2);
    // 4096 less 50 that were lost.
    pass_index(&mut driven, 4046, 0);
    assert_eq!(driven.axis.get(Ap::ActualEncoderAngle), 0);
}
