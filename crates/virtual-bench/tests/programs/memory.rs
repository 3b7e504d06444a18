//! Programs in the module's memory: how they get there, who may see them, how they are started, stopped and stepped
//! (TMCM-1311 §4.3, §10.1, §11.6; decisions 1.6 to 1.8, 3.1, 3.10, 3.12).

use crate::common::program::*;
use crate::common::{Module, VARIABLES};
use tmcl_tables::tmcm_1311::AxisParameter as Ap;
use tmcl_tables::{Command, GlobalParameter as Gp, Status};
use tmcl_wire::{Request, serial};
use virtual_bench::{ModuleId, PortId};

const STOPPED: i32 = 0;
const RUNNING: i32 = 1;
const STEPPING: i32 = 2;
const RESET: i32 = 3;

/// Sets user variable 7 to 77.
const MARK: [Request; 2] = [sgp(7, VARIABLES, 77), STOP];

fn marked(module: &mut Module) -> bool {
    module.variable(7) == 77
}

/// Seven bytes that are all different, and nothing a module would execute.
fn odd(number: u8) -> Request {
    Request {
        command: 200 + number % 50,
        kind: number,
        motor: number ^ 0x55,
        value: i32::from(number) * -0x0102_0304,
    }
}

#[test]
fn what_is_downloaded_can_be_read_back() {
    let mut module = Module::new();
    assert_eq!(module.status_of_program(), (STOPPED, 0));
    let instructions: Vec<_> = (0..40).map(odd).collect();
    module.download(&instructions);
    for (address, instruction) in (0..).zip(&instructions) {
        assert_eq!(module.read_instruction(address), *instruction);
    }
    for erased in [40, 41, 2047] {
        assert_eq!(module.read_instruction(erased), STOP, "erased memory reads as STOP");
    }
    assert_eq!(module.status_of_program(), (STOPPED, 0));
}

#[test]
fn a_download_may_begin_anywhere_and_leaves_the_rest() {
    let mut module = Module::new();
    module.download_at(5, &[odd(1), odd(2), odd(3)]);
    module.download_at(6, &[odd(9)]);
    let read: Vec<_> = (4..9).map(|address| module.read_instruction(address)).collect();
    assert_eq!(read, [STOP, odd(1), odd(9), odd(3), STOP]);
}

/// Decisions 1.6: 128 to 139 still execute, everything else is stored, be it known, unknown, or an end marker.
#[test]
fn while_downloading_only_128_to_139_execute() {
    let mut module = Module::new();
    module.ok(Command::DownloadStart, 0, 0, 10);
    assert_eq!(module.ggp_while_downloading(Gp::DownloadMode), 1);
    let stored = [
        sap(4, 777),
        op(Command::SetGlobalParameter, 66, 0, 9),
        op(Command::SetGlobalParameter, 81, 0, 99_999),
        op(Command::SoftwareReset, 0, 0, 1234),
        Request { command: 0, ..Request::default() },
        Request { command: 127, kind: 1, motor: 2, value: 3 },
        Request { command: 140, kind: 1, motor: 2, value: 3 },
        mvp_abs(5000),
    ];
    for instruction in stored {
        module.load(instruction);
        module.ok(Command::ApplicationStop, 0, 0, 0);
        assert_eq!(module.ok(Command::ApplicationStatus, 0, 0, 0), 0);
        assert_eq!(module.ok(Command::FirmwareVersion, 1, 0, 0), 0x051F_010B);
    }
    // What comes broken is not stored.
    let mut broken = serial::encode_request(1, sap(4, 1));
    broken[8] ^= 1;
    assert_eq!(module.exchange(&broken)[2], Status::WrongChecksum.number());
    module.load(STOP);
    module.ok(Command::DownloadEnd, 0, 0, 0);
    assert_eq!(module.ggp(Gp::DownloadMode), 0);
    for (address, instruction) in (10..).zip(stored.iter().chain(&[STOP])) {
        assert_eq!(module.read_instruction(address), *instruction);
    }
    assert_eq!(
        (module.gap(Ap::MaxVelocity), module.gap(Ap::TargetPosition)),
        (51_200, 0),
        "none was executed"
    );
}

#[test]
fn there_is_room_for_2048_instructions() {
    let mut module = Module::new();
    module.ok(Command::DownloadStart, 0, 0, 0);
    for number in 0..2048 {
        module.load(sgp((number % 200) as u8, VARIABLES, number));
    }
    for _ in 0..2 {
        assert_eq!(module.request(odd(1)).status, Status::InvalidValue);
    }
    module.ok(Command::DownloadEnd, 0, 0, 0);
    assert_eq!(module.read_instruction(0), sgp(0, VARIABLES, 0));
    assert_eq!(module.read_instruction(2047), sgp(47, VARIABLES, 2047));
    module.run_from(0);
    module.run_ticks(2040);
    assert_eq!(module.status_of_program(), (RUNNING, 2040), "one instruction each 50 µs");
    module.run_ticks(20);
    let (mode, counter) = module.status_of_program();
    assert_eq!(mode, STOPPED, "running past the end stops");
    assert!((0..=2047).contains(&counter), "{counter} is no address");
    assert_eq!(module.variable(47), 2047);
}

#[test]
fn other_ports_talk_as_ever_while_one_downloads() {
    let mut module = Module::new();
    module.ok(Command::DownloadStart, 0, 0, 0);
    let downloading = module.port;
    for (number, port) in (1..).zip(PortId::ALL.into_iter().filter(|port| *port != downloading)) {
        module.load(odd(number));
        module.port = port;
        module.sap(Ap::MaxVelocity, 1000 + i32::from(number));
        assert_eq!(module.gap(Ap::MaxVelocity), 1000 + i32::from(number));
        // Nor can they end it, or begin another.
        module.ok(Command::DownloadEnd, 0, 0, 0);
        assert_eq!(module.status(Command::DownloadStart, 0, 0, 5), Status::NotAvailable);
        assert_eq!(module.ggp(Gp::DownloadMode), 1);
        module.port = downloading;
    }
    module.load(odd(9));
    module.ok(Command::DownloadEnd, 0, 0, 0);
    let read: Vec<_> = (0..5).map(|address| module.read_instruction(address)).collect();
    assert_eq!(read, [odd(1), odd(2), odd(3), odd(9), STOP]);
}

#[test]
fn a_client_that_goes_away_ends_its_download() {
    let mut module = Module::new();
    module.ok(Command::DownloadStart, 0, 0, 0);
    module.load(odd(1));
    // Somebody else going away ends nothing.
    module.bench.disconnect(ModuleId(0), PortId::ALL[2]);
    module.load(odd(2));
    module.bench.disconnect(ModuleId(0), module.port);
    assert_eq!(module.ggp(Gp::DownloadMode), 0);
    assert_eq!(module.read_instruction(1), odd(2));
}

#[test]
fn a_program_survives_a_power_cycle_and_a_download_does_not() {
    for restart in [
        |module: &mut Module| module.power_cycle(),
        |module: &mut Module| {
            // While downloading it would be stored, so another port has to say it.
            module.port = PortId::ALL[3];
            module.ok(Command::SoftwareReset, 0, 0, 1234);
            module.port = PortId::ALL[0];
        },
    ] {
        let mut module = Module::with_program(&[odd(1), odd(2)]);
        module.ok(Command::DownloadStart, 0, 0, 2);
        module.load(odd(3));
        restart(&mut module);
        assert_eq!(module.ggp(Gp::DownloadMode), 0);
        let read: Vec<_> = (0..4).map(|address| module.read_instruction(address)).collect();
        assert_eq!(read, [odd(1), odd(2), odd(3), STOP]);
        assert_eq!(module.status_of_program(), (STOPPED, 0));
    }
}

#[test]
fn auto_start_runs_from_0_after_power_on() {
    for auto_start in [0, 1] {
        for restart in [
            |module: &mut Module| module.power_cycle(),
            |module: &mut Module| {
                module.ok(Command::SoftwareReset, 0, 0, 1234);
            },
        ] {
            let mut module = Module::with_program(&MARK);
            module.sgp(Gp::AutoStart, auto_start);
            module.run_ticks(10);
            assert!(!marked(&mut module), "not before the next power-on");
            restart(&mut module);
            module.run_ticks(10);
            assert_eq!(marked(&mut module), auto_start == 1);
            assert_eq!(module.status_of_program(), (STOPPED, auto_start));
        }
    }
}

/// Decisions 1.6: type 0 from where it stands, type 1 from an address.
#[test]
fn run_stop_and_run_on() {
    let mut module = Module::with_program(&program(&[&count(7), &[ja(0)]]));
    module.ok(Command::ApplicationRun, 0, 0, 99);
    module.run_ticks(402);
    assert_eq!((module.status_of_program(), module.variable(7)), ((RUNNING, 2), 100));
    module.stop();
    module.run_ticks(1000);
    assert_eq!((module.status_of_program(), module.variable(7)), ((STOPPED, 2), 100));
    module.ok(Command::ApplicationRun, 0, 0, 99);
    module.run_ticks(2);
    assert_eq!(
        (module.status_of_program(), module.variable(7)),
        ((RUNNING, 0), 101),
        "it had read and added"
    );
    module.run_from(1);
    module.run_ticks(2);
    assert_eq!(module.variable(7), 102, "A is kept (decisions 2a.19)");
}

/// §11.6: the three routines that a host calls by addresses 0, 1 and 2.
#[test]
fn the_three_routines_of_11_6() {
    let routines = [
        ja(3),
        ja(8),
        ja(12),
        mvp_abs(1000),
        wait(kind::POS, 0),
        mvp_abs(0),
        wait(kind::POS, 0),
        STOP,
        op(Command::RotateLeft, 0, 0, 500),
        wait(kind::TICKS, 100),
        op(Command::MotorStop, 0, 0, 0),
        STOP,
        op(Command::RotateRight, 0, 0, 1000),
        wait(kind::TICKS, 700),
        op(Command::MotorStop, 0, 0, 0),
        STOP,
    ];
    let mut module = Module::with_program(&routines);
    let mut farthest = 0;
    module.run_from(0);
    while module.status_of_program().0 == RUNNING {
        module.run_ticks(1);
        farthest = farthest.max(module.gap(Ap::ActualPosition));
    }
    assert_eq!((farthest, module.gap(Ap::ActualPosition)), (1000, 0));
    assert_eq!(module.status_of_program(), (STOPPED, 7));

    for (address, velocity, seconds, end) in [(1, -500, 1, 11), (2, 1000, 7, 15)] {
        module.run_ms(1000);
        let from = module.gap(Ap::ActualPosition);
        module.run_from(address);
        module.run_ms(500);
        assert_eq!(module.gap(Ap::ActualVelocity), velocity);
        let ticks = 10_000 + module.run_to_stop(200_000);
        // JA, ROL, MST and STOP take an instruction's time each, WAIT what it says.
        assert_eq!(ticks, seconds * 20_000 + 4);
        assert_eq!(module.status_of_program(), (STOPPED, end));
        module.run_ms(100);
        assert_eq!(module.gap(Ap::ActualVelocity), 0);
        let moved = module.gap(Ap::ActualPosition) - from;
        let expected = velocity * i32::try_from(seconds).unwrap();
        assert!((moved - expected).abs() <= 1, "{moved} instead of {expected} µsteps: both ramps alike");
    }
}

#[test]
fn steps_execute_one_instruction_each() {
    let program = [calc(kind::LOAD, 5), calc(kind::ADD, 1), keep(7), wait(kind::TICKS, 1), ja(0)];
    let mut module = Module::with_program(&program);
    for (next, a, kept) in [(1, 5, 0), (2, 6, 0), (3, 6, 6)] {
        module.step();
        module.run_ticks(3);
        assert_eq!(module.status_of_program(), (STEPPING, next));
        assert_eq!(module.ok(Command::Calculate, kind::ADD, 0, 0), a);
        assert_eq!(module.variable(7), kept);
    }
    // A WAIT is one step, however long it takes.
    module.step();
    module.run_ticks(WAIT_TICK - 2);
    assert_eq!(module.status_of_program(), (STEPPING, 3));
    module.run_ticks(4);
    assert_eq!(module.status_of_program(), (STEPPING, 4));
    module.run_ms(100);
    assert_eq!(module.status_of_program(), (STEPPING, 4), "nothing goes on by itself");
    module.step();
    module.run_ticks(3);
    assert_eq!(module.status_of_program(), (STEPPING, 0));
    // And from stepping to running.
    module.ok(Command::ApplicationRun, 0, 0, 0);
    module.run_ticks(2);
    assert_eq!(module.status_of_program(), (RUNNING, 2));
}

/// Two steps in no time are two instructions.
#[test]
fn steps_need_no_time_between() {
    let mut module = Module::with_program(&program(&[&count(7), &count(7), &[STOP]]));
    for _ in 0..6 {
        module.step();
    }
    module.run_ticks(5);
    assert_eq!((module.variable(7), module.status_of_program()), (2, (STEPPING, 6)));
    module.step();
    module.run_ticks(5);
    assert_eq!(module.status_of_program(), (STOPPED, 6), "STOP stops");
}

#[test]
fn reset_clears_counter_stack_registers_flags_and_interrupts() {
    let program = [
        jc(kind::ETO, 9),
        op(Command::ReturnFromSubroutine, 0, 0, 0), // ignored, unless a call was forgotten
        vect(0, 9),
        sgp(0, 3, 20),
        calc(kind::LOAD, 5),
        op(Command::CalculateX, kind::LOAD, 0, 0),
        wait(kind::LIMSW, 1), // sets ETO
        csub(8),
        wait(kind::TICKS, 1000),
        sgp(7, VARIABLES, 77),
        RETI,
    ];
    let mut module = Module::with_program(&program);
    module.run_from(0);
    module.run_ms(100);
    assert_eq!(module.status_of_program(), (RUNNING, 8));
    module.reset();
    assert_eq!(module.status_of_program(), (RESET, 0));
    module.run_ms(100);
    assert_eq!(module.status_of_program(), (RESET, 0));
    assert_eq!(module.ok(Command::Calculate, kind::ADD, 0, 0), 0, "A");
    module.ok(Command::CalculateX, 10, 0, 0);
    assert_eq!(module.ok(Command::Calculate, kind::ADD, 0, 0), 0, "X");
    module.ok(Command::ApplicationRun, 0, 0, 0);
    module.run_ms(100);
    assert_eq!(module.status_of_program(), (RUNNING, 8), "neither ETO nor the call was left");
    assert!(!marked(&mut module), "the timer is not enabled any more");
}

/// RUN keeps the flags (decisions 2a.19).
#[test]
fn run_keeps_the_flags() {
    let program = [jc(kind::ETO, 3), wait(kind::LIMSW, 1), STOP, sgp(7, VARIABLES, 77), STOP];
    let mut module = Module::with_program(&program);
    module.run_from(0);
    module.run_to_stop(300);
    assert!(!marked(&mut module));
    module.run_from(0);
    module.run_to_stop(10);
    assert!(marked(&mut module));
}
