//! What breaks, and what of it the client sees: the driver's flags (AP 208), the encoder (AP 209), switches at the inputs.

use crate::common::{Module, TURN};
use tmcl_tables::Command;
use tmcl_tables::tmcm_1311::AxisParameter as Ap;

const BENCH: &str = "[[module]]\nkind = \"tmcm-1311\"\n";

/// Bits of AP 208.
mod flag {
    pub(crate) const OVER_TEMPERATURE: i32 = 1 << 1;
    pub(crate) const PRE_WARNING: i32 = 1 << 2;
    pub(crate) const SHORT: [i32; 2] = [1 << 3, 1 << 4];
    pub(crate) const OPEN: [i32; 2] = [1 << 5, 1 << 6];
    pub(crate) const STANDSTILL: i32 = 1 << 7;
    /// All but the stallGuard2 bit.
    pub(crate) const FAULTS: i32 = 0xFE;
}

/// Turning to the right at 2 turns/s, without a fault.
fn turning() -> Module {
    let mut module = Module::new();
    module.run_ms(100);
    module.sap(Ap::MaxVelocity, 20 * TURN);
    module.sap(Ap::MaxAcceleration, 10 * TURN);
    module.ok(Command::RotateRight, 0, 0, 2 * TURN);
    module.run_ms(1000);
    assert_eq!(faults(&mut module), 0);
    module
}

fn faults(module: &mut Module) -> i32 {
    module.gap(Ap::DriverErrorFlags) & flag::FAULTS
}

fn currents_a(module: &Module) -> [f64; 2] {
    [module.physical().coil_a_a, module.physical().coil_b_a]
}

/// A digital input, as GIO reads it.
fn input(module: &mut Module, number: u8) -> i32 {
    module.ok(Command::GetInput, number, 0, 0)
}

mod driver {
    use super::*;

    #[test]
    fn warns_at_100_degrees_and_switches_off_from_150_until_120() {
        let mut module = turning();
        let hot = flag::OVER_TEMPERATURE | flag::PRE_WARNING;
        for (board_c, flags, on) in [
            (99.0, 0, true),
            (100.0, flag::PRE_WARNING, true),
            (149.0, flag::PRE_WARNING, true),
            (150.0, hot, false),
            (121.0, hot, false),
            (119.0, flag::PRE_WARNING, true),
            (94.0, 0, true),
        ] {
            module.set("fault.board_temperature_c", board_c);
            module.run_ms(20);
            assert_eq!(faults(&mut module), flags, "at {board_c} °C");
            assert_eq!(module.gap(Ap::ModuleTemperature), board_c as i32);
            assert_eq!(
                module.gap(Ap::StatusWord) >> 11 & 1,
                i32::from(board_c >= 100.0),
                "AP 18 at {board_c} °C"
            );
            assert_eq!(currents_a(&module) != [0.0, 0.0], on, "bridges at {board_c} °C");
        }
        module.set("fault.board_temperature_c", "none");
        module.run_ms(20);
        assert!((25..30).contains(&module.gap(Ap::ModuleTemperature)));
    }

    #[test]
    fn without_its_bridges_the_motor_coasts_while_the_module_counts_on() {
        let mut module = turning();
        module.set("fault.board_temperature_c", 150);
        let (turns, reported) = (module.turns(), module.gap(Ap::ActualPosition));
        module.run_ms(1000);
        assert_eq!(module.physical().velocity_rpm, 0.0, "friction stopped it");
        assert!(module.turns() - turns < 0.5);
        assert_eq!(module.gap(Ap::ActualPosition) - reported, 2 * TURN);
    }

    #[test]
    fn a_short_to_ground_switches_off_until_the_off_time_is_written_to_0() {
        for (coil, bit) in ["a", "b"].into_iter().zip(flag::SHORT) {
            let mut module = turning();
            module.set("fault.coil_short", coil);
            module.run_ms(1);
            assert_eq!(faults(&mut module), bit, "coil {coil}");
            module.run_ms(5);
            assert_eq!(currents_a(&module), [0.0, 0.0], "both bridges are off");

            module.set("fault.coil_short", "none");
            module.run_ms(100);
            assert_eq!((faults(&mut module), currents_a(&module)), (bit, [0.0, 0.0]), "latched");
            module.sap(Ap::ChopperOffTime, 0);
            module.run_ms(1);
            assert_eq!(faults(&mut module), 0);
            module.sap(Ap::ChopperOffTime, 5);
            module.run_ms(5);
            let [a, b] = currents_a(&module);
            assert!((a.hypot(b) - 2.25).abs() < 0.1, "{a} A and {b} A");
        }
    }

    #[test]
    fn without_short_protection_one_half_wave_is_missing_and_nothing_is_said() {
        let mut module = turning();
        module.sap(Ap::ShortProtectionDisable, 1);
        // So slow that a rotor that cannot follow induces next to nothing: 2.5 electrical periods a second.
        module.ok(Command::RotateRight, 0, 0, TURN / 20);
        module.run_ms(1000);
        module.set("fault.coil_short", "b");
        module.run_ms(500);
        let (mut lowest_a, mut highest_a) = (0.0_f64, 0.0_f64);
        for _ in 0..20_000 {
            module.run_ticks(1);
            let [_, b] = currents_a(&module);
            (lowest_a, highest_a) = (lowest_a.min(b), highest_a.max(b));
        }
        assert!(highest_a > 2.0 && lowest_a > -0.7, "{lowest_a} to {highest_a} A");
        assert_eq!(faults(&mut module) & (flag::SHORT[0] | flag::SHORT[1]), 0);
    }

    #[test]
    fn an_open_coil_shows_after_a_half_wave_and_goes_when_it_is_mended() {
        for (coil, bit) in ["a", "b"].into_iter().zip(flag::OPEN) {
            let mut module = turning();
            // Fast enough to be carried on by its inertia.
            module.ok(Command::RotateRight, 0, 0, 5 * TURN);
            module.run_ms(1000);
            module.set("fault.coil_open", coil);
            // A half-wave at 5 turns/s takes 2 ms.
            module.run_ms(5);
            assert_eq!(faults(&mut module), bit, "coil {coil}");
            module.set("fault.coil_open", "none");
            module.run_ms(5);
            assert_eq!(faults(&mut module), 0, "coil {coil}");
        }
    }

    #[test]
    fn an_open_coil_of_a_motor_that_stands_does_not_show() {
        let mut module = Module::new();
        module.set("fault.coil_open", "a");
        module.run_ms(1000);
        assert_eq!(currents_a(&module), [0.0, 0.0], "at phase 0 all current flows in coil A");
        assert_eq!(faults(&mut module), flag::STANDSTILL);
    }

    #[test]
    fn standstill_shows_65_536_ms_after_the_last_step() {
        let mut module = Module::new();
        module.ok(Command::MoveToPosition, 0, 0, 512);
        module.arrive();
        assert_eq!(faults(&mut module), 0);
        // The step comes with the last tick; 2^20 clocks of 16 MHz later the chip says so, and the firmware hears of it.
        module.run_ticks(1310);
        assert_eq!(faults(&mut module), 0);
        module.run_ticks(3);
        assert_eq!(faults(&mut module), flag::STANDSTILL);
        module.ok(Command::RotateRight, 0, 0, TURN);
        module.run_ms(10);
        assert_eq!(faults(&mut module), 0);
    }

    #[test]
    fn a_power_cycle_clears_what_the_chip_found() {
        let mut module = turning();
        module.set("fault.coil_short", "a");
        module.run_ms(10);
        module.set("fault.coil_short", "none");
        module.power_cycle();
        module.run_ms(10);
        assert_eq!(faults(&mut module), 0);
        assert_ne!(currents_a(&module), [0.0, 0.0]);
    }
}

mod encoder {
    use super::*;

    #[test]
    fn a_lost_line_stops_the_count_and_a_mended_one_goes_on_from_there() {
        for line in ["a", "b"] {
            let mut module = turning();
            module.set("fault.encoder_line", line);
            let (count, turns) = (module.gap(Ap::EncoderCounter), module.turns());
            for _ in 0..500 {
                module.run_ms(1);
                let off = module.gap(Ap::EncoderCounter) - count;
                // The position is read every period, at 2 turns/s every fourth count, so line by line.
                assert!(off.abs() <= 6, "line {line}: {off} counts");
            }
            assert!(module.turns() - turns > 0.99, "though the shaft turns");

            module.set("fault.encoder_line", "none");
            let (count, turns) = (module.gap(Ap::EncoderCounter), module.turns());
            module.run_ms(500);
            let counted = f64::from(module.gap(Ap::EncoderCounter) - count) / 40_000.0;
            assert!(
                (counted - (module.turns() - turns)).abs() < 5e-4,
                "line {line}: {counted} turns counted"
            );
        }
    }

    #[test]
    fn without_its_index_it_counts_on() {
        let mut module = turning();
        module.set("fault.encoder_line", "index");
        module.run_ms(2000);
        let counted = f64::from(module.gap(Ap::EncoderCounter)) / 40_000.0;
        assert!((counted - module.turns()).abs() < 5e-4, "{counted} turns counted");
    }

    #[test]
    fn resolution_and_direction_are_those_of_the_bench_file() {
        for (encoder, counts_per_turn) in [
            ("counts = 4000", 4000.0),
            ("counts = 1024\ninverted = true", -1024.0),
            ("offset_turns = 0.3", 40_000.0),
        ] {
            let mut module = Module::on(&format!("{BENCH}[module.encoder]\n{encoder}\n"));
            module.ok(Command::MoveToPosition, 0, 0, TURN);
            module.arrive();
            module.run_ms(500);
            let counted = f64::from(module.gap(Ap::EncoderCounter));
            assert!((counted - counts_per_turn).abs() < 5.0, "{encoder}: {counted}");
        }
    }
}

mod home_switch {
    use super::*;

    const WITH_HOME: &str =
        "[module.switches]\nhome = { at_turns = 0.5, width_turns = 0.2, bounce_ms = 3.0 }\n";

    fn with_home() -> Module {
        Module::on(&format!("{BENCH}{WITH_HOME}"))
    }

    /// Moves to `turns` slowly and lets the contact settle.
    fn go_to(module: &mut Module, turns: f64) {
        module.ok(Command::MoveToPosition, 0, 0, (turns * f64::from(TURN)) as i32);
        module.arrive();
        module.run_ms(100);
    }

    #[test]
    fn opens_input_1_where_it_is_pressed() {
        let mut module = with_home();
        module.run_ms(1);
        for (turns, open) in [(0.0, 0), (0.38, 0), (0.42, 1), (0.58, 1), (0.62, 0), (0.5, 1)] {
            go_to(&mut module, turns);
            assert_eq!(input(&mut module, 1), open, "at {turns} turns");
        }
    }

    #[test]
    fn bounces_for_as_long_as_the_bench_file_says() {
        let mut module = with_home();
        module.ok(Command::MoveToPosition, 0, 0, TURN / 2);
        let (mut levels, mut pressed_ms) = (Vec::new(), None);
        for tick in 0..20_000 {
            module.run_ticks(1);
            levels.push(input(&mut module, 1));
            if module.turns() >= 0.4 && pressed_ms.is_none() {
                pressed_ms = Some(f64::from(tick) * 0.05);
            }
        }
        let changes: Vec<_> = (1..levels.len()).filter(|&tick| levels[tick] != levels[tick - 1]).collect();
        let (first_ms, last_ms) = (changes[0] as f64 * 0.05, changes[changes.len() - 1] as f64 * 0.05);
        assert!(changes.len() > 5, "{} changes", changes.len());
        let pressed_ms = pressed_ms.expect("it comes to the switch");
        assert!(
            first_ms >= pressed_ms && last_ms <= pressed_ms + 3.15,
            "{first_ms} to {last_ms}, {pressed_ms} ms"
        );
        assert_eq!(levels.last(), Some(&1));
    }

    #[test]
    fn a_stuck_contact_says_the_same_everywhere() {
        let mut module = with_home();
        for (contact, level) in [("open", 1), ("closed", 0)] {
            module.set("fault.switch_home", contact);
            for turns in [0.0, 0.5, 1.0] {
                go_to(&mut module, turns);
                assert_eq!(input(&mut module, 1), level, "stuck {contact}, at {turns} turns");
            }
        }
        module.set("fault.switch_home", "none");
        module.run_ms(1);
        assert_eq!(input(&mut module, 1), 0);
        go_to(&mut module, 0.5);
        assert_eq!(input(&mut module, 1), 1);
    }
}

#[test]
fn inputs_are_what_they_are_set_to() {
    let mut module = Module::on(&format!("{BENCH}[module.inputs]\nin_2 = 1\nain_0 = 1000\nain_4 = 3000\n"));
    module.run_ticks(1);
    assert_eq!((input(&mut module, 2), input(&mut module, 3)), (1, 0));
    assert_eq!((module.ok(Command::GetInput, 0, 1, 0), module.ok(Command::GetInput, 4, 1, 0)), (1000, 3000));
    assert_eq!((input(&mut module, 0), input(&mut module, 4)), (0, 1), "half of the range is high");
    module.set("input.2", 0);
    module.set("input.3", 1);
    module.set("ain.0", 4095);
    module.run_ticks(1);
    assert_eq!((input(&mut module, 2), input(&mut module, 3), input(&mut module, 0)), (0, 1, 1));
}
