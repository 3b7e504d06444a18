//! Any program with any inputs on a virtual module: nothing panics, and a control period executes no more than its share.
#![no_main]

use libfuzzer_sys::fuzz_target;
use tmcl_wire::Request;
use tmcl_wire::serial::encode_request;
use virtual_bench::config::Setting;
use virtual_bench::{Bench, BenchConfig, ModuleId, ModuleKind, PortId, TICK_NS};

const MODULE: ModuleId = ModuleId(0);
const CAPACITY: usize = 2048;

/// Sends a request and checks that the answer is whole datagrams.
fn send(bench: &mut Bench, port: PortId, request: Request) {
    let answer = bench.exchange(MODULE, port, &encode_request(1, request));
    assert_eq!(answer.len() % 9, 0);
}

/// What happens to the module between two stretches of time: a byte says what, another with which number.
fn happen(bench: &mut Bench, what: u8, number: u8) {
    let request = |command, kind, motor, value| Request { command, kind, motor, value };
    let port = PortId::ALL[usize::from(number % 4)];
    match what % 16 {
        0..=3 => bench.apply(MODULE, Setting::Input { number: number % 8, high: what & 1 != 0 }),
        4 => {
            bench.apply(MODULE, Setting::AnalogInput { number: number & 4, reading: u16::from(number) << 4 })
        }
        5 => bench.apply(MODULE, Setting::DroppedSteps(i32::from(number) - 128)),
        6 => send(bench, port, request(128, 0, 0, 0)),
        7 => send(bench, port, request(129, 0, 0, 0)),
        8 => send(bench, port, request(129, 1, 0, i32::from(number) * 9)),
        9 => send(bench, port, request(130, 0, 0, 0)),
        10 => send(bench, port, request(131, 0, 0, 0)),
        11 => send(bench, port, request(10, number, 0, 0)),
        12 => send(bench, port, request(9, number % 3, 3, i32::from(number))),
        13 => send(bench, port, request(4, 0, 0, i32::from(number) - 128)),
        14 => send(bench, port, request(134, 0, 0, i32::from(number))),
        _ => bench.advance_by(u64::from(number) * 1_000_000),
    }
}

fuzz_target!(|data: &[u8]| {
    // How many bytes of inputs; the rest are instructions of seven bytes.
    let Some((&[instructions_per_tick, length], data)) = data.split_first_chunk() else { return };
    let (inputs, program) = data.split_at(data.len().min(usize::from(length)));
    let mut config = BenchConfig::default_for(ModuleKind::Tmcm1311);
    config.modules[0].instructions_per_tick = u16::from(instructions_per_tick).max(1);
    let mut bench = Bench::new(&config);
    send(&mut bench, PortId::ALL[0], Request { command: 132, ..Request::default() });
    let (instructions, _) = program.as_chunks();
    for instruction in instructions.iter().take(CAPACITY) {
        let request = Request::from_bytes(*instruction);
        // These would be executed, 133 among them; 139 ends the binary conversation.
        if !(128..=139).contains(&request.command) {
            send(&mut bench, PortId::ALL[0], request);
        }
    }
    send(&mut bench, PortId::ALL[0], Request { command: 133, ..Request::default() });
    send(&mut bench, PortId::ALL[0], Request { command: 129, kind: 1, ..Request::default() });
    for pair in inputs.chunks_exact(2) {
        bench.advance_by(u64::from(pair[0] >> 4) * TICK_NS);
        happen(&mut bench, pair[0], pair[1]);
        let refused: u64 = bench.refused_instructions(MODULE).map(|refused| refused.count).sum();
        let periods = bench.time_ns() / TICK_NS + inputs.len() as u64;
        assert!(refused <= periods, "more than one refusal a control period or single step");
        let counter = bench.program(MODULE).map_or(0, |program| usize::from(program.address()));
        assert!(counter <= CAPACITY);
    }
    bench.advance_by(5_000_000);
});
