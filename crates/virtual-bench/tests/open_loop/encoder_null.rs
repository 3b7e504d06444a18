//! The encoder's null channel (TMCM-1311 §6, AP 198, 201, 209; decisions 2a.7), against the index as it is mounted.

use crate::common::{Module, TURN};
use tmcl_tables::Command;
use tmcl_tables::tmcm_1311::AxisParameter as Ap;

const COUNTS: f64 = 40_000.0;

/// Where the index is, in turns.
const INDEX: f64 = 0.25;

/// What the encoder goes on in two control periods, and a count at either end.
const SLACK: f64 = 6.0;

fn module(mode: i32) -> Module {
    let mut module = Module::on("[[module]]\nkind = \"tmcm-1311\"\n[module.encoder]\noffset_turns = 0.25\n");
    module.run_ms(200);
    for (parameter, value) in
        [(Ap::MaxVelocity, TURN), (Ap::MaxAcceleration, 4 * TURN), (Ap::EncoderMode, mode)]
    {
        module.sap(parameter, value);
    }
    module
}

fn move_to(module: &mut Module, position: i32) {
    module.ok(Command::MoveToPosition, 0, 0, position);
    module.arrive();
    module.run_ms(300);
}

/// AP 209 counts from an index that is so many turns from the start; from power-on where it is None.
#[track_caller]
fn assert_counts_from(module: &mut Module, index: Option<f64>) {
    let expected = (module.turns() - index.unwrap_or(0.0)) * COUNTS;
    let counter = f64::from(module.gap(Ap::EncoderCounter));
    assert!((counter - expected).abs() < SLACK, "{counter}, not {expected}");
    assert!(
        (module.read("sensed.encoder_counts") - module.turns() * COUNTS).abs() < 2.0,
        "the raw count knows no index"
    );
}

#[test]
fn the_next_null_event_clears_the_counter_once() {
    for mode in [4, 4 | 16] {
        let mut module = module(mode);
        assert_eq!(module.gap(Ap::ClearOnNull), 1);
        move_to(&mut module, TURN / 5);
        assert_counts_from(&mut module, None);
        assert_eq!(module.gap(Ap::EncoderMode), mode, "not yet");
        move_to(&mut module, TURN / 2);
        assert_counts_from(&mut module, Some(INDEX));
        assert_eq!((module.gap(Ap::EncoderMode), module.gap(Ap::ClearOnNull)), (mode & !4, 0));
        move_to(&mut module, 2 * TURN);
        assert_counts_from(&mut module, Some(INDEX));
        assert_eq!(module.gap(Ap::ActualPosition), 2 * TURN, "nothing else moves");
    }
}

#[test]
fn every_null_event_clears_it_in_both_directions() {
    for mode in [8, 8 | 16] {
        let mut module = module(mode);
        move_to(&mut module, TURN * 3 / 2);
        assert_counts_from(&mut module, Some(1.0 + INDEX));
        move_to(&mut module, -TURN / 2);
        assert_counts_from(&mut module, Some(INDEX - 0.0));
        move_to(&mut module, -TURN);
        assert_counts_from(&mut module, Some(INDEX - 1.0));
        assert_eq!(module.gap(Ap::EncoderMode), mode);
    }
}

#[test]
fn both_bits_together_clear_every_time_and_the_one_goes() {
    let mut module = module(4 | 8);
    move_to(&mut module, TURN * 3 / 2);
    assert_counts_from(&mut module, Some(1.0 + INDEX));
    assert_eq!((module.gap(Ap::EncoderMode), module.gap(Ap::ClearOnNull)), (8, 0));
}

#[test]
fn without_a_bit_nothing_is_cleared() {
    for mode in [0, 16] {
        let mut module = module(mode);
        move_to(&mut module, 3 * TURN);
        assert_counts_from(&mut module, None);
        assert_eq!(module.gap(Ap::EncoderMode), mode);
    }
}

#[test]
fn clear_on_null_sets_and_deletes_its_bit() {
    let mut module = module(8 | 16);
    module.sap(Ap::ClearOnNull, 1);
    assert_eq!(module.gap(Ap::EncoderMode), 28);
    module.sap(Ap::ClearOnNull, 0);
    assert_eq!(module.gap(Ap::EncoderMode), 24);
    module.sap(Ap::EncoderMode, 4);
    assert_eq!(module.gap(Ap::ClearOnNull), 1);
}

#[test]
fn a_dead_index_leaves_the_bit_waiting() {
    let mut module = module(4);
    module.set("fault.encoder_line", "index");
    move_to(&mut module, TURN);
    assert_counts_from(&mut module, None);
    module.set("fault.encoder_line", "none");
    assert_eq!(module.gap(Ap::ClearOnNull), 1);
    move_to(&mut module, 2 * TURN);
    assert_counts_from(&mut module, Some(1.0 + INDEX));
}

/// AP 201 is stored, AP 198 is not: what was stored waits for the index again.
#[test]
fn a_stored_bit_waits_again_after_a_power_cycle() {
    let mut module = module(4);
    module.ok(Command::StoreAxisParameter, Ap::EncoderMode.number(), 0, 0);
    move_to(&mut module, TURN / 2);
    assert_eq!(module.gap(Ap::ClearOnNull), 0);
    module.power_cycle();
    assert_eq!((module.gap(Ap::EncoderMode), module.gap(Ap::ClearOnNull)), (4, 1));
}
