//! stallGuard2 and coolStep on a motor that follows its steps.

use super::*;

/// 5 turns a second with stallGuard2 and, with a SEMIN, coolStep.
fn running(coolconf: CoolConf, load_nm: f64) -> Rig {
    let mut rig = Rig::new(factory());
    rig.registers.tcoolthrs = 200;
    rig.registers.coolconf = CoolConf { sfilt: true, ..coolconf };
    rig.wait(0.1);
    rig.ramp(2 * 8000, 100.0, 16_000.0);
    rig.load(load_nm);
    rig.run(16_000.0, 1.0);
    rig
}

impl Rig {
    /// Lets the load come in a fifth of a second.
    fn load(&mut self, load_nm: f64) {
        for step in 1..=20 {
            self.load_nm = load_nm / 20.0 * f64::from(step);
            self.run(16_000.0, 0.01);
        }
    }
}

#[test]
fn stallguard_reads_lower_with_more_load() {
    let readings =
        [0.0, -0.2, -0.4, -0.6].map(|load_nm| running(CoolConf::default(), load_nm).chip.status().sg_result);
    assert!(readings.is_sorted_by(|one, next| *one > *next + 40), "{readings:?}");
    assert!(readings[0] > 350, "{readings:?}");
}

#[test]
fn there_is_no_reading_slower_than_tcoolthrs_with_stealthchop_or_at_rest() {
    let mut rig = running(CoolConf::default(), 0.0);
    assert!(rig.chip.status().sg_result > 0);
    rig.registers.tcoolthrs = 40;
    rig.run(16_000.0, 0.1);
    let status = rig.chip.status();
    assert_eq!((status.sg_result, status.stallguard), (0, false));
    let mut rig = running(CoolConf::default(), 0.0);
    rig.wait(0.2);
    assert_eq!(rig.chip.status().sg_result, 0);
}

#[test]
fn a_stall_reads_zero() {
    let mut rig = running(CoolConf::default(), 0.0);
    rig.load_nm = -2.0;
    rig.run(16_000.0, 0.5);
    let status = rig.chip.status();
    assert!(status.stallguard, "{}", status.sg_result);
    assert_eq!(status.bits() >> 24 & 1, 1);
}

/// SEMIN 4, SEMAX 2: 128 to 223.
const COOLSTEP: CoolConf =
    CoolConf { semin: 4, seup: 2, semax: 2, sedn: 2, seimin: true, sgt: 0, sfilt: true };

#[test]
fn coolstep_saves_current_and_holds_the_torque_when_a_load_comes() {
    let mut rig = running(COOLSTEP, 0.0);
    let cs = rig.chip.status().cs_actual;
    assert!(cs < 14, "{cs} without load");
    let copper_pj = |rig: &mut Rig| {
        let before = rig.motor.energy.copper_pj;
        rig.run(16_000.0, 0.5);
        rig.motor.energy.copper_pj - before
    };
    let mut without = running(CoolConf::default(), 0.0);
    let [with, full] = [copper_pj(&mut rig), copper_pj(&mut without)];
    assert!(with * 3 < full, "{with} pJ against {full} pJ in the windings");
    // More than the reduced current could hold.
    let from = rig.motor.turns();
    rig.load(-0.5);
    rig.run(16_000.0, 0.5);
    let status = rig.chip.status();
    assert!((rig.motor.turns() - from - 3.5).abs() < 0.01, "no step was lost: {}", rig.motor.turns() - from);
    assert!(status.cs_actual > 16 && status.sg_result > 100, "{status:?}");
    rig.load_nm = 0.0;
    rig.run(16_000.0, 1.0);
    assert!(rig.chip.status().cs_actual < 14, "and back");
}

#[test]
fn coolstep_works_between_tcoolthrs_and_thigh_only() {
    let mut rig = running(COOLSTEP, 0.0);
    assert!(rig.chip.status().cs_actual < 24);
    rig.registers.thigh = 60;
    rig.run(16_000.0, 0.1);
    assert_eq!(rig.chip.status().cs_actual, 24, "faster than THIGH");
    rig.registers.thigh = 0;
    rig.run(16_000.0, 0.5);
    assert!(rig.chip.status().cs_actual < 24);
    rig.registers.tcoolthrs = 40;
    rig.run(16_000.0, 0.1);
    assert_eq!(rig.chip.status().cs_actual, 24, "slower than TCOOLTHRS");
}
