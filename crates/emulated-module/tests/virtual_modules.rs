//! Sessions against virtual modules: the replies that are recorded, at the same ticks. With `UPDATE_SESSIONS=1` they are
//! recorded anew.
#![allow(clippy::disallowed_methods, clippy::unwrap_used, reason = "tests that write files")]

mod common;

use emulated_module::{VirtualTarget, play};
use virtual_bench::ModuleKind;

fn answers_as_recorded(module: &str, kind: ModuleKind) {
    for (name, path, recorded) in common::sessions(module) {
        let Ok(played) = play(&recorded, &mut VirtualTarget::new(kind));
        if std::env::var_os("UPDATE_SESSIONS").is_some() {
            std::fs::write(&path, played.to_string()).unwrap();
        } else {
            assert_eq!(played.to_string(), recorded.to_string(), "{name}");
        }
    }
}

#[test]
fn a_virtual_tmcm_1311_answers_as_recorded() {
    answers_as_recorded("tmcm-1311", ModuleKind::Tmcm1311);
}

#[test]
fn a_virtual_tmcm_1640_answers_as_recorded() {
    answers_as_recorded("tmcm-1640", ModuleKind::Tmcm1640);
}
