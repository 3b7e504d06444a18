//! What the bench file says happens, at its exact time; and signals from one module to another.

use crate::common::Module;
use tmcl_tables::Command;
use tmcl_wire::{Request, serial};
use virtual_bench::{Bench, ModuleId, PortId, TICK_NS, config};

fn bench(text: &str) -> Bench {
    Bench::new(&config::parse(text).expect("a valid bench file"))
}

fn read(bench: &Bench, name: &str) -> f64 {
    bench.read(bench.probe(name).expect("a quantity of this bench"))
}

/// SIO to the module at a place, which has the address of its place + 1.
fn set_output(bench: &mut Bench, module: usize, output: u8, level: i32) {
    let address = u8::try_from(module + 1).expect("few modules");
    let request = serial::encode_request(address, Request::new(Command::SetOutput, output, 2, level));
    let reply = bench.exchange(ModuleId(module), PortId::ALL[0], &request);
    assert_eq!(reply.get(2), Some(&100), "{reply:?}");
}

#[test]
fn an_event_acts_on_the_control_period_that_begins_at_its_time_or_next() {
    for (at, begins_ns) in
        [("1.5s", 1_500_000_000), ("1500.01ms", 1_500_050_000), ("1500.05ms", 1_500_050_000), ("0s", 0)]
    {
        let mut bench = bench(&format!(
            "[[module]]\nkind = \"tmcm-1311\"\n[[event]]\nat = \"{at}\"\n\
             set = {{ \"load.torque_nm\" = 0.25, \"input.2\" = 1 }}\n"
        ));
        bench.advance_to(begins_ns);
        assert_eq!((read(&bench, "physical.load_nm"), read(&bench, "input.2")), (0.0, 0.0), "before {at}");
        bench.advance_to(begins_ns + TICK_NS);
        assert_eq!((read(&bench, "physical.load_nm"), read(&bench, "input.2")), (0.25, 1.0), "after {at}");
    }
}

#[test]
fn events_happen_in_the_order_of_time_and_then_of_the_file() {
    let mut bench = bench(
        "[[module]]\nkind = \"tmcm-1311\"\n\
         [[event]]\nat = 0.2\nset = { \"ain.0\" = 3 }\n\
         [[event]]\nat = 0.1\nset = { \"ain.0\" = 1 }\n\
         [[event]]\nat = 0.1\nset = { \"ain.0\" = 2 }\n",
    );
    let mut seen = vec![0.0];
    for _ in 0..6000 {
        bench.advance_by(TICK_NS);
        let now = read(&bench, "ain.0");
        if seen.last() != Some(&now) {
            seen.push(now);
        }
    }
    assert_eq!(seen, [0.0, 2.0, 3.0]);
}

#[test]
fn an_event_can_switch_off_and_on() {
    let mut module = Module::on(
        "[[module]]\nkind = \"tmcm-1311\"\n\
         [[event]]\nat = \"100ms\"\nset = { power = \"off\" }\n\
         [[event]]\nat = \"200ms\"\nset = { power = \"on\" }\n",
    );
    let request = serial::encode_request(1, Request::new(Command::GetAxisParameter, 4, 0, 0));
    for (until_ms, answers) in [(100, true), (101, false), (200, false), (201, true)] {
        module.bench.advance_to(until_ms * 1_000_000);
        assert_eq!(!module.exchange(&request).is_empty(), answers, "at {until_ms} ms");
    }
}

#[test]
fn common_settings_reach_every_module() {
    let mut bench = bench(
        "[[module]]\nkind = \"tmcm-1311\"\n[[module]]\nkind = \"tmcm-1311\"\n\
         [[event]]\nat = 0.1\nset = { temperature_c = 70.0, \"m2.temperature_c\" = 50.0 }\n",
    );
    bench.advance_to(200_000_000);
    let [first_c, second_c] = [0, 1].map(|place| bench.physical(ModuleId(place)).winding_temperature_c);
    assert!((first_c - 70.0).abs() < 0.1 && (second_c - 50.0).abs() < 0.1, "{first_c} °C and {second_c} °C");
}

const TWO: &str = "[[module]]\nkind = \"tmcm-1311\"\naddress = 1\n[[module]]\nkind = \"tmcm-1311\"\naddress = 2\n\
    [[wire]]\nfrom = \"m1.output.0\"\nto = \"m2.input.1\"\n\
    [[wire]]\nfrom = \"m1.output.0\"\nto = \"m1.input.2\"\n\
    [[wire]]\nfrom = \"m2.output.7\"\nto = \"m1.input.5\"\n";

#[test]
fn a_wire_takes_one_control_period() {
    let mut bench = bench(TWO);
    bench.advance_to(1_000_000_000);
    for (module, output, inputs) in [(0, 0, vec!["m2.input.1", "m1.input.2"]), (1, 7, vec!["m1.input.5"])] {
        for level in [1, 0] {
            set_output(&mut bench, module, output, level);
            // In the first period the output changes; in the second the other firmware sees it.
            bench.advance_by(TICK_NS);
            let early: Vec<_> = inputs.iter().map(|input| read(&bench, input)).collect();
            assert!(early.iter().all(|seen| *seen == f64::from(1 - level)), "{early:?}");
            bench.advance_by(TICK_NS);
            let seen: Vec<_> = inputs.iter().map(|input| read(&bench, input)).collect();
            assert!(seen.iter().all(|seen| *seen == f64::from(level)), "{inputs:?} are {seen:?}");
            bench.advance_by(500_000_000);
            assert!(inputs.iter().all(|input| read(&bench, input) == f64::from(level)), "it stays");
        }
    }
}

#[test]
fn without_power_an_output_is_low() {
    let mut bench = bench(&format!("{TWO}[[event]]\nat = 1\nset = {{ \"m1.power\" = \"off\" }}\n"));
    set_output(&mut bench, 0, 0, 1);
    bench.advance_to(1_000_000_000);
    assert_eq!(read(&bench, "m2.input.1"), 1.0);
    bench.advance_by(2 * TICK_NS);
    assert_eq!(read(&bench, "m2.input.1"), 0.0);
}

#[test]
fn modules_do_not_feel_each_others_loads() {
    let alone = {
        let mut bench = bench("[[module]]\nkind = \"tmcm-1311\"\naddress = 1\n");
        bench.advance_to(500_000_000);
        bench.physical(ModuleId(0))
    };
    let mut bench = bench(TWO);
    bench.apply(ModuleId(1), config::Setting::LoadTorqueNm(0.3));
    bench.advance_to(500_000_000);
    assert_eq!(bench.physical(ModuleId(0)), alone);
    assert!(bench.physical(ModuleId(1)).rotor_turns > 0.0);
}
