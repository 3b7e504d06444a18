//! The timer interrupt of §5.6.5, in both of its forms.

use super::host::Host;
use super::text::listing;

/// The interrupt toggles OUT_0 every 1000 ms while the main program toggles OUT_3 every 500 ms, and neither disturbs the
/// other by more than the few instructions that it executes.
#[test]
fn the_timer_toggles_one_output_while_the_program_toggles_another() {
    for name in ["tmcm_1311_5_6_5", "tmcm_1311_5_6_5_names"] {
        let program = listing(name);
        let toggled = |output: &str| Host::running(&program).changes(output, 20_500);
        let by_timer = toggled("output.0");
        assert_eq!(by_timer.len(), 20, "{name}: {by_timer:?}");
        assert_toggles(&by_timer, 1000.0, 1000.0, 1.0);
        let by_waiting = toggled("output.3");
        assert_eq!(by_waiting.len(), 41, "{name}: {by_waiting:?}");
        // A tick of WAIT has 10 ms.
        assert_toggles(&by_waiting, 0.0, 500.0, 10.0);
    }
}

/// High first, at `first_ms`, and then every `period_ms`.
#[track_caller]
fn assert_toggles(changes: &[(f64, f64)], first_ms: f64, period_ms: f64, tolerance_ms: f64) {
    for (index, (time_ms, level)) in changes.iter().enumerate() {
        assert_eq!(*level, f64::from(u8::from(index % 2 == 0)));
        let expected_ms = first_ms + index as f64 * period_ms;
        assert!((time_ms - expected_ms).abs() < tolerance_ms, "{time_ms} ms, not {expected_ms} ms");
    }
}

/// What a host sees of it: the outputs as GIO reads them, and a program that runs on.
#[test]
fn a_host_reads_the_outputs_meanwhile() {
    let mut host = Host::running(&listing("tmcm_1311_5_6_5"));
    for (time_ms, out_0, out_3) in
        [(250, 0, 1), (750, 0, 0), (1250, 1, 1), (1750, 1, 0), (2250, 0, 1), (3250, 1, 1)]
    {
        host.run_to_ms(time_ms);
        assert_eq!((host.gio(2, 0), host.gio(2, 3)), (out_0, out_3), "at {time_ms} ms");
    }
    assert!(host.runs());
    host.assert_nothing_refused();
}
