//! What holds for whatever registers and pins.

use proptest::prelude::*;

use super::*;

fn any_fault() -> impl Strategy<Value = CoilFault> {
    prop_oneof![Just(CoilFault::None), Just(CoilFault::Open), Just(CoilFault::ShortToGround)]
}

prop_compose! {
    fn any_pins()(
        currents_a in [-10.0..10.0, -10.0..10.0],
        back_emf_v in [-60.0..60.0, -60.0..60.0],
        rotor_velocity_rps in -100.0..100.0,
        bus_voltage_v in 0.0..60.0,
        resistance_ohm in 0.1..20.0,
        inductance_h in 0.0..0.02,
        temperature_c in 0.0..200.0,
        coil_faults in [any_fault(), any_fault()],
    ) -> Pins {
        Pins {
            currents_a, back_emf_v, rotor_velocity_rps, bus_voltage_v, resistance_ohm, inductance_h, temperature_c,
            coil_faults,
        }
    }
}

fn any_coils() -> impl Strategy<Value = Coils> {
    prop_oneof![
        any::<[i16; 2]>().prop_map(Coils::Direct),
        [-260..260_i16, -260..260_i16].prop_map(Coils::Direct),
        any::<u8>().prop_map(|microstep_resolution| Coils::StepDirection { microstep_resolution }),
    ]
}

prop_compose! {
    fn any_registers()(
        coils in any_coils(),
        bytes in any::<[u8; 4]>(),
        thresholds in (0..16_u8, 0..16_u8),
        stallguard_threshold in any::<i8>(),
        [half_scale, stallguard_filter, quarter_minimum, short_protection_disabled] in any::<[bool; 4]>(),
    ) -> Registers {
        let [current_scale, off_time, up_step, down_step] = bytes;
        let (lower_threshold, hysteresis) = thresholds;
        Registers {
            coils, current_scale, half_scale, off_time, stallguard_threshold, stallguard_filter,
            coolstep: CoolStep { lower_threshold, hysteresis, up_step, down_step, quarter_minimum },
            short_protection_disabled,
        }
    }
}

proptest! {
    #[test]
    fn no_voltage_exceeds_the_bus_and_no_report_its_range(
        inputs in prop::collection::vec((any_registers(), any_pins(), any::<i32>()), 1..50),
    ) {
        let mut chip = chip();
        for (registers, pins, steps) in inputs {
            chip.step(steps);
            for terminal in chip.advance(&registers, &pins, PERIOD_S) {
                match terminal {
                    Terminal::Driven { voltage_v } => prop_assert!(voltage_v.abs() <= pins.bus_voltage_v),
                    Terminal::Floating { bus_voltage_v } => prop_assert_eq!(bus_voltage_v, pins.bus_voltage_v),
                }
            }
            let status = chip.status();
            prop_assert!(status.stallguard_value <= 1023);
            let commanded = registers.current_scale.min(31);
            prop_assert!((commanded / 4..=commanded).contains(&status.current_scale));
            prop_assert!(status.microstep_position < 1024);
        }
    }

    #[test]
    fn with_constant_inputs_the_state_comes_to_rest_bit_for_bit(
        history in prop::collection::vec((any_registers(), any_pins(), -5..5_i32), 1..20),
        period_s in 10e-6..1e-3,
    ) {
        let mut chip = chip();
        for (registers, pins, steps) in &history {
            chip.step(*steps);
            chip.advance(registers, pins, period_s);
        }
        let (registers, pins, _) = history.last().unwrap();
        for _ in 0..libm::ceil(0.067 / period_s) as u32 + 1 {
            chip.advance(registers, pins, period_s);
        }
        let mut next = chip;
        let terminals = next.advance(registers, pins, period_s);
        prop_assert_eq!(next, chip);
        prop_assert_eq!(next.advance(registers, pins, period_s), terminals);
    }
}
