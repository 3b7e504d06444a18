//! Text of instructions, and back.

use proptest::prelude::*;
use tmcl_tables::{MODULES, ModuleSpec, module_by_id, tmcm_1076, tmcm_1311, tmcm_1640};

use super::disassemble;
use crate::assemble::{Assembly, assemble};
use crate::format::format;
use crate::instruction::Instruction;
use crate::resolver::NoIncludes;
use crate::source::SourceFile;

fn it(command: u8, kind: u8, motor: u8, value: i32) -> Instruction {
    Instruction { command, kind, motor, value }
}

fn assembled(text: &str) -> Assembly {
    let root = SourceFile { name: "test.tmc".to_owned(), bytes: text.into(), builtin: false };
    assemble(root, None, &mut NoIncludes)
}

#[test]
fn a_program_in_its_own_words() {
    let instructions = [
        it(37, 3, 0, 10),
        it(25, 3, 0, 0),
        it(25, 255, 0, 0),
        it(9, 0, 3, -1),
        it(5, 4, 0, 50_000),
        it(5, 140, 0, 8),
        it(4, 0, 0, -51_200),
        it(27, 1, 0, 0),
        it(21, 8, 0, 6),
        it(22, 0, 0, 4),
        it(14, 255, 2, -1),
        it(15, 0, 1, 0),
        it(33, 10, 0, 0),
        it(38, 0, 0, 0),
    ];
    insta::assert_snapshot!(disassemble(&instructions, &tmcm_1311::SPEC), @r#"
    //! module: tmcm-1311

        VECT 3, L_10          // Target position reached
        EI 3                  // Target position reached
        EI 255                // interrupts as a whole
        SGP 0, 3, 4294967295  // Timer 0 period [ms]

    L_4:
        SAP 4, 0, 50000  // Maximum positioning speed [pps]
        SAP 140, 0, 8    // Microstep resolution: 256 microsteps

    L_6:
        MVP ABS, 0, -51200
        WAIT POS, 0, 0
        JC ETO, L_6
        JA L_4

    L_10:
        SIO 255, 2, -1  // all at once
        GIO 0, 1        // AIN_0, 0 to 10 V
        CALCX SWAP
        RETI
    "#);
}

#[test]
fn what_no_operands_can_say() {
    let instructions = [
        it(77, 1, 2, 3),
        it(28, 0, 0, 1),
        it(5, 254, 0, 1),
        it(5, 4, 1, 1),
        it(5, 1, 0, 0),
        it(5, 8, 0, 0),
        it(5, 6, 0, 256),
        it(14, 0, 0, 1),
        it(22, 0, 0, -1),
        it(22, 0, 0, 2000),
        it(37, 255, 0, 0),
        it(129, 0, 0, 0),
    ];
    insta::assert_snapshot!(disassemble(&instructions, &tmcm_1311::SPEC), @r#"
    //! module: tmcm-1311
    //! no-final-stop

        DATA 77, 1, 2, 3    // no command of a program
        DATA 28, 0, 0, 1    // STOP, with fields set that it does not use
        SAP 254, 0, 1       // Step/Dir mode: ENABLE selects hold or run current; closed loop: switches the motor off or on
        DATA 5, 4, 1, 1     // the TMCM-1311 has no motor 1
        SAP 1, 0, 0         // Actual position [µstep]
        DATA 5, 8, 0, 0     // axis parameter 8 (Target pos. reached) can only be read
        DATA 5, 6, 0, 256   // axis parameter 6 (Absolute max. current (CS / Current Scale)) does not take 256
        DATA 14, 0, 0, 1    // port 0 of bank 0 (AIN_0, read as a digital input) is an input
        DATA 22, 0, 0, -1   // -1 is no address in the program memory of the TMCM-1311
        JA 2000
        DATA 37, 255, 0, 0  // 255 stands for all interrupts and has no routine of its own
        DATA 129, 0, 0, 0   // no command of a program
    "#);
}

#[test]
fn nothing_at_all() {
    insta::assert_snapshot!(disassemble(&[], &tmcm_1640::SPEC), @r#"
    //! module: tmcm-1640
    //! no-final-stop
    "#);
}

#[test]
fn nothing_is_held_against_a_module_without_programs() {
    insta::assert_snapshot!(disassemble(&[it(5, 4, 7, 1), it(28, 1, 0, 0), it(22, 0, 0, 0)], &tmcm_1076::SPEC), @r#"
    //! module: tmcm-1076

    L_0:
        SAP 4, 7, 1
        DATA 28, 1, 0, 0  // STOP, with fields set that it does not use
        JA L_0
    "#);
}

/// Instructions that are mostly near what modules take.
fn any_instruction() -> impl Strategy<Value = Instruction> {
    let command = prop_oneof![8 => 0..40_u8, 1 => 64..72_u8, 1 => any::<u8>()];
    let kind = prop_oneof![4 => 0..14_u8, 4 => any::<u8>(), 1 => Just(255)];
    let motor = prop_oneof![8 => Just(0_u8), 2 => 0..4_u8, 1 => any::<u8>(), 1 => Just(255)];
    let value = prop_oneof![4 => Just(0), 4 => -2..70_i32, 1 => 0..2100_i32, 2 => any::<i32>()];
    (command, kind, motor, value).prop_map(|(command, kind, motor, value)| it(command, kind, motor, value))
}

/// By its identifier: the whole table would be printed otherwise when a test fails.
fn any_module() -> impl Strategy<Value = &'static str> {
    let with_programs = MODULES.iter().filter(|module| module.program_memory > 0);
    prop::sample::select(with_programs.map(|module| module.id).collect::<Vec<_>>())
}

fn module(id: &str) -> &'static ModuleSpec {
    module_by_id(id).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn the_text_assembles_to_the_same_bytes(
        id in any_module(),
        instructions in prop::collection::vec(any_instruction(), 0..60),
    ) {
        let text = disassemble(&instructions, module(id));
        let assembly = assembled(&text);
        prop_assert!(!assembly.has_errors(), "{:#?}\n{text}", assembly.diagnostics);
        prop_assert_eq!(&assembly.program.instructions, &instructions, "{}", text);
        prop_assert_eq!(assembly.program.module.id, id);
        prop_assert!(!assembly.program.appended_stop);
    }

    #[test]
    fn any_bytes_at_all(bytes in prop::collection::vec(any::<[u8; 7]>(), 0..40)) {
        let instructions: Vec<_> = bytes.into_iter().map(Instruction::from_bytes).collect();
        for module in MODULES.iter().copied() {
            let text = disassemble(&instructions, module);
            prop_assert_eq!(&assembled(&text).program.instructions, &instructions, "{}", text);
        }
    }

    #[test]
    fn the_text_is_laid_out(
        id in any_module(),
        instructions in prop::collection::vec(any_instruction(), 0..60),
    ) {
        let text = disassemble(&instructions, module(id));
        prop_assert_eq!(String::from_utf8(format(text.as_bytes())).unwrap(), text);
    }
}

#[test]
fn what_the_assembler_only_warns_of_and_what_does_nothing() {
    let instructions =
        [it(27, 0, 7, -5), it(27, 1, 0, -1), it(19, 8, 0, 5), it(11, 132, 0, 0), it(12, 0, 3, 0)];
    insta::assert_snapshot!(disassemble(&instructions, &tmcm_1311::SPEC), @r#"
    //! module: tmcm-1311
    //! no-final-stop

        WAIT TICKS, 7, -5
        WAIT POS, 0, -1
        CALC NOT, 5
        STGP 132, 0       // Tick timer [ms]
        DATA 12, 0, 3, 0  // global parameter 0 in bank 3 (Timer 0 period) is not kept in the EEPROM
    "#);
}

#[test]
fn no_instruction_is_to_blame_for_too_many() {
    let instructions = vec![it(3, 0, 0, 0); 2100];
    let text = disassemble(&instructions, &tmcm_1311::SPEC);
    assert_eq!(text.matches("MST 0").count(), 2100);
}

#[test]
fn a_full_memory_is_said_and_read_back() {
    let instructions: Vec<_> = (0..2048).map(|address| it(23, 0, 0, 2047 - address)).collect();
    let text = disassemble(&instructions, &tmcm_1311::SPEC);
    let assembly = assembled(&text);
    assert!(!assembly.has_errors());
    assert_eq!(assembly.program.instructions, instructions);
}
