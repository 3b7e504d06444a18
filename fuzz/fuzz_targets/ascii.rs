//! Any characters to the ASCII interface: the tables of every module judge them without a panic, and at a module in ASCII
//! mode each line for it gets one whole reply, and nothing else gets any.
#![no_main]

use std::cell::LazyCell;

use libfuzzer_sys::fuzz_target;
use tmcl_tables::{Command, MODULES};
use tmcl_wire::Request;
use tmcl_wire::ascii::{CommandLine, Input, Typed};
use tmcl_wire::serial::encode_request;
use virtual_bench::{Bench, BenchConfig, ModuleId, ModuleKind, PortId};

const MODULE: ModuleId = ModuleId(0);
const PORT: PortId = PortId::ALL[0];
const ADDRESS: u8 = 1;

/// Bit 5 of global parameter 67: only replies are sent.
const NO_ECHO: i32 = 0x20;

thread_local! {
    static IN_ASCII: LazyCell<Bench> = LazyCell::new(|| {
        let mut bench = Bench::new(&BenchConfig::default_for(ModuleKind::Tmcm1311));
        for request in [
            Request::new(Command::SetGlobalParameter, 67, 0, NO_ECHO),
            Request::new(Command::EnterAsciiMode, 0, 0, 0),
        ] {
            let reply = bench.exchange(MODULE, PORT, &encode_request(ADDRESS, request));
            assert_eq!(reply[2], 100);
        }
        bench
    });
}

/// Whether what follows a line may be answered otherwise: BIN, and settings of the interface.
fn is_the_end(line: &CommandLine) -> bool {
    let ends = [Command::SetGlobalParameter, Command::AccumulatorToGlobalParameter].map(Command::number);
    match line.input(ModuleKind::Tmcm1311.spec()) {
        Ok(Input::Binary) => true,
        Ok(Input::Request(request)) => ends.contains(&request.command),
        Err(_) => false,
    }
}

fn is_reply(text: &str) -> bool {
    let mut fields = text.split(' ');
    let letters = fields.next() == Some("BA");
    let status = fields.next().is_some_and(|status| ["2", "3", "4", "5", "6", "100"].contains(&status));
    letters
        && status
        && fields.next().is_some_and(|value| value.parse::<i32>().is_ok())
        && fields.next().is_none()
}

fuzz_target!(|data: &[u8]| {
    let mut bench = IN_ASCII.with(|bench| Bench::clone(bench));
    let mut line = CommandLine::new();
    for byte in data {
        let ended = line.push(*byte) == Typed::Ended;
        let ours = ended && line.is_for(ADDRESS);
        if ended {
            for module in MODULES {
                let _ = line.input(module);
            }
            if ours && is_the_end(&line) {
                return;
            }
            line.clear();
        }
        let heard = bench.exchange(MODULE, PORT, &[*byte]);
        let heard = String::from_utf8(heard).expect("ASCII");
        match heard.strip_suffix('\r') {
            Some(reply) => assert!(ours && is_reply(reply), "{heard:?}"),
            None => assert!(!ours && heard.is_empty(), "{heard:?}"),
        }
    }
});
