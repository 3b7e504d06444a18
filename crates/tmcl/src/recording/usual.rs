//! What is recorded and drawn of the first module when nothing is said.

use virtual_bench::{Bench, ModuleId, ModuleKind};

/// What is recorded of a stepper.
const STEPPER_COLUMNS: [&str; 17] = [
    "actual_position",
    "physical.rotor_turns",
    "encoder_counter",
    "actual_velocity",
    "physical.velocity_rpm",
    "physical.load_nm",
    "physical.torque_nm",
    "physical.load_angle_deg",
    "physical.coil_a_a",
    "physical.coil_b_a",
    "physical.bus_voltage_v",
    "physical.supply_current_a",
    "load_value",
    "microstep_resolution",
    "motor_full_steps",
    "encoder_resolution",
    "closed_loop_initialized",
];

/// What is recorded of a brushless motor.
const BRUSHLESS_COLUMNS: [&str; 18] = [
    "actual_position",
    "physical.rotor_turns",
    "encoder_counter",
    "actual_velocity",
    "ramp_velocity",
    "physical.velocity_rpm",
    "target_current",
    "motor_current",
    "physical.current_q_a",
    "physical.current_d_a",
    "physical.load_nm",
    "physical.torque_nm",
    "physical.bus_voltage_v",
    "physical.supply_current_a",
    "status_flags",
    "encoder_resolution",
    "motor_poles",
    "commutation_mode",
];

/// What is recorded of a stepper that follows pulses.
const STEP_COLUMNS: [&str; 14] = [
    "sensed.step_pulses",
    "physical.rotor_turns",
    "tstep",
    "physical.velocity_rpm",
    "physical.load_nm",
    "physical.torque_nm",
    "physical.load_angle_deg",
    "physical.coil_a_a",
    "physical.coil_b_a",
    "physical.bus_voltage_v",
    "physical.supply_current_a",
    "coolstep_actual_current",
    "load_value",
    "microstep_resolution",
];

/// What is drawn of a stepper that follows pulses.
const STEP_PANELS: [&str; 5] = [
    "Position [turn]: physical.rotor_turns as physical",
    "Velocity [rpm]: physical.velocity_rpm as physical",
    "Load [Nm]: physical.torque_nm as motor, dashed physical.load_nm as load",
    "physical.load_angle_deg as Load angle",
    "Coil currents [A]: physical.coil_a_a as A, physical.coil_b_a as B",
];

/// What is drawn of a stepper.
const STEPPER_PANELS: [&str; 5] = [
    "Position [turn]: physical.rotor_turns as physical, dashed actual_position as commanded",
    "Velocity [rpm]: physical.velocity_rpm as physical, dashed actual_velocity as commanded",
    "Load [Nm]: physical.torque_nm as motor, dashed physical.load_nm as load",
    "physical.load_angle_deg as Load angle",
    "Coil currents [A]: physical.coil_a_a as A, physical.coil_b_a as B",
];

/// What is drawn of a brushless motor.
const BRUSHLESS_PANELS: [&str; 5] = [
    "Position [turn]: physical.rotor_turns as physical, dashed actual_position as measured",
    "Velocity [rpm]: physical.velocity_rpm as physical, actual_velocity as measured, dashed ramp_velocity as ramp",
    "Current [A]: physical.current_q_a as physical, motor_current as measured, dashed target_current as target",
    "Load [Nm]: physical.torque_nm as motor, dashed physical.load_nm as load",
    "physical.bus_voltage_v as Bus voltage",
];

/// The columns of a trace.
pub(super) fn columns(bench: &Bench) -> &'static [&'static str] {
    match kind(bench) {
        ModuleKind::Tmcm1311 => &STEPPER_COLUMNS,
        ModuleKind::Tmcm1640 => &BRUSHLESS_COLUMNS,
        ModuleKind::Tmcm1076 => &STEP_COLUMNS,
    }
}

/// The panels of a plot.
pub(super) fn panels(bench: &Bench) -> &'static [&'static str] {
    match kind(bench) {
        ModuleKind::Tmcm1311 => &STEPPER_PANELS,
        ModuleKind::Tmcm1640 => &BRUSHLESS_PANELS,
        ModuleKind::Tmcm1076 => &STEP_PANELS,
    }
}

/// What the first module is.
fn kind(bench: &Bench) -> ModuleKind {
    let spec = bench.spec(ModuleId(0));
    spec.and_then(|spec| ModuleKind::try_from(spec).ok()).unwrap_or(ModuleKind::Tmcm1311)
}
