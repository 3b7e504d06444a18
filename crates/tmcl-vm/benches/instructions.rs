//! How many instructions the interpreter executes in a second, on a machine that is nothing but memory.
#![allow(missing_docs, reason = "criterion's macros make undocumented items")]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use tmcl_tables::{Command, Status};
use tmcl_vm::{Machine, NeverHalt, Vm, WaitEvent, step};
use tmcl_wire::Request;

/// Instructions in a run.
const INSTRUCTIONS: u64 = 1_000_000;

struct Bare {
    vm: Vm,
    memory: [[u8; 7]; 2048],
}

impl Machine for Bare {
    const WAIT_TICK: u64 = 200;

    fn vm(&self) -> &Vm {
        &self.vm
    }

    fn vm_mut(&mut self) -> &mut Vm {
        &mut self.vm
    }

    fn now(&self) -> u64 {
        0
    }

    fn fetch(&self, address: u16) -> Option<[u8; 7]> {
        self.memory.get(usize::from(address)).copied()
    }

    fn has_command(&self, _number: u8) -> bool {
        true
    }

    fn has_interrupt(&self, _number: u8) -> bool {
        true
    }

    fn has_motor(&self, motor: u8) -> bool {
        motor == 0
    }

    fn has_happened(&self, _event: WaitEvent) -> bool {
        true
    }

    fn execute(&mut self, request: &Request) -> Result<i32, Status> {
        Ok(request.value)
    }
}

/// Counts down from 1000 through a subroutine, for ever.
fn program() -> [[u8; 7]; 2048] {
    let mut memory = [[0; 7]; 2048];
    let instructions = [
        Request::new(Command::Calculate, 9, 0, 1000),
        Request::new(Command::CallSubroutine, 0, 0, 5),
        Request::new(Command::Compare, 0, 0, 0),
        Request::new(Command::JumpConditional, 4, 0, 1),
        Request::new(Command::Jump, 0, 0, 0),
        Request::new(Command::Calculate, 1, 0, 1),
        Request::new(Command::ReturnFromSubroutine, 0, 0, 0),
    ];
    for (slot, instruction) in memory.iter_mut().zip(instructions) {
        *slot = instruction.to_bytes();
    }
    memory
}

fn instructions(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("vm");
    group.throughput(Throughput::Elements(INSTRUCTIONS));
    let mut machine = Bare { vm: Vm::default(), memory: program() };
    machine.vm.run_from(0);
    group.bench_function("instructions", |bencher| {
        bencher.iter(|| {
            for _ in 0..INSTRUCTIONS {
                std::hint::black_box(step(&mut machine, &mut NeverHalt));
            }
        });
    });
    group.finish();
}

criterion_group!(benches, instructions);
criterion_main!(benches);
