//! The bench driven directly: what a voltage vector does, and what the sensors make of it.

extern crate std;

use core::f64::consts::TAU;
use std::vec::Vec;

use module_firmware::tmcm_1640::{Drive, PWM_PERIOD, Sensed};

use super::BldcBench;
use super::build::BOARD;
use crate::parts::{BldcParts, CommonParts, EncoderParts};
use crate::{
    Contact, EncoderLine, HallSensor, Hardware, Phase, Physical, Power, Setting, Surroundings, SwitchName,
    TICK_NS,
};

const OFF: Drive = Drive { duties: [0; 3], enabled: false, output: false };

/// Pole pairs and phase resistance of the default motor.
const POLE_PAIRS: f64 = 4.0;
const PHASE_OHM: f64 = 0.36;

fn config() -> BldcParts {
    BldcParts::standard().expect("the default bench")
}

struct Run {
    bench: BldcBench,
    time_ns: u64,
}

impl Run {
    fn new(config: &BldcParts) -> Self {
        Self { bench: BldcBench::new(config), time_ns: 0 }
    }

    /// A control period; whether anything changed.
    fn tick(&mut self, drive: &Drive) -> bool {
        self.time_ns += TICK_NS;
        self.bench.advance(drive, self.time_ns)
    }

    fn hold(&mut self, drive: &Drive, seconds: f64) {
        for _ in 0..periods(seconds) {
            self.tick(drive);
        }
    }

    /// Turns the voltage vector, from `angle_turns` on, so fast.
    fn rotate(&mut self, part: f64, angle_turns: f64, turns_per_s: f64, seconds: f64) {
        for period in 0..periods(seconds) {
            let angle = angle_turns + POLE_PAIRS * turns_per_s * f64::from(period) * 50e-6;
            self.tick(&vector(part, angle));
        }
    }

    fn sensed(&self) -> Sensed {
        self.bench.sensed()
    }

    fn physical(&self) -> Physical {
        self.bench.physical()
    }
}

fn periods(seconds: f64) -> i32 {
    (seconds / 50e-6).round() as i32
}

/// The duties that make a voltage vector of so much of half the supply, at an electrical angle in turns.
fn vector(part: f64, angle_turns: f64) -> Drive {
    let duty = |phase: f64| {
        let wave = part * libm::cos(TAU * (angle_turns - phase / 3.0));
        (f64::from(PWM_PERIOD) * (0.5 + 0.5 * wave)).round() as u16
    };
    Drive { duties: [duty(0.0), duty(1.0), duty(2.0)], enabled: true, output: false }
}

#[test]
fn the_rotor_follows_a_turning_vector() {
    for direction in [1.0, -1.0] {
        let mut run = Run::new(&config());
        run.rotate(0.12, 0.0, direction, 3.0);
        let Physical { rotor_turns, velocity_rpm, .. } = run.physical();
        assert!((rotor_turns - 3.0 * direction).abs() < 0.1, "{rotor_turns} turns");
        assert!((velocity_rpm - 60.0 * direction).abs() < 10.0, "{velocity_rpm} rpm");
        assert!((f64::from(run.sensed().encoder_counts) - rotor_turns * 4096.0).abs() <= 1.0);
    }
}

#[test]
fn at_standstill_the_current_is_voltage_over_resistance() {
    let mut run = Run::new(&config());
    // Along the magnets: nothing turns.
    run.hold(&vector(0.15, 0.0), 0.2);
    let physical = run.physical();
    let expected_a = 0.15 * physical.bus_voltage_v / 2.0 / (PHASE_OHM + BOARD.on_resistance_ohm);
    assert!(
        (physical.phase_u_a / expected_a - 1.0).abs() < 1e-3,
        "{} A, not {expected_a}",
        physical.phase_u_a
    );
    assert!((physical.current_d_a - physical.phase_u_a).abs() < 1e-9 && physical.current_q_a.abs() < 1e-6);
    assert!((physical.phase_v_a + 0.5 * physical.phase_u_a).abs() < 1e-3);
    assert_eq!(physical.rotor_turns, 0.0);
    let [u, v, w] = run.sensed().phase_currents_ma.map(f64::from);
    assert!((u - physical.phase_u_a * 1000.0).abs() <= 0.5 && (v - physical.phase_v_a * 1000.0).abs() <= 0.5);
    assert!((u + v + w).abs() <= 1.0);
    // What the source gives is what board, bridge and windings take.
    let heat_w = 1.5 * physical.current_d_a.powi(2) * (PHASE_OHM + BOARD.on_resistance_ohm);
    let taken_w = physical.supply_current_a * physical.bus_voltage_v;
    assert!((taken_w / (heat_w + 1.5) - 1.0).abs() < 1e-3, "{taken_w} W for {heat_w} W of heat");
}

#[test]
fn hall_sensors_and_encoder_tell_where_the_rotor_is() {
    const SECTORS: [u8; 6] = [0b001, 0b011, 0b010, 0b110, 0b100, 0b101];
    for (offset_deg, inverted) in [(0.0, false), (20.0, true)] {
        let parts = BldcParts { halls_offset_deg: offset_deg, halls_inverted: inverted, ..config() };
        let mut run = Run::new(&parts);
        let mut seen = [false; 6];
        for period in 0..periods(1.0) {
            run.tick(&vector(0.12, f64::from(period) * 50e-6 * POLE_PAIRS));
            let turns = run.physical().rotor_turns;
            let electrical = (turns * POLE_PAIRS - offset_deg / 360.0).rem_euclid(1.0);
            let sector = (electrical * 6.0) as usize % 6;
            let expected = if inverted { !SECTORS[sector] & 7 } else { SECTORS[sector] };
            assert_eq!(run.sensed().halls, expected, "at {turns} turns");
            assert_eq!(run.sensed().encoder_counts, (turns * 4096.0).floor() as i32);
            seen[sector] = true;
        }
        assert_eq!(seen, [true; 6]);
    }
}

#[test]
fn the_index_comes_once_a_turn() {
    let encoder = EncoderParts { offset_turns: 0.3, ..config().common.encoder };
    let common = CommonParts { encoder, ..config().common };
    let mut run = Run::new(&BldcParts { common, ..config() });
    let mut at_turns = Vec::new();
    for period in 0..periods(3.0) {
        run.tick(&vector(0.12, f64::from(period) * 50e-6 * POLE_PAIRS));
        if run.sensed().encoder_index {
            at_turns.push(run.physical().rotor_turns);
        }
    }
    assert_eq!(at_turns.len(), 3, "{at_turns:?}");
    for (turn, at) in (0..).zip(at_turns) {
        assert!((at - f64::from(turn) - 0.3).abs() < 0.01, "{at}");
    }
}

#[test]
fn an_index_seen_while_a_setting_comes_is_not_lost() {
    let mut run = Run::new(&config());
    run.rotate(0.12, 0.0, 1.0, 0.5);
    while !run.sensed().encoder_index {
        let turns = run.physical().rotor_turns;
        run.tick(&vector(0.12, turns * POLE_PAIRS + 0.25));
    }
    run.bench.apply(Setting::AmbientC(30.0));
    assert!(run.sensed().encoder_index);
}

#[test]
fn braking_pumps_up_the_supply() {
    let mut run = Run::new(&config());
    run.bench.apply(Setting::LoadInertiaKgm2(5e-5));
    // A vector a quarter of a turn ahead of the rotor, then a quarter behind it.
    let driven = |run: &mut Run, part: f64, seconds: f64| {
        for _ in 0..periods(seconds) {
            let turns = run.physical().rotor_turns;
            run.tick(&vector(part, turns * POLE_PAIRS + 0.26));
        }
    };
    driven(&mut run, 0.6, 1.0);
    let fast = run.physical();
    assert!(fast.velocity_rpm > 1500.0 && fast.bus_voltage_v < 24.0, "{fast:?}");
    driven(&mut run, 0.3, 0.1);
    let braked = run.physical();
    assert!(braked.velocity_rpm < 0.9 * fast.velocity_rpm);
    assert!(braked.bus_voltage_v > 25.0, "{} V", braked.bus_voltage_v);
    assert_eq!(run.sensed().supply_voltage_dv, (braked.bus_voltage_v * 10.0).round() as u16);
    assert_eq!(braked.supply_current_a, 0.0, "the diode");
}

/// Held, the shaft comes to rest bit for bit, and resting is the same as going on.
#[test]
fn at_rest_nothing_changes_until_the_temperature_does() {
    for drive in [OFF, vector(0.1, 0.05), vector(0.1, 0.3)] {
        let mut run = Run::new(&config());
        run.hold(&vector(0.12, 0.2), 0.05);
        let mut quiet = 0;
        for _ in 0..periods(2.0) {
            quiet = if run.tick(&drive) { 0 } else { quiet + 1 };
            if quiet == 2 {
                break;
            }
        }
        assert_eq!(quiet, 2, "it comes to rest");
        let mut rested = Run { bench: run.bench.clone(), time_ns: run.time_ns };
        let until_ns = run.bench.next_change_ns() - TICK_NS;
        let periods = (until_ns - run.time_ns) / TICK_NS;
        for _ in 0..periods {
            assert!(!run.tick(&drive));
        }
        rested.bench.rest(periods, until_ns);
        rested.time_ns = until_ns;
        for _ in 0..5000 {
            assert_eq!(run.tick(&drive), rested.tick(&drive));
            assert_eq!((run.sensed(), run.physical()), (rested.sensed(), rested.physical()));
        }
    }
}

#[test]
fn off_the_currents_die_and_the_shaft_coasts() {
    let mut run = Run::new(&config());
    run.rotate(0.2, 0.0, 2.0, 1.0);
    run.hold(&OFF, 0.01);
    let physical = run.physical();
    assert_eq!(run.sensed().phase_currents_ma, [0; 3]);
    assert!(physical.velocity_rpm.abs() > 1.0);
    assert_eq!(physical.load_angle_deg, 0.0);
    run.bench.apply(Setting::Power(Power::Off));
    run.hold(&OFF, 0.5);
    assert_eq!(run.physical().velocity_rpm, 0.0, "friction");
}

#[test]
fn the_load_angle_is_that_of_the_currents_from_the_magnets() {
    let mut run = Run::new(&config());
    run.hold(&vector(0.15, 0.0), 0.1);
    assert!(run.physical().load_angle_deg.abs() < 0.1);
    run.bench.apply(Setting::LoadFrictionNm(10.0));
    run.hold(&vector(0.15, 0.25), 0.1);
    let physical = run.physical();
    assert!((physical.load_angle_deg - 90.0).abs() < 0.1, "{physical:?}");
    let torque_nm = 1.5 * POLE_PAIRS * 0.036 / (3.0_f64.sqrt() * POLE_PAIRS) * physical.current_q_a;
    assert!((physical.torque_nm / torque_nm - 1.0).abs() < 1e-9);
}

#[test]
fn shorts_overcurrent_and_a_dying_supply_raise_the_error() {
    let mut run = Run::new(&config());
    run.hold(&vector(0.1, 0.0), 0.01);
    assert!(!run.sensed().driver_error);
    run.bench.apply(Setting::PhaseShort(Some(Phase::V)));
    run.hold(&vector(0.1, 0.0), 0.02);
    assert!(run.sensed().driver_error && run.sensed().phase_currents_ma == [0; 3]);
    run.bench.apply(Setting::PhaseShort(None));
    run.hold(&vector(0.1, 0.0), 0.01);
    assert!(run.sensed().driver_error, "until it is disabled");
    run.tick(&OFF);
    run.hold(&vector(0.1, 0.0), 0.01);
    assert!(!run.sensed().driver_error && run.sensed().phase_currents_ma[0] > 1000);
    // 24 V across two phases in series are 32 A, the whole vector 4/3 of that.
    run.bench.apply(Setting::LoadFrictionNm(10.0));
    run.hold(&Drive { duties: [PWM_PERIOD, 0, 0], enabled: true, output: false }, 0.02);
    assert!(run.sensed().driver_error);
    run.hold(&OFF, 0.01);
    assert!(!run.sensed().driver_error);
    run.bench.apply(Setting::SupplyVoltageV(8.0));
    run.hold(&vector(0.1, 0.0), 1.0);
    assert!(run.sensed().driver_error && run.sensed().supply_voltage_dv < 90);
    run.bench.apply(Setting::SupplyVoltageV(24.0));
    run.hold(&OFF, 0.1);
    assert!(!run.sensed().driver_error);
}

#[test]
fn an_open_phase_carries_nothing() {
    let mut run = Run::new(&config());
    run.bench.apply(Setting::PhaseOpen(Some(Phase::W)));
    run.hold(&vector(0.1, 0.1), 0.1);
    let physical = run.physical();
    assert_eq!(run.sensed().phase_currents_ma[2], 0);
    assert!(physical.phase_u_a > 0.5 && (physical.phase_u_a + physical.phase_v_a).abs() < 1e-6);
    run.bench.apply(Setting::PhaseOpen(None));
    run.hold(&vector(0.1, 0.1), 0.1);
    assert!(run.physical().phase_w_a.abs() > 0.5);
}

#[test]
fn dead_lines_show_what_dead_lines_do() {
    let mut run = Run::new(&config());
    run.bench.apply(Setting::HallLine { sensor: HallSensor::H1, stuck: Some(false) });
    assert_eq!(run.sensed().halls, 0b000, "at 0 the sector is 001");
    run.bench.apply(Setting::HallLine { sensor: HallSensor::H2, stuck: Some(true) });
    run.bench.apply(Setting::HallLine { sensor: HallSensor::H3, stuck: Some(true) });
    assert_eq!(run.sensed().halls, 0b110);
    for sensor in [HallSensor::H1, HallSensor::H2, HallSensor::H3] {
        run.bench.apply(Setting::HallLine { sensor, stuck: None });
    }
    assert_eq!(run.sensed().halls, 0b001);
    run.bench.apply(Setting::EncoderLine(Some(EncoderLine::A)));
    run.rotate(0.12, 0.0, 1.0, 1.0);
    assert!(run.physical().rotor_turns > 0.9 && run.sensed().encoder_counts.abs() <= 1);
}

#[test]
fn stop_switches_are_inputs_and_idle_inputs_are_low() {
    let run = Run::new(&config());
    assert_eq!(run.sensed().inputs, 0);
    let mut parts = config();
    let at = |from_turns, to_turns| {
        Some(motor_physics::switch::SwitchConfig { from_turns, to_turns, bounce_ns: 0 })
    };
    let right = at(0.5, f64::INFINITY);
    parts.switches = [at(f64::NEG_INFINITY, -0.5), right];
    let mut run = Run::new(&parts);
    assert_eq!(run.sensed().inputs, 0b00, "closed contacts");
    run.rotate(0.12, 0.0, 1.0, 0.7);
    assert_eq!(run.sensed().inputs, 0b01, "the right one is IN_0");
    run.rotate(0.12, 0.7 * POLE_PAIRS, -1.0, 1.4);
    assert_eq!(run.sensed().inputs, 0b10, "the left one is IN_1");
    run.bench.apply(Setting::SwitchContact { switch: SwitchName::Right, stuck: Some(Contact::Open) });
    assert_eq!(run.sensed().inputs, 0b11);
    let mut free = Run::new(&config());
    free.bench.apply(Setting::Input { number: 1, high: true });
    free.bench.apply(Setting::AnalogInput { number: 0, reading: 1234 });
    assert_eq!((free.sensed().inputs, free.sensed().analog_input), (0b10, 1234));
}

#[test]
fn the_ntc_follows_the_board() {
    let mut run = Run::new(&config());
    assert_eq!(run.sensed().driver_temperature_adc, 739, "25 °C");
    run.bench.apply(Setting::BoardTemperatureC(Some(35.3)));
    assert!(run.sensed().driver_temperature_adc.abs_diff(1000) <= 1);
    run.bench.apply(Setting::BoardTemperatureC(None));
    run.bench.apply(Setting::LoadFrictionNm(10.0));
    run.hold(&vector(0.4, 0.0), 20.0);
    let Physical { board_temperature_c, winding_temperature_c, current_d_a, .. } = run.physical();
    let bridge_w = 1.5 * BOARD.on_resistance_ohm * current_d_a.powi(2);
    let expected_c = 25.0 + 10.0 * (1.5 + bridge_w) * (1.0 - libm::exp(-20.0 / 120.0));
    assert!((board_temperature_c - expected_c).abs() < 0.2, "{board_temperature_c}, not {expected_c}");
    assert!(winding_temperature_c > 100.0, "{winding_temperature_c}");
    assert!(run.sensed().driver_temperature_adc > 739);
}

#[test]
fn power_off_and_on_keeps_the_rotor_and_forgets_the_count() {
    let mut run = Run::new(&config());
    run.rotate(0.12, 0.0, 1.0, 1.0);
    run.hold(&OFF, 0.5);
    let before = run.physical().rotor_turns;
    run.bench.apply(Setting::Power(Power::Off));
    run.bench.apply(Setting::Power(Power::On));
    assert_eq!((run.physical().rotor_turns, run.sensed().encoder_counts), (before, 0));
    assert!(before > 0.9);
}
