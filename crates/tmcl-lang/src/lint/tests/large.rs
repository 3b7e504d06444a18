//! Full program memories: any instructions at all.

use proptest::prelude::*;
use tmcl_tables::tmcm_1311;

use crate::instruction::Instruction;
use crate::lint::lint;
use crate::program::Program;
use crate::source::{Sources, Span};

fn program(instructions: Vec<Instruction>) -> Program {
    let origin = Span { file: Sources::ROOT, start: 0, end: 0 };
    Program {
        module: &tmcm_1311::SPEC,
        origins: vec![origin; instructions.len()],
        instructions,
        appended_stop: false,
        labels: Vec::new(),
        constants: Vec::new(),
    }
}

/// Mostly instructions that matter to the flow.
fn any_instruction(len: i32) -> impl Strategy<Value = Instruction> {
    let flow = prop::sample::select(vec![5_u8, 21, 22, 23, 24, 25, 27, 28, 37, 38]);
    let command = prop_oneof![9 => flow, 1 => any::<u8>()];
    let value = prop_oneof![9 => -1..=len, 1 => any::<i32>()];
    (command, 0..14_u8, value).prop_map(|(command, kind, value)| Instruction {
        command,
        kind,
        motor: 0,
        value,
    })
}

proptest! {
    #[test]
    fn nothing_panics_and_all_that_is_not_reached_is_said(
        instructions in prop::collection::vec(any_instruction(40), 0..40),
        appended_stop: bool,
    ) {
        let mut program = program(instructions);
        program.appended_stop = appended_stop;
        let found = lint(&program, &Sources::default());
        prop_assert!(found.iter().all(|it| !it.message.is_empty() && !it.message.ends_with('.')));
    }
}

/// Calls and jumps that lead everywhere: the most work there can be.
#[test]
fn a_full_memory_takes_no_native_stack() {
    let call = |value| Instruction { command: 23, kind: 0, motor: 0, value };
    let chain: Vec<_> = (1..=2048).map(call).collect();
    let back: Vec<_> = (0..2048).map(|address| call(2047 - address)).collect();
    let stray = vec![Instruction { command: 24, ..Instruction::default() }; 2048];
    for instructions in [chain, back, stray] {
        assert!(!lint(&program(instructions), &Sources::default()).is_empty());
    }
}
