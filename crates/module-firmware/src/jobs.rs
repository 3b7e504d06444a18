//! What takes long: one record at a time is written to or read from the storage, and then a request is answered or the
//! program goes on.

use tmcl_tables::{GlobalParameter, Status};
use tmcl_wire::Reply;

use crate::application::{ProgramJob, Refusal};
use crate::axis::Axis;
use crate::envelope::Envelope;
use crate::firmware::Firmware;
use crate::globals::VARIABLE_BANK;
use crate::port::PortId;
use crate::program_memory::{Instruction, ProgramMemory};
use crate::storage::{RecordKey, Storage, StorageError, read_value, write_value};

/// What the storage shall do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Job {
    /// Write a record.
    Write(RecordKey, i32),
    /// Write an instruction of the program.
    WriteInstruction(u16, Instruction),
    /// Erase the program, and then write a record.
    EraseProgram(RecordKey, i32),
    /// Read an axis parameter back, or its default where none is stored.
    RestoreAxisParameter(u8),
    /// Read a user variable back, or 0 where none is stored.
    RestoreVariable(u8),
    /// Write coordinates `next..=last`, one a call.
    StoreCoordinates { next: u8, last: u8 },
    /// Read coordinates `first..=last` back.
    RestoreCoordinates { first: u8, last: u8 },
    /// Spoil the magic number and start anew, which finds the spoiled number and takes the factory settings.
    FactoryReset,
    /// Start anew.
    Restart,
}

/// A request whose reply waits for the storage.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pending {
    pub(crate) port: PortId,
    pub(crate) envelope: Envelope,
    pub(crate) reply: Reply,
    pub(crate) job: Job,
}

/// How far a job got in one call.
enum Progress {
    /// Call again with this.
    More(Job),
    /// Done.
    Done,
    /// Done, and everything starts anew.
    Restart,
}

impl<A: Axis> Firmware<A> {
    /// What takes long: at most one record is written, and then its reply sent. True while there is more to do.
    pub fn background<S: Storage>(&mut self, storage: &mut S) -> bool {
        // A host goes first, or a program that stores all the time would keep it waiting for ever.
        if let Some(pending) = self.pending.take() {
            self.work(pending, storage);
        } else if let Some(job) = self.program_job.take() {
            self.work_for_program(job, storage);
        } else if let Some(job) = self.upkeep.take() {
            // A medium that takes no more has nobody to tell.
            let _ = self.step(job, storage);
        }
        if !self.has_background_work() {
            PortId::ALL.into_iter().for_each(|port| self.serve(port));
            // Events that found no room may find some now.
            self.report_position_reached();
            self.settle_rates();
        }
        self.has_background_work()
    }

    /// Whether [`Firmware::background`] has something to do.
    #[must_use]
    pub fn has_background_work(&self) -> bool {
        self.pending.is_some() || self.program_job.is_some() || self.upkeep.is_some()
    }

    fn work<S: Storage>(&mut self, pending: Pending, storage: &mut S) {
        let Pending { port, envelope, reply, job } = pending;
        match self.step(job, storage) {
            Ok(Progress::More(job)) => self.pending = Some(Pending { job, ..pending }),
            Ok(Progress::Done) => self.answer(port, envelope, reply),
            Ok(Progress::Restart) => {
                self.answer(port, envelope, reply);
                self.rates.await_port(port);
                self.restart(storage);
            }
            Err(_) => {
                let refusal = Reply { status: Status::NotAvailable, value: 0, ..reply };
                self.answer(port, envelope, refusal);
            }
        }
    }

    fn work_for_program<S: Storage>(&mut self, ProgramJob { address, job }: ProgramJob, storage: &mut S) {
        match self.step(job, storage) {
            Ok(Progress::More(job)) => self.program_job = Some(ProgramJob { address, job }),
            Ok(Progress::Done) => {}
            Ok(Progress::Restart) => self.restart(storage),
            Err(_) => self.refusal = Some(Refusal { address, status: Status::NotAvailable }),
        }
    }

    fn step<S: Storage>(&mut self, job: Job, storage: &mut S) -> Result<Progress, StorageError> {
        match job {
            Job::Write(key, value) => write_value(storage, key, value)?,
            Job::WriteInstruction(address, instruction) => {
                storage.write_instruction(address, instruction)?;
                self.programs.set(address, instruction);
            }
            Job::EraseProgram(key, value) => {
                // What is protected must not become readable even if the medium fails.
                self.programs.erase();
                storage.erase_program()?;
                return Ok(Progress::More(Job::Write(key, value)));
            }
            Job::RestoreAxisParameter(number) => self.restore_axis_parameter(number, storage),
            Job::RestoreVariable(number) => {
                let value = read_value(storage, RecordKey::Global(VARIABLE_BANK, number));
                self.globals.set_variable(number, value.unwrap_or(0));
            }
            Job::StoreCoordinates { next, last } => {
                write_value(storage, RecordKey::Coordinate(next), self.coordinates.get(next))?;
                if next < last {
                    return Ok(Progress::More(Job::StoreCoordinates { next: next + 1, last }));
                }
            }
            Job::RestoreCoordinates { first, last } => {
                for number in first..=last {
                    let value = read_value(storage, RecordKey::Coordinate(number));
                    self.coordinates.set(number, value.unwrap_or(0));
                }
            }
            Job::FactoryReset => {
                let (bank, number) = GlobalParameter::EepromMagic.address();
                write_value(storage, RecordKey::Global(bank, number), 0)?;
                return Ok(Progress::Restart);
            }
            Job::Restart => return Ok(Progress::Restart),
        }
        Ok(Progress::Done)
    }
}
