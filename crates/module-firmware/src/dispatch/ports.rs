//! SIO and GIO (TMCM-1311 §5.7.14, §5.7.15).

use tmcl_tables::{Direction, PortSpec, Status};
use tmcl_wire::Request;

use super::{Executed, Outcome};
use crate::axis::Axis;
use crate::firmware::Firmware;

/// The port number that means all of a bank.
const ALL_PORTS: u8 = 255;

const INPUT_BANK: u8 = 0;
const OUTPUT_BANK: u8 = 2;

impl<A: Axis> Firmware<A> {
    pub(super) fn set_output(&mut self, request: &Request) -> Executed {
        let &Request { kind: number, motor: bank, value, .. } = request;
        if (bank, number) == (OUTPUT_BANK, ALL_PORTS) && !outputs::<A>().is_empty() {
            let levels = match value {
                -1 => self.vm.registers.accumulator & 0xFF,
                0..=255 => value,
                _ => return Err(Status::InvalidValue),
            };
            for spec in outputs::<A>() {
                if let Some(port) = A::port(spec.bank, spec.number) {
                    self.axis.write_port(port, (levels >> spec.number) & 1 == 1);
                }
            }
            return Ok(Outcome::Done(value));
        }
        let (port, spec) = port::<A>(bank, number)?;
        if spec.direction != Direction::Output {
            return Err(Status::WrongType);
        }
        if !spec.range.contains(i64::from(value)) {
            return Err(Status::InvalidValue);
        }
        self.axis.write_port(port, value != 0);
        Ok(Outcome::Done(value))
    }

    pub(super) fn get_input(&self, request: &Request) -> Executed {
        let &Request { kind: number, motor: bank, .. } = request;
        if (bank, number) == (INPUT_BANK, ALL_PORTS) && !outputs::<A>().is_empty() {
            let bits = A::SPEC.ports.iter().filter(|spec| spec.bank == INPUT_BANK).map(|spec| {
                let level = A::port(spec.bank, spec.number).map_or(0, |port| self.axis.read_port(port));
                (level & 1) << spec.number
            });
            return Ok(Outcome::Done(bits.fold(0, |all, bit| all | bit)));
        }
        let (port, _) = port::<A>(bank, number)?;
        Ok(Outcome::Done(self.axis.read_port(port)))
    }
}

fn port<A: Axis>(bank: u8, number: u8) -> Result<(A::Port, &'static PortSpec), Status> {
    A::port(bank, number).zip(A::SPEC.port(bank, number)).ok_or(Status::WrongType)
}

/// The module's outputs, which stand together in the table.
fn outputs<A: Axis>() -> &'static [PortSpec] {
    let start = A::SPEC.ports.partition_point(|port| port.bank < OUTPUT_BANK);
    A::SPEC.ports.get(start..).unwrap_or(&[])
}
