//! Power-on: factory settings, then what the storage holds over them.

use core::mem::MaybeUninit;

use tmcl_tables::{GlobalParameter, ParameterSpec};
use tmcl_vm::Vm;

use crate::axis::Axis;
use crate::coordinates::{self, Coordinates};
use crate::download::READ_PROTECTION;
use crate::events::Sources;
use crate::firmware::Firmware;
use crate::globals::{MAGIC, VARIABLE_BANK};
use crate::line::Rates;
use crate::program_memory::ProgramMemory;
use crate::storage::{RecordKey, Storage, read_value, write_value};

impl<A: Axis> Firmware<A> {
    /// The module as it is after power-on with this storage.
    ///
    /// A magic number (global parameter 64) other than 228 makes it forget everything stored first. If the power fails
    /// while it does, the number is still wrong at the next power-on, and it begins again.
    pub fn power_on<S: Storage>(storage: &mut S) -> Self {
        let mut firmware = Self::as_made();
        firmware.load(storage);
        firmware
    }

    /// [`Firmware::power_on`] in the place where the module is to stay. A controller's stack need not hold it twice then.
    pub fn power_on_in<'a, S: Storage>(place: &'a mut MaybeUninit<Self>, storage: &mut S) -> &'a mut Self {
        let firmware = Self::write_as_made(place);
        firmware.load(storage);
        firmware
    }

    /// [`Firmware::power_on`] in the place of a module that was switched off.
    pub fn power_on_again<S: Storage>(&mut self, storage: &mut S) {
        self.make_anew();
        self.load(storage);
    }

    /// By itself, so that what it needs of the stack is given back before the storage is read.
    #[inline(never)]
    fn write_as_made(place: &mut MaybeUninit<Self>) -> &mut Self {
        place.write(Self::as_made())
    }

    /// By itself, likewise.
    #[inline(never)]
    fn make_anew(&mut self) {
        *self = Self::as_made();
    }

    fn load<S: Storage>(&mut self, storage: &mut S) {
        self.restore(storage);
        self.rates = Rates::of(&self.globals);
    }

    /// As after power-on, but for what still leaves the ports and the rates it leaves at. In place: a module is larger than
    /// the stack of its controller.
    pub(crate) fn restart<S: Storage>(&mut self, storage: &mut S) {
        let Self {
            axis,
            globals: _,
            coordinates: _,
            vm,
            programs: _,
            download,
            program_job,
            refusal,
            sources,
            instructions_per_tick: _,
            executed,
            ticks,
            ports,
            starts_in_ascii: _,
            rates: _,
            heartbeat: _,
            pending,
            upkeep,
        } = self;
        ports.iter_mut().for_each(|port| port.restart(*ticks));
        write_default(axis);
        *vm = Vm::default();
        *sources = Sources::default();
        (*download, *program_job, *refusal) = (None, None, None);
        (*pending, *upkeep) = (None, None);
        (*executed, *ticks) = (0, 0);
        self.restore(storage);
    }

    /// Puts what is stored over the factory settings.
    fn restore<S: Storage>(&mut self, storage: &mut S) {
        forget_if_magic_is_wrong(storage);
        self.restore_globals(storage);
        self.restore_coordinates(storage);
        for parameter in A::SPEC.axis_parameters.iter().filter(|parameter| parameter.access.store) {
            if let Some((parameter, stored, default)) =
                stored_axis_parameter::<A, S>(parameter.number, storage)
            {
                self.axis.restore_at_power_on(parameter, stored, default);
            }
        }
        self.axis.set_end_switch_polarity(self.globals.setting(GlobalParameter::EndSwitchPolarity) != 0);
        // A program that cannot be read is none: all STOP.
        if self.programs.restore(storage).is_err() {
            self.programs.erase();
        }
        if self.globals.setting(GlobalParameter::AutoStart) != 0 {
            self.vm.run_from(0);
        }
        self.restart_heartbeat();
        self.start_ports();
    }

    fn restore_globals<S: Storage>(&mut self, storage: &mut S) {
        self.globals.reset(A::SPEC);
        for parameter in GlobalParameter::ALL {
            let (bank, number) = parameter.address();
            let Some(entry) = A::SPEC.global_parameter(bank, number) else { continue };
            if let Some(value) = read_value(storage, RecordKey::Global(bank, number))
                && entry.parameter.access.store
                && is_possible(&entry.parameter, value)
            {
                self.globals.restore(*parameter, value);
            }
        }
        if self.globals.setting(GlobalParameter::DoNotRestoreVariables) == 0 {
            let variables = A::SPEC.global_parameters.iter().filter(|entry| entry.bank == VARIABLE_BANK);
            for entry in variables.filter(|entry| entry.parameter.access.store) {
                for number in entry.parameter.number..=entry.last {
                    let value = read_value(storage, RecordKey::Global(VARIABLE_BANK, number));
                    self.globals.set_variable(number, value.unwrap_or(0));
                }
            }
        }
    }

    fn restore_coordinates<S: Storage>(&mut self, storage: &mut S) {
        self.coordinates = Coordinates::new();
        if self.globals.setting(GlobalParameter::CoordinateStorage) != 0 {
            for number in 1..coordinates::COUNT {
                let value = read_value(storage, RecordKey::Coordinate(number));
                self.coordinates.set(number, value.unwrap_or(0));
            }
        }
    }

    /// Puts a stored axis parameter back, or its default where none is stored or what is stored is out of range.
    pub(crate) fn restore_axis_parameter<S: Storage>(&mut self, number: u8, storage: &mut S) {
        if let Some((parameter, stored, default)) = stored_axis_parameter::<A, S>(number, storage) {
            self.axis.restore(parameter, stored, default);
        }
    }
}

/// An axis parameter with what is stored of it, if that is in range, and its default.
fn stored_axis_parameter<A: Axis, S: Storage>(
    number: u8,
    storage: &mut S,
) -> Option<(A::Parameter, Option<i32>, i32)> {
    let spec = A::SPEC.axis_parameter(number)?;
    let parameter = A::Parameter::try_from(number).ok()?;
    let stored = read_value(storage, RecordKey::Axis(number)).filter(|value| is_possible(spec, *value));
    Some((parameter, stored, spec.default_bits()))
}

fn is_possible(spec: &ParameterSpec, bits: i32) -> bool {
    spec.range.contains(spec.from_wire(bits))
}

fn stored(storage: &mut impl Storage, parameter: GlobalParameter) -> Option<i32> {
    let (bank, number) = parameter.address();
    read_value(storage, RecordKey::Global(bank, number))
}

fn forget_if_magic_is_wrong<S: Storage>(storage: &mut S) {
    let (bank, number) = GlobalParameter::EepromMagic.address();
    let key = RecordKey::Global(bank, number);
    if read_value(storage, key).is_none_or(|magic| magic == MAGIC) {
        return;
    }
    // The factory settings protect no program; what was protected from reading back must not become readable.
    let protected = stored(storage, GlobalParameter::CodeProtection)
        .is_some_and(|protection| protection & READ_PROTECTION != 0);
    if protected && storage.erase_program().is_err() {
        return;
    }
    if storage.erase().is_ok() {
        // Without the record the settings are the factory's just as well.
        let _ = write_value(storage, key, MAGIC);
    }
}

/// By itself, so that what it needs of the stack is given back before the storage is read.
#[inline(never)]
fn write_default<T: Default>(place: &mut T) {
    *place = T::default();
}
