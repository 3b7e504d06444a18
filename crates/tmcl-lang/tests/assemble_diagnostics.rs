//! What the assembler says: one text for each code, and what it must not say.

mod assemble_support;

use assemble_support::{alone, alone_for, clean, codes, instruction, render, written};
use insta::assert_snapshot;

#[test]
fn e0101_unknown_mnemonic() {
    assert_snapshot!(render(&alone("SPA 4, 0, 500\nHALT\nBIN\nruf3 0, 0, 0\n")));
}

#[test]
fn e0102_operand_count() {
    assert_snapshot!(render(&alone(
        "SAP 4, 0\nSAP\nMVP ABS, 0, 1, 2\nMST\nSTOP 0\nAAP 0, 0, 5\nGAP 1, 0, 0, 0\nCALC ADD\nWAIT TICKS, 100\nMVP 0, 10\n"
    )));
}

#[test]
fn e0103_operand_kind() {
    let text = "Loop: SAP 4, 0, Loop\nMVP ABD, 0, 5\nJC Loop, Loop\nJC 13, Loop\nJC -EQ, Loop\nJA -Loop\nWAIT 7, 0, 0\nX = Loop\n";
    assert_snapshot!(render(&alone(text)));
}

#[test]
fn e0104_undefined_name() {
    let text = "MaxSpeed = 500\nSAP 4, 0, MaxSped\nSAP 5, 0, Below\nBelow = 7\nSAP 6, 0, -Nothing\nEI TI_GLOBAL\nOther = Missing\nSAP 7, 0, Other\nSAP APMaxVelocty, 0, 1\n";
    assert_snapshot!(render(&alone(text)));
}

#[test]
fn e0105_undefined_label() {
    assert_snapshot!(render(&alone(
        "MainLoop: JA MianLoop\nCSUB Sub\nVECT 0, Routine\nJC ZE, Later\nLater = 0\nJA Later\n"
    )));
}

#[test]
fn e0106_duplicate_label() {
    assert_snapshot!(render(&alone("Loop: MST 0\nloop:\nLOOP: JA Loop\n")));
}

#[test]
fn e0107_operand_range() {
    let text = "Far = -2147483648\nSAP 300, 0, 5\nGAP -1, 0\nSGP 1, 256, 0\nCOMP 4294967295\nCOMP -2147483649\nMVP ABS, 0, 2147483648\n";
    assert_snapshot!(render(&alone(text)));
}

#[test]
fn e0201_missing_command() {
    assert_snapshot!(render(&alone_for("1640", "SCO 1, 0, 100\nMVP COORD, 0, 1\nRFS START, 0\nEI 255\n")));
}

#[test]
fn e0202_unknown_parameter() {
    assert_snapshot!(render(&alone(
        "SAP 253, 0, 8\nGAP 21, 0\nSGP 1, 1, 0\nGGP 63, 0\nAGP 5, 3\nSTGP 200, 0\n"
    )));
    assert_snapshot!("e0202_others_have_one", render(&alone_for("1640", "GAP 5, 0\nGAP 140, 0\n")));
}

#[test]
fn e0203_read_only_parameter() {
    assert_snapshot!(render(&alone("SAP 8, 0, 1\nAAP 133, 0\nSGP 130, 0, 0\nAGP 128, 0\n")));
}

#[test]
fn e0204_write_only_parameter() {
    assert_snapshot!(render(&alone("GAP 29, 0\nSAP 29, 0, 0\n")));
}

#[test]
fn e0205_not_storable() {
    assert_snapshot!(render(&alone("STAP 0, 0\nRSAP 8, 0\nSTGP 56, 2\nRSGP 0, 3\n")));
}

#[test]
fn stgp_and_rsgp_take_all_of_bank_0() {
    assert_eq!(
        clean("STGP 132, 0\nRSGP 132, 0\nSTGP 66, 0\nRSGP 130, 0\n"),
        [(11, 132), (12, 132), (11, 66), (12, 130)].map(|(command, kind)| instruction(command, kind, 0, 0))
    );
    assert_eq!(codes(&alone("STGP 63, 0\nRSGP 63, 0\nSTGP 0, 3\n")), ["E0202", "E0202", "E0205"]);
}

#[test]
fn e0206_parameter_range() {
    let text = "Current = 300\nSAP 6, 0, Current\nSAP 140, 0, 9\nSAP 4, 0, -1\nSGP 73, 0, 1\nSGP 39, 3, 4\nSAP 129, 0, 4294967295\n";
    assert_snapshot!(render(&alone(text)));
}

#[test]
fn e0207_unknown_port() {
    assert_snapshot!(render(&alone(
        "SIO 8, 2, 1\nSIO 0, 0, 1\nSIO 255, 1, 1\nGIO 1, 1\nGIO 255, 2\nGIO 0, 5\n"
    )));
    assert_snapshot!("e0207_on_the_tmcm_1640", render(&alone_for("1640", "SIO 1, 2, 1\nGIO 2, 0\n")));
}

#[test]
fn e0208_unknown_coordinate() {
    assert_snapshot!(render(&alone("SCO 21, 0, 5\nMVP COORD, 0, -1\nCCO 255, 0\nACO 30, 0\nGCO 21, 255\n")));
}

#[test]
fn e0209_unknown_interrupt() {
    assert_snapshot!(render(&alone("L: VECT 255, L\nEI 4\nDI 47\nVECT 38, L\n")));
}

#[test]
fn e0210_unknown_motor() {
    assert_snapshot!(render(&alone(
        "MST 1\nROR 2, 100\nSAP 4, 1, 500\nAAP 42, 2\nSAP 0, 3, 100\nSCO 1, 254, 0\nWAIT POS, 1, 0\n"
    )));
}

#[test]
fn e0211_program_too_long() {
    let full = "MST 0\n".repeat(2047);
    assert_eq!(codes(&alone(&full)), [""; 0]);
    assert_eq!(alone(&full).program.instructions.len(), 2048);
    assert_snapshot!(render(&alone(&format!("{full}MST 0\n"))));
    assert_snapshot!(
        "e0211_by_more_than_the_stop",
        render(&alone(&format!("{full}MST 0\nROL 0, 5\nMST 0\nEnd: JA End\n")))
    );
    assert_snapshot!("e0211_no_program_memory", render(&alone_for("1076", "SAP 6, 0, 99\nMVP ABS, 0, 5\n")));
    assert!(!alone_for("1076", "X = 5\n").has_errors());
}

#[test]
fn labels_beyond_what_an_address_holds_do_no_harm() {
    let text = format!("{}End: JA End\n", "MST 0\n".repeat(70_000));
    assert_eq!(codes(&alone(&text)), ["E0211"]);
}

#[test]
fn e0212_unknown_module() {
    assert_snapshot!(render(&alone("// A comment.\n\n//! module: tmcm-1312\nSCO 99, 7, 1\n")));
    assert_snapshot!("e0212_no_name", render(&alone("//! module:\n")));
    assert!(alone("//! module: tmcm-1312\n").module_is_named);
}

#[test]
fn e0213_value_range() {
    let text = "Fast = 400000000\nROR 0, Fast\nROL 0, -327678001\nSIO 0, 2, 2\nSIO 255, 2, 256\nSIO 255, 2, -2\nJA 2048\nVECT 0, -1\n";
    assert_snapshot!(render(&alone(text)));
}

#[test]
fn w0014_stray_comma() {
    let assembly = alone("EI, 255\n");
    assert_snapshot!(render(&assembly));
    assert_eq!(written(&assembly), [instruction(25, 255, 0, 0)]);
}

#[test]
fn w0015_surplus_operand() {
    let assembly = alone("GAP 1, 0, 0\nGIO 0, 2, 1\nGCO 1, 0, 0\n");
    assert_snapshot!(render(&assembly));
    assert_eq!(
        written(&assembly),
        [instruction(6, 1, 0, 0), instruction(15, 0, 2, 0), instruction(31, 1, 0, 0)]
    );
}

#[test]
fn w0017_negative_time() {
    let text = "WAIT TICKS, 0, -1\nWAIT TICKS, 0, -2\nWAIT POS, 0, -1\nWAIT RFS, 0, $FFFFFFFF\n";
    assert_snapshot!(render(&alone(text)));
}

#[test]
fn a_mistake_is_reported_once() {
    // The parser's mistakes leave nothing to say about operands.
    assert_eq!(codes(&alone("SAP 4, 0, 99999999999\n")), ["E0003"]);
    assert_eq!(codes(&alone("X = 99999999999\nSAP 6, 0, X\nMST X\n")), ["E0003"]);
    assert_eq!(codes(&alone("X =\nSAP 4, 0, X\n")), ["E0002"]);
    assert_eq!(codes(&alone("SAP 4 0 500\n")), ["E0002"]);
    // An operand that nothing is known of is not held against ranges, nor is what depends on it.
    assert_eq!(codes(&alone("SAP Missing, 0, -5\n")), ["E0104"]);
    assert_eq!(codes(&alone("SGP 1, Missing, 5\n")), ["E0104"]);
    assert_eq!(codes(&alone("X = Missing\nSAP X, 0, 5\nY = X\nSAP Y, 0, 5\n")), ["E0104"]);
    assert_eq!(codes(&alone("MVP Missing, 0, 5\n")), ["E0103"]);
    assert_eq!(codes(&alone("SAP 999, 0, -5\n")), ["E0107"]);
    assert_eq!(codes(&alone("SAP 8, 0, -5\n")), ["E0203"]);
    assert_eq!(codes(&alone_for("1640", "SCO 99, 0, 5\n")), ["E0201"]);
    // Several mistakes are several.
    assert_eq!(codes(&alone("SAP 300, 1, Missing\n")), ["E0107", "E0210", "E0104"]);
}

#[test]
fn labels_stand_before_constants_and_numbers_in_jumps() {
    let text = "Target = 5\nTarget: JA Target\nAddress = 3\nJA Address\nJA 7\nJA $7FF\n";
    let expected = [0, 3, 7, 2047].map(|address| instruction(22, 0, 0, address));
    assert_eq!(clean(text), expected);
}

#[test]
fn names_are_the_same_in_any_case() {
    let text = "MAXspeed = 500\nsap 4, 0, maxSPEED\nlOOp: mvp abs, 0, 1\nja LOOP\n";
    assert_eq!(clean(text), [instruction(5, 4, 0, 500), instruction(4, 0, 0, 1), instruction(22, 0, 0, 1)]);
}

#[test]
fn the_last_definition_above_counts() {
    let text = "A = 1\nCOMP A\nB = A\nA = -2\nCOMP A\nCOMP -A\nCOMP B\nC = -A\nA = A\nCOMP C\nCOMP A\n";
    assert_eq!(clean(text), [1, -2, 2, 1, 2, -2].map(|value| instruction(20, 0, 0, value)));
    let constants = alone(text).program.constants;
    let told: Vec<_> =
        constants.iter().map(|constant| (constant.name.as_str(), constant.value, constant.uses)).collect();
    assert_eq!(told, [("A", 1, 2), ("B", 1, 1), ("A", -2, 4), ("C", 2, 1), ("A", -2, 1)]);
}

#[test]
fn hexadecimal_and_unsigned_values_use_all_bits() {
    assert_eq!(
        clean("COMP $FFFFFFFF\nCOMP 0x80000000\nX = $FFFFFFFE\nCALC AND, X\n"),
        [instruction(20, 0, 0, -1), instruction(20, 0, 0, i32::MIN), instruction(19, 5, 0, -2),]
    );
    assert_eq!(clean("SAP 26, 0, 4294967295\nSAP 26, 0, -1\n"), [instruction(5, 26, 0, -1); 2]);
}

#[test]
fn special_forms() {
    let text = "SIO 255, 2, 255\nSIO 255, 2, -1\nGIO 255, 0\nSCO 0, 255, 0\nGCO 0, 255, 0\nGCO 20, 255\nEI 255\nDI 255\n\
                CALC NOT\nCALC NOT, 5\ncalc 8\nWAIT TICKS, 7, -1\nWAIT TICKS, 0, 5\nUF0 1, 2, 3\nuf7 255, 255, -1\n";
    assert_eq!(
        clean(text),
        [
            instruction(14, 255, 2, 255),
            instruction(14, 255, 2, -1),
            instruction(15, 255, 0, 0),
            instruction(30, 0, 255, 0),
            instruction(31, 0, 255, 0),
            instruction(31, 20, 255, 0),
            instruction(25, 255, 0, 0),
            instruction(26, 255, 0, 0),
            instruction(19, 8, 0, 0),
            instruction(19, 8, 0, 5),
            instruction(19, 8, 0, 0),
            instruction(27, 0, 7, -1),
            instruction(27, 0, 0, 5),
            instruction(64, 1, 2, 3),
            instruction(71, 255, 255, -1),
        ]
    );
}

#[test]
fn a_stop_is_appended_unless_the_last_instruction_leaves() {
    for (text, appended) in [
        ("", true),
        ("// nothing\n", true),
        ("MST 0", true),
        ("STOP", false),
        ("L: JA L", false),
        ("RSUB\n\n// end", false),
        ("RETI", false),
        ("L: JC ZE, L", true),
        ("L: CSUB L", true),
        ("JA End\nEnd:\n", false),
    ] {
        let assembly = alone(text);
        assert_eq!(assembly.program.appended_stop, appended, "{text}");
        let origin = assembly.program.origins.last().copied().unwrap();
        assert_eq!(appended, origin.range() == (text.len()..text.len()), "{text}");
        assert_eq!(assembly.program.instructions.len(), assembly.program.origins.len());
    }
}

#[test]
fn labels_may_share_an_address_and_stand_at_the_end() {
    let assembly = alone("A: B:\nC: MST 0\nJC ZE, D\nJA d\nMST 0\nD: E:");
    assert_eq!(render(&assembly), "");
    let labels: Vec<_> = assembly
        .program
        .labels
        .iter()
        .map(|label| (label.name.as_str(), label.address, label.uses))
        .collect();
    assert_eq!(labels, [("A", 0, 0), ("B", 0, 0), ("C", 0, 0), ("D", 4, 2), ("E", 4, 0)]);
    assert_eq!(assembly.program.instructions.len(), 5);
}

#[test]
fn the_module_is_the_callers_or_the_files_or_the_tmcm_1311() {
    let named = "// A program\r\n\r\n//!  Module : TMCM-1640 \r\nMST 0\r\n";
    let name = |assembly: &tmcl_lang::Assembly| (assembly.program.module.name, assembly.module_is_named);
    assert_eq!(name(&alone(named)), ("TMCM-1640", true));
    assert_eq!(name(&alone_for("1311", named)), ("TMCM-1311", true));
    assert_eq!(name(&alone("MST 0\n//! module: tmcm-1640\n")), ("TMCM-1311", false));
    assert_eq!(name(&alone("")), ("TMCM-1311", false));
}

#[test]
fn errors_are_told_in_the_order_of_the_lines() {
    let text = "JA Nowhere\nSAP 6, 0, 300\nFOO\nSAP 1 2\nLoop: MST 1\nLoop:\n";
    assert_eq!(codes(&alone(text)), ["E0105", "E0206", "E0101", "E0002", "E0210", "E0106"]);
}
