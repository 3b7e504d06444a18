//! SGP, GGP, STGP, RSGP and AGP (TMCM-1311 §5.7.9 to §5.7.12, §5.7.30).

use tmcl_tables::{GlobalParameter, GlobalSpec, Status};
use tmcl_wire::Request;

use super::{Executed, Outcome, in_range, readable, storable};
use crate::axis::Axis;
use crate::download::READ_PROTECTION;
use crate::firmware::Firmware;
use crate::globals::VARIABLE_BANK;
use crate::jobs::Job;
use crate::storage::RecordKey;

impl<A: Axis> Firmware<A> {
    /// SGP and AGP. Bank 0 is stored at once, as far as the EEPROM keeps it (TMCM-1311 §10.1).
    pub(super) fn set_global_parameter(&mut self, request: &Request, value: i32, answer: i32) -> Executed {
        let &Request { kind: number, motor: bank, .. } = request;
        let spec = &global_spec::<A>(bank, number)?.parameter;
        if !spec.access.write {
            return Err(Status::WrongType);
        }
        let stored = bank == 0 && spec.access.store;
        let locks = GlobalParameter::EepromLock.address() == (bank, number);
        if stored && !locks {
            self.unlocked()?;
        }
        in_range(spec, value)?;
        if bank == VARIABLE_BANK {
            self.globals.set_variable(number, value);
            return Ok(Outcome::Done(answer));
        }
        let parameter = GlobalParameter::from_address(bank, number).ok_or(Status::WrongType)?;
        let before = self.globals.setting(parameter);
        self.globals.write(parameter, value, self.ticks);
        self.apply(parameter, value);
        if !stored {
            return Ok(Outcome::Done(answer));
        }
        let (key, kept) = (RecordKey::Global(bank, number), self.globals.setting(parameter));
        if parameter == GlobalParameter::CodeProtection && before & !kept & READ_PROTECTION != 0 {
            self.vm.stop();
            return Ok(Outcome::Job(Job::EraseProgram(key, kept), answer));
        }
        Ok(Outcome::Job(Job::Write(key, kept), answer))
    }

    /// What follows at once from a setting.
    fn apply(&mut self, parameter: GlobalParameter, value: i32) {
        match parameter {
            GlobalParameter::EndSwitchPolarity => self.axis.set_end_switch_polarity(value != 0),
            GlobalParameter::Timer0Period => self.sources.set_timer(0, value, self.ticks),
            GlobalParameter::Timer1Period => self.sources.set_timer(1, value, self.ticks),
            GlobalParameter::Timer2Period => self.sources.set_timer(2, value, self.ticks),
            GlobalParameter::SerialAddress => self.leave_ascii_without_letter(),
            GlobalParameter::SerialHeartbeat => self.restart_heartbeat(),
            GlobalParameter::InterfaceSelection => self.select_interface(),
            _ => {}
        }
    }

    pub(super) fn get_global_parameter(&mut self, request: &Request) -> Executed {
        let &Request { kind: number, motor: bank, .. } = request;
        readable(&global_spec::<A>(bank, number)?.parameter)?;
        if bank == VARIABLE_BANK {
            return Ok(Outcome::Done(self.globals.variable(number)));
        }
        let parameter = GlobalParameter::from_address(bank, number).ok_or(Status::WrongType)?;
        let program = self.program_status();
        Ok(Outcome::Done(self.globals.read(parameter, self.ticks, program)))
    }

    /// STGP: bank 0 is stored already, so that only user variables have something to do.
    pub(super) fn store_global_parameter(&self, request: &Request) -> Executed {
        let &Request { kind: number, motor: bank, value, .. } = request;
        let spec = &global_spec::<A>(bank, number)?.parameter;
        if bank != 0 {
            storable(spec)?;
        }
        self.unlocked()?;
        if bank != VARIABLE_BANK {
            return Ok(Outcome::Done(value));
        }
        let key = RecordKey::Global(VARIABLE_BANK, number);
        Ok(Outcome::Job(Job::Write(key, self.globals.variable(number)), value))
    }
}

/// RSGP: bank 0 needs no restoring, bank 2 is read back where it can be stored.
pub(super) fn restore_global_parameter<A: Axis>(request: &Request) -> Executed {
    let &Request { kind: number, motor: bank, value, .. } = request;
    let spec = &global_spec::<A>(bank, number)?.parameter;
    match bank {
        0 => Ok(Outcome::Done(value)),
        VARIABLE_BANK => storable(spec).map(|()| Outcome::Job(Job::RestoreVariable(number), value)),
        _ => Err(Status::WrongType),
    }
}

fn global_spec<A: Axis>(bank: u8, number: u8) -> Result<&'static GlobalSpec, Status> {
    A::SPEC.global_parameter(bank, number).ok_or(Status::WrongType)
}
