//! Stand-alone programs: written with the commands' names, loaded over the wire, run and watched.

use tmcl_tables::{Command, GlobalParameter, Status};
use tmcl_wire::serial::{self, DATAGRAM_LENGTH};
use tmcl_wire::{Reply, Request};
use virtual_bench::{RefusedInstruction, TICK_NS};

use super::{MODULE, Module, VARIABLES};

/// Control periods in a tick of WAIT: 10 ms (§5.7.22).
pub(crate) const WAIT_TICK: u64 = 200;

/// The numbers of commands' types that programs name.
pub(crate) mod kind {
    /// JC.
    pub(crate) const ZE: u8 = 0;
    pub(crate) const NZ: u8 = 1;
    pub(crate) const NE: u8 = 3;
    pub(crate) const GE: u8 = 5;
    pub(crate) const LT: u8 = 6;
    pub(crate) const ETO: u8 = 8;
    pub(crate) const EDV: u8 = 10;
    pub(crate) const ESD: u8 = 12;
    /// CALC and CALCX.
    pub(crate) const ADD: u8 = 0;
    pub(crate) const SUB: u8 = 1;
    pub(crate) const MUL: u8 = 2;
    pub(crate) const LOAD: u8 = 9;
    /// WAIT.
    pub(crate) const TICKS: u8 = 0;
    pub(crate) const POS: u8 = 1;
    pub(crate) const REFSW: u8 = 2;
    pub(crate) const LIMSW: u8 = 3;
    pub(crate) const RFS: u8 = 4;
}

/// What EI and DI call all interrupts.
pub(crate) const ALL: u8 = 255;

/// An instruction by the fields that program text writes after its mnemonic, in the order type, motor, value.
pub(crate) const fn op(command: Command, kind: u8, motor: u8, value: i32) -> Request {
    Request::new(command, kind, motor, value)
}

pub(crate) const fn calc(operation: u8, value: i32) -> Request {
    op(Command::Calculate, operation, 0, value)
}

pub(crate) const fn comp(value: i32) -> Request {
    op(Command::Compare, 0, 0, value)
}

pub(crate) const fn jc(condition: u8, address: i32) -> Request {
    op(Command::JumpConditional, condition, 0, address)
}

pub(crate) const fn ja(address: i32) -> Request {
    op(Command::Jump, 0, 0, address)
}

pub(crate) const fn csub(address: i32) -> Request {
    op(Command::CallSubroutine, 0, 0, address)
}

pub(crate) const fn wait(kind: u8, ticks: i32) -> Request {
    op(Command::Wait, kind, 0, ticks)
}

pub(crate) const fn vect(interrupt: u8, address: i32) -> Request {
    op(Command::SetInterruptVector, interrupt, 0, address)
}

pub(crate) const fn ei(interrupt: u8) -> Request {
    op(Command::EnableInterrupt, interrupt, 0, 0)
}

pub(crate) const fn di(interrupt: u8) -> Request {
    op(Command::DisableInterrupt, interrupt, 0, 0)
}

/// SIO in bank 2.
pub(crate) const fn sio(port: u8, value: i32) -> Request {
    op(Command::SetOutput, port, 2, value)
}

pub(crate) const fn gio(port: u8, bank: u8) -> Request {
    op(Command::GetInput, port, bank, 0)
}

pub(crate) const fn sgp(number: u8, bank: u8, value: i32) -> Request {
    op(Command::SetGlobalParameter, number, bank, value)
}

pub(crate) const fn ggp(number: u8, bank: u8) -> Request {
    op(Command::GetGlobalParameter, number, bank, 0)
}

/// AGP to a user variable.
pub(crate) const fn keep(variable: u8) -> Request {
    op(Command::AccumulatorToGlobalParameter, variable, VARIABLES, 0)
}

pub(crate) const fn sap(parameter: u8, value: i32) -> Request {
    op(Command::SetAxisParameter, parameter, 0, value)
}

pub(crate) const fn gap(parameter: u8) -> Request {
    op(Command::GetAxisParameter, parameter, 0, 0)
}

pub(crate) const fn mvp_abs(position: i32) -> Request {
    op(Command::MoveToPosition, 0, 0, position)
}

pub(crate) const STOP: Request = op(Command::Stop, 0, 0, 0);
pub(crate) const RETI: Request = op(Command::ReturnFromInterrupt, 0, 0, 0);
pub(crate) const RSUB: Request = op(Command::ReturnFromSubroutine, 0, 0, 0);

/// Adds 1 to a user variable and leaves A at the sum.
pub(crate) const fn count(variable: u8) -> [Request; 3] {
    [ggp(variable, VARIABLES), calc(kind::ADD, 1), keep(variable)]
}

/// A list of instructions and lists of instructions.
pub(crate) fn program(parts: &[&[Request]]) -> Vec<Request> {
    parts.concat()
}

/// A routine of four instructions that counts in a variable.
pub(crate) fn counting(variable: u8) -> Vec<Request> {
    program(&[&count(variable), &[RETI]])
}

/// Interrupts on, and a loop of waiting, with the routines behind it: each counts in the variable of its place.
pub(crate) fn counters(interrupts: &[u8], setup: &[Request]) -> Vec<Request> {
    let loop_at = setup.len() + 2 * interrupts.len() + 1;
    let routines_at = loop_at + 2;
    let mut all = setup.to_vec();
    for (place, interrupt) in interrupts.iter().enumerate() {
        all.extend([vect(*interrupt, (routines_at + 4 * place) as i32), ei(*interrupt)]);
    }
    all.extend([ei(ALL), wait(kind::TICKS, 100), ja(loop_at as i32)]);
    for place in 0..interrupts.len() {
        all.extend(counting(place as u8));
    }
    all
}

/// A module on which [`counters`] has run for a millisecond.
#[track_caller]
pub(crate) fn listening(mut module: Module, interrupts: &[u8], setup: &[Request]) -> Module {
    module.download(&counters(interrupts, setup));
    module.run_from(0);
    module.run_ms(1);
    assert_eq!(module.refused(), []);
    module
}

impl Module {
    /// A module with this program in its memory from address 0 on.
    #[track_caller]
    pub(crate) fn with_program(instructions: &[Request]) -> Self {
        let mut module = Self::new();
        module.download(instructions);
        module
    }

    /// 132, the instructions, 133.
    #[track_caller]
    pub(crate) fn download(&mut self, instructions: &[Request]) {
        self.download_at(0, instructions);
    }

    /// 132, the instructions, 133.
    #[track_caller]
    pub(crate) fn download_at(&mut self, address: i32, instructions: &[Request]) {
        self.ok(Command::DownloadStart, 0, 0, address);
        for instruction in instructions {
            self.load(*instruction);
        }
        self.ok(Command::DownloadEnd, 0, 0, 0);
    }

    /// An instruction that must be stored: status 101, and the value that was sent.
    #[track_caller]
    pub(crate) fn load(&mut self, instruction: Request) {
        let reply = Reply { status: Status::Loaded, command: instruction.command, value: instruction.value };
        assert_eq!(self.replies(instruction), [reply], "{instruction:?}");
    }

    /// 129, type 1.
    #[track_caller]
    pub(crate) fn run_from(&mut self, address: i32) {
        self.ok(Command::ApplicationRun, 1, 0, address);
    }

    /// 128.
    #[track_caller]
    pub(crate) fn stop(&mut self) {
        self.ok(Command::ApplicationStop, 0, 0, 0);
    }

    /// 130.
    #[track_caller]
    pub(crate) fn step(&mut self) {
        self.ok(Command::ApplicationStep, 0, 0, 0);
    }

    /// 131.
    #[track_caller]
    pub(crate) fn reset(&mut self) {
        self.ok(Command::ApplicationReset, 0, 0, 0);
    }

    /// 135: mode and program counter, which must be what global parameters 128 and 130 say.
    #[track_caller]
    pub(crate) fn status_of_program(&mut self) -> (i32, i32) {
        let status = self.ok(Command::ApplicationStatus, 0, 0, 0);
        let (mode, counter) = (status >> 24, status & 0xFF_FFFF);
        assert_eq!(self.ggp(GlobalParameter::ApplicationStatus), mode);
        assert_eq!(self.ggp(GlobalParameter::ProgramCounter), counter);
        (mode, counter)
    }

    /// 134, which must be answered with an instruction.
    #[track_caller]
    pub(crate) fn read_instruction(&mut self, address: i32) -> Request {
        let request = Request::new(Command::ReadProgramMemory, 0, 0, address);
        let bytes = self.exchange(&serial::encode_request(self.address, request));
        let datagram: [u8; DATAGRAM_LENGTH] = bytes.try_into().expect("nine bytes");
        let (host, instruction) = serial::decode_instruction(datagram).expect("an intact instruction");
        assert_eq!(host, self.host);
        Request::from_bytes(instruction)
    }

    /// GGP, asked over another port, since this one downloads.
    #[track_caller]
    pub(crate) fn ggp_while_downloading(&mut self, parameter: GlobalParameter) -> i32 {
        let port = self.port;
        self.port = virtual_bench::PortId::ALL[3];
        let value = self.ggp(parameter);
        self.port = port;
        value
    }

    /// Writes a user variable.
    #[track_caller]
    pub(crate) fn set_variable(&mut self, number: u8, value: i32) {
        self.ok(Command::SetGlobalParameter, number, VARIABLES, value);
    }

    /// What the program was refused.
    pub(crate) fn refused(&self) -> Vec<(u16, Status, u64)> {
        let refused = self.bench.refused_instructions(MODULE);
        refused.map(|RefusedInstruction { address, status, count, .. }| (address, status, count)).collect()
    }

    /// Runs for `ticks` and returns the ticks at which an output, as the module reports it, changed, and to what.
    pub(crate) fn edges(&mut self, output: u8, ticks: u64) -> Vec<(u64, bool)> {
        let name = format!("output.{output}");
        let probe = self.bench.probe(&name).expect("an output");
        let mut level = self.bench.read(probe) != 0.0;
        let mut edges = Vec::new();
        for _ in 0..ticks {
            self.run_ticks(1);
            let now = self.bench.read(probe) != 0.0;
            if now != level {
                level = now;
                edges.push((self.bench.time_ns() / TICK_NS, level));
            }
        }
        edges
    }

    /// Runs until the program has stopped, at most so many ticks, and returns how many it took.
    #[track_caller]
    pub(crate) fn run_to_stop(&mut self, at_most: u64) -> u64 {
        for ticks in 0..=at_most {
            if self.ggp(GlobalParameter::ApplicationStatus) == 0 {
                return ticks;
            }
            self.run_ticks(1);
        }
        panic!("the program runs on: {:?}", self.status_of_program());
    }

    /// All state there is, to the last bit: floating point prints so that it reads back the same.
    pub(crate) fn state(&self) -> String {
        format!("{:?}", self.bench)
    }
}
