//! What holds for any program: nothing panics, each step is one instruction at most, and looking on changes nothing.

mod common;

use common::*;
use proptest::prelude::*;
use tmcl_tables::Command;
use tmcl_vm::{Stepped, Vm};
use tmcl_wire::Request;

/// What happens to a machine between two steps.
#[derive(Clone, Debug)]
enum Input {
    Time(u64),
    Happened(usize, bool),
    Interrupt(u8),
    Run(u16),
    Resume,
    Stop,
    Step,
    Reset,
}

fn inputs() -> impl Strategy<Value = Option<Input>> {
    prop_oneof![
        30 => Just(None),
        5 => (0..40_u64).prop_map(|time| Some(Input::Time(time))),
        3 => (0..4_usize, any::<bool>()).prop_map(|(event, on)| Some(Input::Happened(event, on))),
        6 => prop_oneof![0..4_u8, Just(15), Just(46), any::<u8>()].prop_map(|number| Some(Input::Interrupt(number))),
        1 => (0..70_u16).prop_map(|address| Some(Input::Run(address))),
        2 => Just(Some(Input::Resume)),
        1 => Just(Some(Input::Stop)),
        1 => Just(Some(Input::Step)),
        1 => Just(Some(Input::Reset)),
    ]
}

/// Instructions that do something together: addresses near, interrupts there are.
fn instruction() -> impl Strategy<Value = Request> {
    let address = || prop_oneof![20 => 0..64_i32, 1 => Just(64), 1 => any::<i32>()];
    let interrupt = || prop_oneof![0..4_u8, Just(15), Just(46), Just(255), any::<u8>()];
    let number = || prop_oneof![-3..4_i32, Just(i32::MIN), Just(i32::MAX), any::<i32>()];
    prop_oneof![
        4 => (0..11_u8, number()).prop_map(|(operation, value)| calc(operation, value)),
        3 => (0..12_u8).prop_map(calcx),
        3 => number().prop_map(comp),
        4 => (0..14_u8, address()).prop_map(|(condition, to)| jc(condition, to)),
        2 => address().prop_map(ja),
        3 => address().prop_map(csub),
        3 => Just(rsub()),
        4 => (0..6_u8, number()).prop_map(|(kind, ticks)| wait(kind, ticks)),
        1 => (0..7_u8).prop_map(cle),
        3 => (interrupt(), address()).prop_map(|(number, to)| vect(number, to)),
        4 => interrupt().prop_map(ei),
        1 => interrupt().prop_map(di),
        2 => Just(reti()),
        1 => Just(stop()),
        3 => number().prop_map(sap),
        3 => number().prop_map(gap),
        2 => any::<[u8; 7]>().prop_map(Request::from_bytes),
    ]
}

fn machine(program: &[Request]) -> Bare {
    let mut machine = Bare::running(program);
    // Interrupts from the start, or few programs would ever get one.
    machine.memory[60] = ei(0).to_bytes();
    machine.memory[61] = ei(3).to_bytes();
    machine.memory[62] = ei(255).to_bytes();
    machine.memory[63] = ja(0).to_bytes();
    machine.vm.run_from(60);
    machine
}

fn apply(machine: &mut Bare, input: &Input) {
    match *input {
        Input::Time(time) => machine.now += time,
        Input::Happened(event, on) => machine.happened[event] = on,
        Input::Interrupt(number) => machine.vm.raise(number),
        Input::Run(address) => machine.vm.run_from(address),
        Input::Resume => machine.vm.resume(),
        Input::Stop => machine.vm.stop(),
        Input::Step => machine.vm.single_step(),
        Input::Reset => machine.vm.reset(),
    }
}

fn is_flow(command: u8) -> bool {
    [
        Command::Calculate,
        Command::CalculateX,
        Command::Compare,
        Command::JumpConditional,
        Command::Jump,
        Command::CallSubroutine,
        Command::ReturnFromSubroutine,
        Command::Wait,
        Command::Stop,
        Command::ClearErrorFlags,
        Command::SetInterruptVector,
        Command::EnableInterrupt,
        Command::DisableInterrupt,
        Command::ReturnFromInterrupt,
    ]
    .iter()
    .any(|flow| flow.number() == command)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, failure_persistence: None, ..ProptestConfig::default() })]

    /// Each unit of time one machine makes one step; the other is asked for as many as its debugger halts, and one more.
    #[test]
    fn halting_anywhere_and_going_on_is_never_halting(
        program in prop::collection::vec(instruction(), 1..60),
        inputs in prop::collection::vec(inputs(), 1..400),
        halts in prop::collection::vec(any::<bool>(), 64),
    ) {
        let mut undisturbed = machine(&program);
        let mut watched = undisturbed.clone();
        for input in &inputs {
            if let Some(input) = input {
                apply(&mut undisturbed, input);
                apply(&mut watched, input);
            }
            let wanted = undisturbed.tick();
            // It halts, is looked at, and goes on; now and then it halts at the same place again.
            let mut patience = 2;
            let mut halt = |_: &Bare, address: u16| {
                let halts = halts.get(usize::from(address)).copied().unwrap_or(false) && patience > 0;
                patience -= i32::from(halts);
                halts
            };
            let stepped = loop {
                match watched.step_unless(&mut halt) {
                    Stepped::Halted { .. } => {}
                    stepped => break stepped,
                }
            };
            watched.now += 1;
            prop_assert_eq!(stepped, wanted);
            prop_assert_eq!(&watched, &undisturbed);
        }
    }

    /// Any memory, any inputs: no panic, at most one command of the module a step, addresses within reach, and a program
    /// that is not active does nothing.
    #[test]
    fn nothing_panics_and_work_is_bounded(
        memory in prop::collection::vec(any::<[u8; 7]>(), 0..300),
        inputs in prop::collection::vec(inputs(), 1..300),
        start: u16,
    ) {
        let mut machine = Bare { vm: Vm::default(), memory, now: 0, happened: [false; 4], log: Vec::new() };
        machine.vm.run_from(start);
        for input in inputs.iter().flatten() {
            apply(&mut machine, input);
            let (before, active) = (machine.clone(), machine.vm.is_active());
            let stepped = machine.tick();
            prop_assert!(machine.log.len() <= before.log.len() + 1);
            prop_assert!(machine.vm.calls().len() <= tmcl_vm::DEPTH);
            prop_assert_eq!(&machine.memory, &before.memory);
            if !active {
                prop_assert_eq!(stepped, Stepped::Idle);
                prop_assert_eq!(&machine.vm, &before.vm);
            }
            if machine.vm.is_active() && machine.vm != before.vm {
                let end = u16::try_from(machine.memory.len()).unwrap();
                let started = machine.vm.address() == before.vm.address();
                prop_assert!(started || machine.vm.address() <= end);
            }
        }
    }

    /// Flow control is the interpreter's; the module sees only the rest.
    #[test]
    fn the_module_is_not_asked_about_flow_control(
        program in prop::collection::vec(instruction(), 1..60),
        inputs in prop::collection::vec(inputs(), 1..300),
    ) {
        let mut machine = machine(&program);
        for input in &inputs {
            if let Some(input) = input {
                apply(&mut machine, input);
            }
            machine.tick();
        }
        prop_assert!(machine.log.iter().all(|request| !is_flow(request.command)));
    }
}
