//! What holds for whatever registers, pins and edges.

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

fn any_threshold() -> impl Strategy<Value = u32> {
    prop_oneof![Just(0), 0..2000_u32, 0..1_048_576_u32, any::<u32>()]
}

prop_compose! {
    /// The delays are short, so that a motor comes to rest within a second.
    fn any_registers()(
        words in any::<[u32; 5]>(),
        [ihold, irun] in any::<[u8; 2]>(),
        iholddelay in 0..2_u8,
        tpowerdown in 0..4_u8,
        global_scaler in any::<u8>(),
        [tpwmthrs, tcoolthrs, thigh] in [any_threshold(), any_threshold(), any_threshold()],
    ) -> Registers {
        let [gconf, chopconf, coolconf, pwmconf, _] = words;
        Registers {
            gconf: GConf::from_bits(gconf),
            global_scaler,
            ihold_irun: IHoldIRun { ihold, irun, iholddelay },
            tpowerdown,
            tpwmthrs,
            tcoolthrs,
            thigh,
            chopconf: ChopConf::from_bits(chopconf),
            coolconf: CoolConf::from_bits(coolconf),
            pwmconf: PwmConf::from_bits(pwmconf),
        }
    }
}

prop_compose! {
    fn any_edges()(
        count in prop_oneof![0..4_u32, any::<u32>()],
        first_clock in prop_oneof![0..600_u32, any::<u32>()],
        last_clock in prop_oneof![0..600_u32, any::<u32>()],
        [rising_first, reverse] in any::<[bool; 2]>(),
    ) -> Edges {
        Edges { count, first_clock, last_clock, rising_first, reverse }
    }
}

proptest! {
    #[test]
    fn no_voltage_exceeds_the_bus_and_no_report_its_range(
        inputs in prop::collection::vec(
            (any_registers(), any_pins(), prop::collection::vec(any_edges(), 0..3), any::<bool>()), 1..50,
        ),
    ) {
        let mut chip = Tmc5160::new(BOARD);
        for (registers, pins, edges, enabled) in inputs {
            for terminal in chip.advance(&registers, Inputs { pins: &pins, enabled, edges: &edges }, PERIOD_S) {
                match terminal {
                    Terminal::Driven { voltage_v } => {
                        prop_assert!(enabled && voltage_v.abs() <= pins.bus_voltage_v);
                    }
                    Terminal::Floating { bus_voltage_v } => prop_assert_eq!(bus_voltage_v, pins.bus_voltage_v),
                }
            }
            let status = chip.status();
            prop_assert!(status.sg_result <= 1023 && status.cs_actual <= 31);
            prop_assert!(status.mscnt < 1024 && status.tstep <= STANDSTILL_TSTEP);
            prop_assert!(status.mscuract.iter().all(|value| value.abs() <= 248));
        }
    }

    #[test]
    fn without_steps_the_state_comes_to_rest_bit_for_bit(
        history in prop::collection::vec((any_registers(), any_pins(), any_edges(), any::<bool>()), 1..20),
    ) {
        let mut chip = Tmc5160::new(BOARD);
        for (registers, pins, edges, enabled) in &history {
            chip.advance(registers, Inputs { pins, enabled: *enabled, edges: &[*edges] }, PERIOD_S);
        }
        let (registers, pins, _, enabled) = history.last().expect("not empty");
        let inputs = Inputs { pins, enabled: *enabled, edges: &[] };
        for _ in 0..30_000 {
            chip.advance(registers, inputs, PERIOD_S);
        }
        let mut next = chip;
        let terminals = next.advance(registers, inputs, PERIOD_S);
        prop_assert_eq!(next, chip);
        prop_assert_eq!(next.advance(registers, inputs, PERIOD_S), terminals);
    }
}
