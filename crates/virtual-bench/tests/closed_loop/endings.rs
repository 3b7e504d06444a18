//! What ends closed loop, or a search in it, and what it survives: commands, the supply, faults (TMCM-1311 §8.1, §9;
//! decisions 5.4, 5.9, 5.12); against the shaft.

use crate::common::TURN;
use crate::common::closed_loop::{Axis, MOTOR, amplitude_a, bench, rms_a, try_initialize};
use crate::common::program::{RETI, count, ei, ja, jc, kind, op, program, sgp, vect, wait};
use tmcl_tables::tmcm_1311::AxisParameter as Ap;
use tmcl_tables::{Command, Status};

const UNREGULATED: (Ap, i32) = (Ap::CurrentScaleEnable, 0);

/// More than the motor has.
const JAM_NM: f64 = 3.0;

const SAP: Command = Command::SetAxisParameter;

mod searches {
    use super::*;

    const START: u8 = 0;
    const ABORT: u8 = 1;
    const STATUS: u8 = 2;

    fn rfs(axis: &mut Axis, kind: u8) -> i32 {
        axis.ok(Command::ReferenceSearch, kind, 0, 0)
    }

    /// On its way to the left stop switch at a turn a second.
    #[track_caller]
    fn searching() -> Axis {
        let file = format!("{}[module.switches]\nleft = {{ at_turns = -1.5 }}\n", bench(MOTOR, 40_000, ""));
        let settings = [UNREGULATED, (Ap::MaxVelocity, TURN), (Ap::MaxAcceleration, 4 * TURN)];
        let mut axis = Axis::on(&file, 40_000, &settings);
        rfs(&mut axis, START);
        axis.run_ms(500);
        let rpm = axis.mean(2000, |axis| axis.physical().velocity_rpm);
        assert!((rpm + 60.0).abs() < 3.0, "{rpm} rpm");
        assert_eq!(rfs(&mut axis, STATUS), 1);
        axis
    }

    /// RFS STOP and MST slow down with the ramp; whatever else moves the motor takes over.
    #[test]
    fn stop_and_every_motion_command_abort_it() {
        let commands: [(Command, u8, i32, [i32; 3]); 8] = [
            (Command::ReferenceSearch, ABORT, 0, [1, 0, 0]),
            (Command::MotorStop, 0, 0, [1, 0, 0]),
            (Command::MoveToPosition, 0, 7000, [0, 0, 7000]),
            (Command::RotateRight, 0, 10_000, [1, 10_000, 0]),
            (Command::RotateLeft, 0, 10_000, [1, -10_000, 0]),
            (SAP, 0, -500, [0, 0, -500]),
            (SAP, 2, 5000, [1, 5000, 0]),
            (SAP, 128, 1, [1, 0, 0]),
        ];
        for (command, kind, value, [ramp_mode, velocity, target]) in commands {
            let mut axis = searching();
            let from = axis.turns();
            axis.ok(command, kind, 0, value);
            assert_eq!(rfs(&mut axis, STATUS), 0, "{command:?} {kind}");
            // It slows down at 4 turns/s², an eighth of a turn to a stop: no jerk, and not any later.
            axis.run_ms(100);
            let rpm = axis.mean(500, |axis| axis.physical().velocity_rpm);
            if velocity >= 0 {
                assert!((rpm + 60.0 - 27.0).abs() < 8.0, "{command:?} {kind}: {rpm} rpm after 112 ms");
            }
            let (lowest, _) = axis.range(40_000, |axis| axis.turns());
            if velocity >= 0 {
                assert!(
                    (from - lowest - 0.125).abs() < 0.03,
                    "{command:?} {kind}: on to {lowest} from {from}"
                );
            }
            assert_eq!(axis.gap(Ap::RampMode), ramp_mode, "{command:?} {kind}");
            if ramp_mode == 1 {
                let rpm = axis.mean(20_000, |axis| axis.physical().velocity_rpm);
                let commanded = f64::from(velocity) / f64::from(TURN) * 60.0;
                assert!((rpm - commanded).abs() < 0.5, "{command:?} {kind}: {rpm} rpm, not {commanded}");
            } else {
                axis.reach();
                axis.assert_at(target);
            }
            axis.assert_agrees();
        }
    }

    /// SAP 14 and the mode of it do, too.
    #[test]
    fn torque_takes_over() {
        for parameter in [Ap::TorqueTargetCurrent, Ap::RampMode] {
            let mut axis = searching();
            axis.sap(parameter, if parameter == Ap::RampMode { 2 } else { 500 });
            assert_eq!((rfs(&mut axis, STATUS), axis.gap(Ap::RampMode)), (0, 2));
            axis.run_ms(1000);
            let rpm = axis.physical().velocity_rpm;
            assert!(parameter == Ap::RampMode || rpm > 60.0, "{rpm} rpm");
            axis.assert_agrees();
        }
    }

    /// It is not left, nor an encoder looked for, in the middle of a search.
    #[test]
    fn what_needs_rest_does_not_disturb_it() {
        let mut axis = searching();
        for (parameter, status) in [(129, Status::InvalidValue), (254, Status::InvalidValue)] {
            let value = i32::from(parameter == 254);
            assert_eq!(axis.status(SAP, parameter, 0, value), status, "SAP {parameter}");
        }
        assert_eq!(axis.status(SAP, 132, 0, 1), Status::NotAvailable);
        axis.sap(Ap::ClosedLoopMode, 1);
        while rfs(&mut axis, STATUS) != 0 {
            axis.run_ms(1);
        }
        axis.run_ms(300);
        let zero = axis.turns() - f64::from(axis.gap(Ap::ActualPosition)) / 40_000.0;
        assert!((zero + 1.5).abs() < 4.0 / 40_000.0, "0 is at {zero} turns");
    }

    /// A rotor that is jammed meanwhile ends up where the switch is.
    #[test]
    fn a_jam_does_not_spoil_it() {
        let mut axis = searching();
        for ms in [300, 700, 100] {
            axis.set("load.friction_nm", JAM_NM);
            axis.run_ms(ms);
            axis.set("load.friction_nm", 0.01);
            axis.run_ms(300);
        }
        while rfs(&mut axis, STATUS) != 0 {
            axis.run_ms(1);
        }
        axis.run_ms(300);
        let zero = axis.turns() - f64::from(axis.gap(Ap::ActualPosition)) / 40_000.0;
        assert!((zero + 1.5).abs() < 4.0 / 40_000.0, "0 is at {zero} turns");
    }
}

/// A whole electrical period off at most: rotor and field are where they were, or a load angle apart.
const PERIOD_TURNS: f64 = 4.0 / 200.0;

/// SAP 129, 0: moves go on in µsteps of AP 140, from where the shaft is, with a weight on it too.
#[test]
fn open_loop_goes_on_where_closed_loop_was_left() {
    for (weight_nm, resolution) in [(0.0, 8), (0.0, 4), (0.15, 8), (-0.15, 8)] {
        let mut axis = Axis::new(&[UNREGULATED, (Ap::MicrostepResolution, resolution)]);
        axis.land(123_456);
        axis.set("load.torque_nm", weight_nm);
        axis.run_ms(300);
        let from = axis.turns();
        axis.sap(Ap::ClosedLoopMode, 0);
        axis.run_ms(500);
        let what = format!("{weight_nm} Nm, AP 140 = {resolution}");
        assert_eq!((axis.gap(Ap::ClosedLoopMode), axis.gap(Ap::ClosedLoopInitialized)), (0, 0), "{what}");
        assert!((axis.turns() - from).abs() < PERIOD_TURNS / 4.0, "{what}: {} turns", axis.turns() - from);
        let turn = TURN >> (8 - resolution);
        let position = axis.gap(Ap::ActualPosition);
        assert_eq!((axis.gap(Ap::TargetPosition), axis.gap(Ap::RampMode)), (position, 0), "{what}");
        let off = f64::from(position) / f64::from(turn) - axis.shaft() / axis.counts;
        assert!(off.abs() < PERIOD_TURNS / 4.0, "{what}: AP 1 = {position} is {off} turns off");
        axis.set_all(&[(Ap::MaxVelocity, turn), (Ap::MaxAcceleration, 4 * turn)]);
        let from = axis.turns();
        axis.go(position + turn);
        axis.arrive();
        axis.run_ms(500);
        let turned = axis.turns() - from;
        assert!((turned - 1.0).abs() < PERIOD_TURNS / 20.0, "{what}: {turned} turns, not one");
        assert_eq!(axis.gap(Ap::ActualPosition), position + turn);
    }
}

/// Not while anything moves.
#[test]
fn it_is_not_left_in_motion() {
    let mut axis = Axis::new(&[UNREGULATED]);
    axis.go(100_000);
    for ms in [0, 300] {
        axis.run_ms(ms);
        assert_eq!(axis.status(SAP, 129, 0, 0), Status::InvalidValue, "after {ms} ms");
    }
    axis.reach();
    axis.assert_at(100_000);
}

mod supply {
    use super::*;

    /// Moving or at rest, in a search or by torque: after power-on there is an open loop, that can be closed again.
    #[test]
    fn power_off_and_on_leaves_an_open_loop() {
        for state in 0..4 {
            let mut axis = Axis::new(&[]);
            match state {
                0 => axis.go(400_000),
                1 => axis.rotate(-TURN),
                2 => axis.sap(Ap::TorqueTargetCurrent, 400),
                _ => {}
            }
            axis.run_ms(400);
            axis.set("power", "off");
            axis.run_ms(2000);
            assert!(amplitude_a(&axis) < 0.001, "{} A", amplitude_a(&axis));
            axis.set("power", "on");
            axis.run_ms(500);
            for parameter in [
                Ap::ClosedLoopMode,
                Ap::ClosedLoopInitialized,
                Ap::EncoderInitialization,
                Ap::ActualPosition,
                Ap::TargetPosition,
                Ap::RampMode,
            ] {
                assert_eq!(axis.gap(parameter), 0, "{parameter:?}, state {state}");
            }
            assert_eq!(axis.gap(Ap::PositionReached), 1);
            let from = axis.turns();
            axis.go(TURN);
            axis.arrive();
            axis.run_ms(300);
            assert!((axis.turns() - from - 1.0).abs() < PERIOD_TURNS, "{} turns", axis.turns() - from);
            assert!(try_initialize(&mut axis).is_some());
            axis.zero_turns = axis.turns() - f64::from(axis.gap(Ap::ActualPosition)) / axis.counts;
            axis.land(0);
        }
    }

    /// AP 129 is not one of the stored.
    #[test]
    fn closed_loop_is_not_stored() {
        let mut axis = Axis::new(&[]);
        let status = axis.status(Command::StoreAxisParameter, 129, 0, 0);
        axis.power_cycle();
        axis.run_ms(2000);
        assert_eq!((axis.gap(Ap::ClosedLoopMode), axis.gap(Ap::ClosedLoopInitialized)), (0, 0), "{status:?}");
    }

    /// No voltage, too little and too much: bits of AP 18, and the move is finished when there is enough again.
    #[test]
    fn a_supply_that_fails_loses_no_position() {
        for (volts, bit) in [(0.0, 9), (3.0, 9), (9.0, 9), (60.0, 10)] {
            let mut axis = Axis::new(&[UNREGULATED, (Ap::MaxVelocity, TURN)]);
            axis.go(120_000);
            axis.run_ms(700);
            axis.set("supply.voltage_v", volts);
            axis.run_ms(1000);
            assert!(axis.status_bit(bit), "{volts} V: AP 18 bit {bit}");
            axis.assert_agrees();
            axis.set("supply.voltage_v", 48.0);
            axis.reach();
            axis.run_ms(200);
            assert!(!axis.status_bit(bit), "{volts} V: AP 18 bit {bit}");
            axis.assert_at(120_000);
        }
    }
}

/// Whatever breaks in mid-move: the firmware goes on, the current stays within AP 6, and a stop and another try are possible.
#[test]
fn it_survives_what_breaks() {
    let faults = [
        ("fault.encoder_line", "a", "none"),
        ("fault.encoder_line", "b", "none"),
        ("fault.coil_open", "a", "none"),
        ("fault.coil_short", "b", "none"),
        ("fault.switch_left", "open", "none"),
        ("fault.switch_right", "open", "none"),
        ("fault.board_temperature_c", "120", "none"),
        ("supply.voltage_v", "0", "48"),
    ];
    let switches = "[module.switches]\nleft = { at_turns = -500 }\nright = { at_turns = 500 }\n";
    let file = format!("{}{switches}", bench(MOTOR, 40_000, ""));
    for (fault, broken, repaired) in faults {
        for state in 0..3 {
            let mut axis = Axis::on(&file, 40_000, &[UNREGULATED, (Ap::MaxCurrent, 128)]);
            match state {
                0 => axis.go(400_000),
                1 => axis.rotate(-TURN),
                _ => axis.sap(Ap::TorqueTargetCurrent, 400),
            }
            axis.run_ms(400);
            axis.set(fault, broken);
            let (_, largest) = axis.range(20_000, |axis| amplitude_a(axis));
            let allowed = 1.05 * rms_a(128) * std::f64::consts::SQRT_2;
            if fault != "fault.coil_short" {
                assert!(largest < allowed, "{fault}, state {state}: {largest} A, not {allowed} A at most");
            }
            axis.set(fault, repaired);
            if fault == "fault.coil_short" {
                // What the driver remembers (AP 167).
                axis.sap(Ap::ChopperOffTime, 0);
                axis.run_ms(1);
                axis.sap(Ap::ChopperOffTime, 5);
            }
            axis.ok(Command::MotorStop, 0, 0, 0);
            axis.run_ms(4000);
            let status = axis.status(SAP, 129, 0, 0);
            assert_eq!(status, Status::Ok, "{fault}, state {state}; {}", axis.figures());
            axis.run_ms(1000);
            assert!(try_initialize(&mut axis).is_some(), "{fault}, state {state}");
            axis.zero_turns = axis.turns() - f64::from(axis.gap(Ap::ActualPosition)) / axis.counts;
            axis.land(0);
        }
    }
}

/// A deviation in closed loop sets the flag that JC EDV asks for, CLE EDV clears it, and interrupt 21 comes once.
#[test]
fn a_program_hears_of_a_deviation() {
    for limit in [2000, -2000] {
        let mut axis = Axis::new(&[UNREGULATED, (Ap::MaxEncoderDeviation, limit)]);
        let routine = 5;
        axis.download(&program(&[
            &[vect(21, routine), ei(21), ei(255), wait(kind::TICKS, 100), ja(3)],
            &count(0),
            &[
                jc(kind::EDV, 10),
                RETI,
                sgp(10, 2, 1), // 10
                op(Command::ClearErrorFlags, 3, 0, 0),
                jc(kind::EDV, 14),
                sgp(11, 2, 1),
                RETI, // 14
            ],
        ]));
        axis.run_from(0);
        axis.go(400_000);
        axis.run_ms(700);
        let variables = |axis: &mut Axis| [0, 10, 11].map(|variable| axis.variable(variable));
        assert_eq!(variables(&mut axis), [0; 3], "{}", axis.figures());
        axis.set("load.friction_nm", JAM_NM);
        axis.run_ms(200);
        assert_eq!(axis.gap(Ap::EncoderDeviationFlag), 1);
        assert_eq!(variables(&mut axis), [1; 3], "AP 212 = {limit}");
        axis.set("load.friction_nm", 0.01);
        axis.run_ms(500);
        assert_eq!(variables(&mut axis), [1; 3], "one stop, one interrupt");
        assert_eq!(amplitude_a(&axis) < 0.01, limit < 0, "{} A", amplitude_a(&axis));
    }
}
